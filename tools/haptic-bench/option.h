/** @file
 * Numbers on the command line.
 */
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <type_traits>
#include <vector>

#include "tools/haptic-bench/spec.h"
#include "tools/options/number.h"
#include "tools/options/when_named.h"

namespace haptic_bench {

using hapticd_options::whenNamed;
using hapticd_options::within;

/** A finite number above zero. */
inline CLI::Validator positive() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        double value = 0;
        if (!parseNumber(text, value)) return hapticd_options::isNumber(text);
        return value > 0 ? std::string() : fmt::format("{} is out of range: above 0", text);
      },
      "above 0");
}

/** A number, or several, from `low` to `high`; whole ones where these are. The help shows the default. */
template <class T, class Bound>
CLI::Option* bounded(CLI::App* command, const char* name, T& value, const std::string& help, Bound low, Bound high) {
  CLI::Option* option = command->add_option(name, value, help)->capture_default_str();
  if constexpr (std::is_integral_v<Bound>) {
    return option->check(CLI::Range(low, high))->transform(hapticd_options::decimal);
  } else {
    return option->check(within(low, high));
  }
}

/** Each once, in their order: what is asked for twice is measured once. */
template <class T>
std::vector<T> distinct(const std::vector<T>& all) {
  std::vector<T> once;
  for (const T& x : all) {
    if (std::find(once.begin(), once.end(), x) == once.end()) once.push_back(x);
  }
  return once;
}

}  // namespace haptic_bench
