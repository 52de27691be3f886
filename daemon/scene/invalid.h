/** @file
 * How the parts of the scene say that a value cannot be taken.
 */
#pragma once

#include <string>

#include "rt/base/error.h"

namespace hapticd {

/** kInvalidArgument, and the place. */
[[nodiscard]] inline Error invalid(std::string where, std::string what, std::string remedy = {}) {
  return {ErrorCode::kInvalidArgument, std::move(where), std::move(what), std::move(remedy)};
}

/** Refuses a value outside [lower, upper], or none. The remedy tells what such a value usually is. */
[[nodiscard]] Result<void> inRange(double value, double lower, double upper, const std::string& where, const char* unit,
                                   const char* remedy);

}  // namespace hapticd
