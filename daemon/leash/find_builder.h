/** @file
 * Where the daemon's builder is installed.
 */
#pragma once

#include "drivers/sibling_program.h"

namespace hapticd {

/** Where hapticd-builder is: see findSibling(). */
[[nodiscard]] inline Result<std::string> findBuilder(const std::string& configured) {
  return findSibling("hapticd-builder", configured, "install it, or set builder.program");
}

}  // namespace hapticd
