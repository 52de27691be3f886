/** @file
 * Where a force-feedback device keeps what USB's PID class (Physical Interface Devices 1.0) talks of, by its report
 * descriptor alone: report IDs, widths and ranges differ from maker to maker. Pure; fuzzed.
 */
#pragma once

#include <array>
#include <cstdint>

#include "drivers/hid/report_descriptor.h"

namespace hapticd::pid {

/** A field, or none. Holds a copy without the list of choices: the servo's side needs no descriptor. */
struct Field {
  HidField field;
  bool there = false;
};

/** One of several values: an array's number, or a bit of its own where a maker wrote it so (a quirk of some wheels). */
struct Choice {
  Field field;
  std::int32_t value = 0;
  [[nodiscard]] bool there() const noexcept { return field.there; }
};

/** What a device lacks or has its own way; found in the descriptor, but for the last. */
struct Quirks {
  bool no_start_delay = false;
  bool no_block_offset = false;
  bool no_negative_coefficient = false;
  bool no_saturation = false;
  bool no_dead_band = false;
  bool control_in_bits = false;
  bool fixed_direction = false;  ///< Wants 90 degrees whatever the axis; not in the descriptor.
};

enum class Effect : std::uint8_t { kConstant, kSpring, kDamper };
inline constexpr std::size_t kEffects = 3;
enum class Control : std::uint8_t { kEnable, kDisable, kStopAll, kReset };
inline constexpr std::size_t kControls = 4;
inline constexpr std::size_t kMostAxes = 2;

/** Constant forces end by themselves so soon, and what takes over from a late servo. */
inline constexpr std::int32_t kHold_ms = 100, kFallback_ms = 200;

/** All that the driver speaks of. `there` false: the device has no such thing. */
struct Layout {
  // Set Effect
  Field effect_block, duration, gain, trigger_repeat, sample_period, start_delay, direction_enable;
  std::array<Choice, kEffects> effect_type;
  std::array<Field, kMostAxes> axis_enable, direction;
  // Set Constant Force
  Field constant_block, magnitude;
  // Set Condition
  Field condition_block, block_offset, centre, positive_coefficient, negative_coefficient, positive_saturation,
      negative_saturation, dead_band;
  // Effect Operation, Device Control, Device Gain
  Field operation_block, loop_count, device_gain;
  Choice start, stop;
  std::array<Choice, kControls> control;
  // Features: Create New Effect, Block Load
  std::array<Choice, kEffects> new_type;
  Field loaded_block;
  Choice load_success, load_full;
  // Input: axes, buttons, state
  std::array<Field, kMostAxes> axis;
  std::array<Field, 32> button;
  Field safety_switch, actuator_power;
  double duration_per_ms = 1;  ///< What `duration` takes for a millisecond.
  std::size_t axes = 0, buttons = 0;
  Quirks quirks;
  bool numbered = false;
};

/** Whether it is such a device at all. */
[[nodiscard]] bool hasForceFeedback(const HidReports& reports) noexcept;
/** kUnsupported names what is missing for constant forces. */
[[nodiscard]] Result<Layout> layoutOf(const HidReports& reports);

}  // namespace hapticd::pid
