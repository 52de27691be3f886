/** @file
 * A number out of a text, without the locale: "0.5" is a half in every country.
 */
#pragma once

#include <charconv>
#include <cmath>
#include <string_view>

namespace hapticd_options {

/** Whether the whole text is a finite number. One that is too small for a double is 0. */
[[nodiscard]] inline bool parseNumber(std::string_view text, double& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const char* last = text.data() + text.size();
  std::from_chars_result read = std::from_chars(text.data(), last, value);
  if (read.ec == std::errc::result_out_of_range) {  // Too large or too small, it does not say which.
    long double wide = 0;
    read = std::from_chars(text.data(), last, wide);
    value = static_cast<double>(wide);
  }
  return read.ec == std::errc{} && read.ptr == last && std::isfinite(value);
}

}  // namespace hapticd_options
