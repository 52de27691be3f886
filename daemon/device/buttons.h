/** @file
 * How many buttons a device has, as clients and the clutch count them.
 */
#pragma once

#include <cstdint>

#include "rt/cycle/safety_lines.h"
#include "rt/device.h"

namespace hapticd {

/** Its own and, after them, the panel's: all of these or, where both are more than 32, none, as Servo adds them. */
[[nodiscard]] inline std::uint32_t buttonsOf(const DeviceInfo& info, const SafetyLines* lines) {
  const std::uint32_t panel = lines == nullptr ? 0 : lines->button_count.load(std::memory_order_relaxed);
  return info.buttons + panel <= 32 ? info.buttons + panel : info.buttons;
}

}  // namespace hapticd
