/** @file
 * Numbers on the command line.
 */
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "tools/haptic-bench/spec.h"
#include "tools/options/number.h"

namespace haptic_bench {

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
