/** @file
 * How the daemon starts a process of its own that is to know nothing of it.
 */
#pragma once

#include <sys/types.h>

#include <span>
#include <string>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

/**
 * Starts `program` with these arguments and no environment, `fds` as its descriptors 3, 4 and so on, nothing on
 * standard input and output, our standard error, default signals and a process group of its own (a terminal's Ctrl-C is
 * for the daemon). Without copying this process (vfork), so that it disturbs no thread under locked memory. Whoever
 * calls it reaps. kBuilderFailed if it does not start. Any thread.
 */
[[nodiscard]] Result<pid_t> spawnProgram(const std::string& program, const std::vector<std::string>& arguments,
                                         std::span<const int> fds);

}  // namespace hapticd
