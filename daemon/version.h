/** @file
 * The version of the program.
 */
#pragma once

namespace hapticd {

inline constexpr const char* kVersion = "0.1.0";

}  // namespace hapticd
