/** @file
 * Numbers on the command line of our programs: finite, within bounds, read without the locale. CLI::Range lets "nan"
 * through.
 */
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>

#include "tools/options/parse_number.h"

namespace hapticd_options {

/** A finite number. */
inline std::string isNumber(const std::string& text) {
  double value = 0;
  return parseNumber(text, value) ? std::string() : fmt::format("'{}' is not a finite number", text);
}

/** A finite number from `lowest` to `highest`. */
inline CLI::Validator within(double lowest, double highest) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        double value = 0;
        if (!parseNumber(text, value)) return isNumber(text);
        if (value >= lowest && value <= highest) return {};
        return fmt::format("{} is out of range: from {} to {}", text, lowest, highest);
      },
      fmt::format("{} to {}", lowest, highest));
}

/** For an integer's transform(): without zeros in front, by which CLI11 takes 010 for eight, and 08 for no number. */
inline std::string decimal(const std::string& text) {
  const std::size_t sign = text.starts_with('+') || text.starts_with('-') ? 1 : 0;
  std::size_t first = sign;
  while (first + 1 < text.size() && text[first] == '0' && text[first + 1] >= '0' && text[first + 1] <= '9') ++first;
  return text.substr(0, sign) + text.substr(first);
}

}  // namespace hapticd_options
