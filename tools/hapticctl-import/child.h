/** @file
 * Work on files that nobody vouches for, in a process that may die of it.
 */
#pragma once

#include <cstdint>
#include <functional>

namespace hapticctl_import {

/**
 * Calls `work` in a forked child that may have `most_bytes` of address space (0: what the machine has) and gives its
 * exit code. Standard streams are flushed on both sides. Throws ImportError if the child died: by which signal. No
 * other thread may run.
 */
int inChild(const std::function<int()>& work, std::uint64_t most_bytes = 0);

}  // namespace hapticctl_import
