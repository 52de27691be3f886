/** @file
 * Where the daemon's builder is installed.
 */
#pragma once

#include <string>

#include "rt/base/error.h"

namespace hapticd {

/**
 * Where hapticd-builder is: `configured` if not empty, else beside the running program (a build tree), else the
 * libexec directory next to that of the program (an installation). kNotFound lists what was tried.
 */
[[nodiscard]] Result<std::string> findBuilder(const std::string& configured);

}  // namespace hapticd
