/** @file
 * Reports of the PID class, filled in as the layout says. Pure, bounded, no allocation.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/hidpid/pid_layout.h"

namespace hapticd::pid {

/** A report with its ID first, 0 where the device numbers none. */
class Report {
 public:
  static constexpr std::size_t kLongest = 128;

  Report() = default;
  /** As long as `layout` has its reports; ID of `field`. */
  Report(const HidField& field, std::size_t bytes) noexcept;

  [[nodiscard]] std::span<const std::uint8_t> bytes() const HD_RT { return {bytes_.data(), size_}; }
  void set(const Field& field, std::int32_t value) HD_RT;
  /** -1 to 1 of the field's range; 0 to 1 if that has no negative part. */
  void setShare(const Field& field, double share) HD_RT;
  void set(const Choice& choice) HD_RT { set(choice.field, choice.value); }

 private:
  std::array<std::uint8_t, kLongest> bytes_{};
  std::size_t size_ = 0;
};

/** Lengths of the reports, which a Layout's fields do not know. */
struct Lengths {
  std::size_t effect = 0, constant = 0, condition = 0, operation = 0, control = 0, gain = 0, create = 0, load = 0;
};
/** kUnsupported if one is longer than Report::kLongest. */
[[nodiscard]] Result<Lengths> lengthsOf(const HidReports& reports, const Layout& layout);

/** Bounded in time always: a device that is forgotten ends its effects itself. */
struct EffectSetting {
  Effect effect = Effect::kConstant;
  std::size_t axis = 0;
  std::int32_t duration_ms = 0;
  std::int32_t block = 0;
};

/** All shares of the device's full force. */
struct ConditionSetting {
  std::int32_t block = 0;
  std::size_t axis = 0;
  double centre = 0, coefficient = 0, saturation = 0;
};

class Encoder {
 public:
  Encoder() = default;
  Encoder(const Layout& layout, const Lengths& lengths) : l_(layout), n_(lengths) {}

  [[nodiscard]] Report effect(const EffectSetting& setting) const HD_RT;
  [[nodiscard]] Report constant(std::int32_t block, double share) const HD_RT;
  [[nodiscard]] Report condition(const ConditionSetting& setting) const HD_RT;
  [[nodiscard]] Report start(std::int32_t block) const HD_RT;
  [[nodiscard]] Report stop(std::int32_t block) const HD_RT;
  [[nodiscard]] Report control(Control what) const HD_RT;
  [[nodiscard]] Report fullGain() const HD_RT;
  [[nodiscard]] Report create(Effect effect) const HD_RT;
  /** To be filled by the device. */
  [[nodiscard]] Report load() const HD_RT;

 private:
  Layout l_;
  Lengths n_;
};

}  // namespace hapticd::pid
