/** @file
 * Troubles on the wire as faults of a played device.
 */
#pragma once

#include <cstdint>

#include "drivers/link/io_device.h"
#include "tests/conformance/rig.h"
#include "tools/haptic-emu/fault.h"

namespace hapticd::test {

/** From now on, or no more. */
inline void makeTrouble(haptic_emu::FaultPlan& faults, Trouble trouble, bool on) {
  using haptic_emu::FaultKind;
  const FaultKind kind = trouble == Trouble::kSilence      ? FaultKind::kSilence
                         : trouble == Trouble::kGarbage    ? FaultKind::kGarbage
                         : trouble == Trouble::kTruncation ? FaultKind::kTruncation
                                                           : FaultKind::kEncoderJump;
  if (on) {
    faults.add({kind, 0, INT64_MAX});
  } else {
    faults.clear();
  }
}

/** Bytes that went wrong and readings that were refused. */
inline std::uint64_t complaintsOf(const LinkCounters& counters) {
  return counters.dropped_bytes.load() + counters.rejected.load() + counters.lost.load();
}

}  // namespace hapticd::test
