/** @file
 * Lengths with their unit: 10mm, 0.5cm, 1in. Without one they are metres.
 */
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace hapticctl {

/** As a fraction of a metre: 9mm is then the number that 0.009 is. */
struct Unit {
  const char* name;
  double metres, of;
  [[nodiscard]] constexpr double inMetres(double value) const { return value * metres / of; }
};
inline constexpr Unit kUnits[] = {{"mm", 1, 1000},    {"cm", 1, 100},      {"m", 1, 1},       {"inch", 254, 10000},
                                  {"um", 1, 1000000}, {"ft", 3048, 10000}, {"in", 254, 10000}};

/** Null: there is no such unit. */
[[nodiscard]] const Unit* findUnit(std::string_view name);

/**
 * Lengths between commas [m], as parseNumbers(), each with a unit behind it or none with one (0 is 0 in any). A note on
 * standard error tells of one without a unit that is 1 m or longer, for who thinks in millimetres: no hand reaches that
 * far.
 */
[[nodiscard]] std::vector<double> parseLengths(std::string_view option, std::string_view text, std::size_t count);
/** One such length, above zero. */
[[nodiscard]] double parseLength(std::string_view option, std::string_view text);

}  // namespace hapticctl
