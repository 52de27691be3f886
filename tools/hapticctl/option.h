/** @file
 * Numbers on the command line: checked by our own parser, refused in words.
 */
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "tools/hapticctl/numbers.h"
#include "tools/options/number.h"
#include "tools/options/when_named.h"

namespace hapticctl {

/** A finite number of at least `lowest` (above it, if `above`) and at most `highest`. */
inline CLI::Validator number(double lowest, double highest = std::numeric_limits<double>::max(), bool above = false) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        const auto value = parseNumber(text);
        if (!value) return fmt::format("'{}' is not a finite number", text);
        if (*value < lowest || (above && *value == lowest))
          return fmt::format("{} is too small: {} {}", text, above ? "it must be above" : "at least", lowest);
        if (*value > highest) return fmt::format("{} is too large: at most {}", text, highest);
        return {};
      },
      std::string());
}

/** A finite number above zero. */
inline CLI::Validator positive() { return number(0, std::numeric_limits<double>::max(), true); }

using hapticd_options::decimal;
using hapticd_options::whenNamed;

/** How the name of a field of the interface begins, and the option by which the user knows it. */
struct FieldOption {
  std::string_view field;
  const char* option;
};

/** The option for what an error names; that name where it is none of them. Creating calls "object." what edits do not.
 */
[[nodiscard]] inline std::string optionOf(std::string_view where, std::span<const FieldOption> options) {
  if (where.starts_with("object.")) where.remove_prefix(7);
  for (const FieldOption& o : options)
    if (where.starts_with(o.field)) return o.option;
  return std::string(where);
}

}  // namespace hapticctl
