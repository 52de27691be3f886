/** @file
 * The bytes of the sample device, which exists only in haptic-emu. Pure: no device, no clock, nothing but bytes.
 *
 * Each USB packet is one message of twelve bytes, little-endian:
 *   reading  A5 number x x y y z z buttons 00 crc crc     position [10 um]
 *   order    5A number x x y y z z lights  00 crc crc     force [mN]
 * with the CRC-16 that is called CCITT-FALSE over the first ten. Axes: right, up, toward the operator.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace hapticd::sample {

inline constexpr std::size_t kBytes = 12;
inline constexpr std::uint8_t kEnable = 1;        ///< Of Order::lights: the amplifier may be on.
inline constexpr std::int16_t kMost_mN = 10'000;  ///< Of each motor.
inline constexpr double kMetresPerCount = 1e-5;

struct Reading {
  std::uint8_t number = 0;
  std::array<std::int16_t, 3> position{};
  std::uint8_t buttons = 0;
};
struct Order {
  std::uint8_t number = 0;
  std::array<std::int16_t, 3> force_mN{};
  std::uint8_t lights = 0;
};

/** Nothing for a packet of another length, kind or sum. Fuzzed. */
[[nodiscard]] std::optional<Reading> decode(std::span<const std::uint8_t> packet) noexcept;
[[nodiscard]] std::array<std::uint8_t, kBytes> encode(const Order& order) noexcept;
[[nodiscard]] std::uint16_t crc16(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace hapticd::sample
