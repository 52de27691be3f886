/** @file
 * The report descriptor of a played force-feedback joystick, as the family of Arduino and OpenFFBoard firmware writes
 * it, with the ways in which others differ.
 */
#pragma once

#include <cstdint>
#include <vector>

namespace haptic_emu {

/** Of the axes, where the buttons have a report of their own. */
inline constexpr int kAxesApart = 99;

/** How this one differs. */
struct PidVariant {
  bool start_delay = true;
  bool block_offset = true;
  bool negative_coefficient = true, saturation = true, dead_band = true;
  bool control_in_bits = false;
  bool switches = true;        ///< Its actuators can be switched on and off; else they are always on.
  bool conditions = true;      ///< Spring and damper at all.
  bool buttons_apart = false;  ///< In a report of their own, sent when one changes.
  int axes = 2;
  int time_exponent = -3;  ///< Of ten: its unit of time in seconds.
  int pool = 16;           ///< Effects that it has room for.
};

[[nodiscard]] std::vector<std::uint8_t> pidDescriptor(const PidVariant& variant);

}  // namespace haptic_emu
