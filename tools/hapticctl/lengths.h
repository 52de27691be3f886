/** @file
 * Lengths with their unit: 10mm, 0.5cm, 1in. Without one they are metres.
 */
#pragma once

#include <string_view>
#include <vector>

#include "tools/options/units.h"

namespace hapticctl {

using hapticd_options::findUnit;
using hapticd_options::kUnits;
using hapticd_options::Unit;

/**
 * Lengths between commas [m], as parseNumbers(), each with a unit behind it or none with one (0 is 0 in any). A note on
 * standard error tells of one without a unit that is 1 m or longer, for who thinks in millimetres: no hand reaches that
 * far.
 */
[[nodiscard]] std::vector<double> parseLengths(std::string_view option, std::string_view text, std::size_t count);
/** One such length, above zero. */
[[nodiscard]] double parseLength(std::string_view option, std::string_view text);

}  // namespace hapticctl
