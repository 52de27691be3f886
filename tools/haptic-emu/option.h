/** @file
 * What haptic-emu checks of its command line before it plays anything. CLI::Range lets "nan" through.
 */
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <string>

#include "tools/haptic-emu/fault.h"

namespace haptic_emu {

/** A finite number from `lowest` to `highest`, read without the locale. */
inline CLI::Validator within(double lowest, double highest) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        double value = 0;
        const char* const end = text.data() + text.size();
        const auto [stop, problem] = std::from_chars(text.data(), end, value);
        if (problem != std::errc() || stop != end || !std::isfinite(value))
          return fmt::format("'{}' is not a finite number", text);
        if (value >= lowest && value <= highest) return {};
        return fmt::format("{} is out of range: from {} to {}", text, lowest, highest);
      },
      fmt::format("{} to {}", lowest, highest));
}

/** KIND@FROM+LENGTH. */
inline CLI::Validator isFault() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        const auto fault = parseFault(text);
        return fault ? std::string() : toString(fault.error());
      },
      "");
}

}  // namespace haptic_emu
