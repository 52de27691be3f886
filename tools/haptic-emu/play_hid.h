/** @file
 * Played HID devices before the kernel, each with somebody at it: what the subcommands of haptic-emu do.
 */
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "rt/base/error.h"

namespace haptic_emu {

struct HidPlay {
  std::string device;  ///< woodyhid, spacemouse or hidpid.
  std::string kind;    ///< wooden2015 or polhem3; old or new; joystick or wheel.
  std::string serial = "emu0001";
  std::vector<std::string> faults;
  double press = 0.01;  ///< How far the hand goes and back [m].
  double period_s = 2;  ///< Of that.
  double every_s = 1;   ///< Between two lines; 0 for none.
};

/** Until `stop`. kInvalidArgument for a fault that is none; else as playToUhid(). */
[[nodiscard]] hapticd::Result<void> playHid(const HidPlay& play, const std::atomic<bool>& stop);

}  // namespace haptic_emu
