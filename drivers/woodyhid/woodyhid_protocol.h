/** @file
 * The reports of WoodenHaptics and Polhem (haptikfabrikenapi's USB firmware): seven little-endian 16-bit numbers each
 * way. Pure; fuzzed.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "rt/base/contract.h"

namespace hapticd::woodyhid {

/** Bytes of either report; what follows, to the 64 of a Teensy, means nothing. */
inline constexpr std::size_t kReportBytes = 14;
inline constexpr std::size_t kTeensyReportBytes = 64;

/** Report from the device. */
struct Reading {
  std::array<std::int32_t, 6> encoder{};  ///< [counts]; three of the arm, three of the gimbal.
  bool button = false;                    ///< Of the stylus; it travels in the fourth encoder.
  bool calibrate = false;                 ///< Calibration button: stays until counters are set.
};

/** Report to the device, its ID first: 0, for they number none. */
using Report = std::array<std::uint8_t, 1 + kTeensyReportBytes>;

/** Nothing if it is shorter than a report. */
[[nodiscard]] std::optional<Reading> decode(std::span<const std::uint8_t> report) HD_RT;

/** Motor currents [mA]. */
[[nodiscard]] Report encodeCurrents(const std::array<std::int16_t, 3>& current_mA) HD_RT;
/** Sets the encoders' counters; clears the calibration button. The motors get nothing. */
[[nodiscard]] Report encodeCounters(const std::array<std::int16_t, 6>& counts) HD_RT;

}  // namespace hapticd::woodyhid
