/** @file
 * What the builder gives up before it reads a byte of anybody's mesh.
 */
#pragma once

#include <cstdint>

#include "rt/base/error.h"

namespace hapticd {

/** Whom the system call filter binds. */
enum class SandboxThreads {
  kNone,  ///< The caller, who must be alone.
  kAll    ///< Threads as well that libraries have started; needs seccomp(2), which a service must be allowed.
};

/**
 * Dies with the daemon, cannot gain privileges, cannot dump core, cannot be real-time, nice +10, among the first to be
 * ended where memory is short, at most `memory_bytes` of address space, and a system call filter that leaves memory,
 * its socket and its end: no file can be opened, no process started, no network reached. Sanitizer builds leave out the
 * address space limit and the filter, which they cannot live with.
 */
[[nodiscard]] Result<void> enterSandbox(std::uint64_t memory_bytes, SandboxThreads threads = SandboxThreads::kNone);

/** False in builds with a sanitizer. */
[[nodiscard]] bool sandboxIsComplete();

}  // namespace hapticd
