/** @file
 * What happens to connections when the process forks: the child's copies are closed and refuse every call.
 */
#pragma once

#include <cstdint>

namespace hapticd::client {

/** Counts the forks between the first process and this one. Servo-safe. */
std::uint32_t forkGeneration() noexcept;

/** From now on the descriptor is closed in children. Installs the handlers at first use. */
void closeInChildren(int fd);
/** Before the descriptor is closed here. */
void forgetDescriptor(int fd) noexcept;

}  // namespace hapticd::client
