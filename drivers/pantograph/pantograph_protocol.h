/** @file
 * What the open two-motor boards of Haply's development kit (2DIY pantograph) are told and say over their serial line:
 * bytes and little-endian floats, without frame or checksum (Haply-API-cpp). Pure; fuzzed.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "rt/base/contract.h"

namespace hapticd::pantograph {

inline constexpr std::uint8_t kDeviceId = 5;
inline constexpr std::size_t kJoints = 2;
/** Number, then an angle for each encoder. */
inline constexpr std::size_t kAnswerBytes = 1 + 4 * kJoints;

/** How an encoder is wired. */
struct Encoder {
  float offset_deg = 0, counts_per_turn = 13'824;
  bool clockwise = false;
};

[[nodiscard]] std::array<std::uint8_t, 2> encodeReset() HD_RT;
/** Motors and encoders on ports 1 and 2, no sensors, no PWM pins. */
[[nodiscard]] std::array<std::uint8_t, 26> encodeSetup(const std::array<Encoder, kJoints>& encoders,
                                                       bool motors_clockwise) HD_RT;
/** Torques at the motors [N m]; what is not finite is zero. */
[[nodiscard]] std::array<std::uint8_t, 10> encodeTorques(const std::array<float, kJoints>& torque_nm) HD_RT;

/** Bytes of the line, in whatever portions they come, to angles. */
class Parser {
 public:
  void feed(std::span<const std::uint8_t> bytes) HD_RT;
  /**
   * The next answer: angles [deg]. An answer begins with the device's number and has angles that are finite and within
   * two turns; where that is not so a byte is dropped and it looks again.
   */
  [[nodiscard]] std::optional<std::array<float, kJoints>> next() HD_RT;
  void reset() HD_RT { size_ = 0; }
  [[nodiscard]] std::uint64_t dropped() const HD_RT { return dropped_; }

 private:
  static constexpr std::size_t kRoom = 256;
  void drop(std::size_t bytes) HD_RT;

  std::array<std::uint8_t, kRoom> bytes_{};
  std::size_t size_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace hapticd::pantograph
