#include "daemon/scene/invalid.h"

#include <fmt/format.h>

#include <cmath>

namespace hapticd {

Result<void> inRange(double value, double lower, double upper, const std::string& where, const char* unit,
                     const char* remedy) {
  if (std::isfinite(value) && value >= lower && value <= upper) return {};
  return invalid(
      where, fmt::format("{} is not between {} and {}{}{}", value, lower, upper, *unit == 0 ? "" : " ", unit), remedy);
}

}  // namespace hapticd
