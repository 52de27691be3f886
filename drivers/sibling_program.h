/** @file
 * Where the programs are that the daemon starts.
 */
#pragma once

#include <string>

#include "rt/base/error.h"

namespace hapticd {

/**
 * Where the program `name` is: `configured` if not empty, else beside the running program (a build tree), else in the
 * libexec directory next to that of the program (an installation). kNotFound lists what was tried, and says `remedy`.
 */
[[nodiscard]] Result<std::string> findSibling(const std::string& name, const std::string& configured,
                                              const char* remedy);

}  // namespace hapticd
