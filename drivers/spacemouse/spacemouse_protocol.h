/** @file
 * The reports of 3Dconnexion's SpaceMouse family, old layout (translation and rotation apart) and new (together). Pure;
 * fuzzed.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "rt/base/contract.h"

namespace hapticd::spacemouse {

/** What is known of the cap, as the reports build it up. Device axes: x right, y toward the user, z down. */
struct State {
  std::array<std::int16_t, 6> axis{};  ///< Deflection x, y, z and rotation about them; full at some 350.
  std::uint32_t buttons = 0;           ///< First 32.
  std::int32_t battery_percent = -1;   ///< -1: never told.
};

/** What a report was about. */
enum class Report : std::uint8_t { kNone, kTranslation, kRotation, kBoth, kButtons, kBattery };

/** Takes a report, its ID first. kNone: another report, or a torn one; the state stays. */
Report take(std::span<const std::uint8_t> report, State& state) HD_RT;

/** Output report: the light. */
[[nodiscard]] std::array<std::uint8_t, 2> encodeLight(bool on) HD_RT;

/** Full deflection of an axis. */
inline constexpr double kFull = 350;

/** A member of the family; null if it is none, or has no cap (keyboards, mice, keypads of the same maker). */
struct Product {
  std::uint16_t vendor, product;
  std::string_view name;
  std::uint32_t buttons;
};
[[nodiscard]] const Product* findProduct(std::uint16_t vendor, std::uint16_t product) noexcept;

}  // namespace hapticd::spacemouse
