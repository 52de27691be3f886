/** @file
 * Numbers of things in notes to a user.
 */
#pragma once

#include <cstddef>
#include <string>

namespace hapticd {

/** "1 edge", "2 edges"; `several` where an s does not make it. */
inline std::string counted(std::size_t n, const std::string& one, const std::string& several = {}) {
  const std::string many = several.empty() ? one + "s" : several;
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

}  // namespace hapticd
