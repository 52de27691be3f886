/** @file
 * Numbers on the command line of our programs: finite, within bounds, read without the locale. CLI::Range lets "nan"
 * through.
 */
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
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

}  // namespace hapticd_options
