/** @file
 * What the daemon tells of itself: state, statistics and the checks that only it can make.
 */
#pragma once

#include "daemon/rpc/convert.h"

namespace hapticd {

void writeInfo(proto::DaemonInfo::Builder out, Core& core, bool administration);
void writeState(proto::DaemonState::Builder out, Core& core, bool administration);
void writeStatistics(proto::Statistics::Builder out, const OpenDevice& device);
void resetStatistics(OpenDevice& device);

/** One line of doctor. */
struct CheckLine {
  std::string name;
  proto::Check::State state = proto::Check::State::GREEN;
  std::string detail;
  std::string remedy;
};
[[nodiscard]] std::vector<CheckLine> makeChecks(Core& core);

}  // namespace hapticd
