/** @file
 * Units of length on the command line of our programs: 10mm, 0.5cm, 1in.
 */
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>

#include "tools/options/parse_number.h"

namespace hapticd_options {

/** As a fraction of a metre: 9mm is then the number that 0.009 is. */
struct Unit {
  const char* name;
  double metres, of;
  [[nodiscard]] constexpr double inMetres(double value) const { return value * metres / of; }
};
inline constexpr Unit kUnits[] = {{"mm", 1, 1000},    {"cm", 1, 100},      {"m", 1, 1},       {"inch", 254, 10000},
                                  {"um", 1, 1000000}, {"ft", 3048, 10000}, {"in", 254, 10000}};

/** Null: there is no such unit. */
[[nodiscard]] inline const Unit* findUnit(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) { return name == u.name; });
  return found == std::end(kUnits) ? nullptr : found;
}

/** The unit's name at the end of a field; empty: none. */
[[nodiscard]] inline std::string_view unitOf(std::string_view field) {
  const std::size_t digit = field.find_last_of("0123456789.");
  return digit == std::string_view::npos ? std::string_view() : field.substr(digit + 1);
}

/** For the transform() of an option in millimetres: a length with its unit as the number alone; all else as it is. */
inline std::string millimetres(const std::string& text) {
  const std::string_view name = unitOf(text);
  const Unit* const unit = findUnit(name);
  double value = 0;
  if (unit == nullptr || !parseNumber(std::string_view(text).substr(0, text.size() - name.size()), value)) return text;
  return fmt::format("{}", std::string_view(unit->name) == "mm" ? value : unit->inMetres(value) * 1000);
}

}  // namespace hapticd_options
