/** @file
 * Numbers on the command line: finite, within bounds, read without the locale. CLI::Range lets "nan" through.
 */
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "tools/haptic-bench/spec.h"

namespace haptic_bench {

/** A finite number from `lowest` to `highest`. */
inline CLI::Validator within(double lowest, double highest) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        double value = 0;
        if (!parseNumber(text, value)) return fmt::format("'{}' is not a finite number", text);
        if (value >= lowest && value <= highest) return {};
        return fmt::format("{} is out of range: from {} to {}", text, lowest, highest);
      },
      fmt::format("{} to {}", lowest, highest));
}

/** A finite number above zero. */
inline CLI::Validator positive() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        double value = 0;
        if (!parseNumber(text, value)) return fmt::format("'{}' is not a finite number", text);
        return value > 0 ? std::string() : fmt::format("{} is out of range: above 0", text);
      },
      "above 0");
}

}  // namespace haptic_bench
