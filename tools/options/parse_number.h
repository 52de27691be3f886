/** @file
 * A number out of a text, without the locale: "0.5" is a half in every country.
 */
#pragma once

#include <charconv>
#include <cmath>
#include <string_view>

namespace hapticd_options {

/** Whether the whole text is a finite number. */
[[nodiscard]] inline bool parseNumber(std::string_view text, double& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

}  // namespace hapticd_options
