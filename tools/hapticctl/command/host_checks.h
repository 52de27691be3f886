/** @file
 * What this machine must have for a servo to keep its deadlines: checked by hapticctl itself, with or without a daemon.
 */
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {

enum class CheckState { kGreen, kRed, kNotApplicable };

struct HostCheck {
  std::string name;
  CheckState state = CheckState::kNotApplicable;
  std::string detail;  ///< What was found.
  std::string remedy;  ///< The one line that fixes it, when red.
};

/** Where to look: the real system, or a made-up one under `root` (tests). */
struct HostView {
  std::string root;            ///< Prefix of /proc, /sys, /dev, /etc, /usr.
  std::string kernel_version;  ///< As uname() has it, which is asked where this is empty.
};

[[nodiscard]] std::vector<HostCheck> hostChecks(const HostView& view = {});
/** When a process was started; nothing where the kernel does not say. */
[[nodiscard]] std::optional<std::chrono::system_clock::time_point> startOf(int pid);
/** Whether the configuration of a daemon that was started then has been edited since. It is read once. */
[[nodiscard]] HostCheck configurationCheck(const std::string& file,
                                           std::optional<std::chrono::system_clock::time_point> started);
[[nodiscard]] const char* stateName(CheckState state);
[[nodiscard]] Json toJson(const std::vector<HostCheck>& checks);

}  // namespace hapticctl
