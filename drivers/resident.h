/** @file
 * Memory that real-time threads read must never be paged out.
 */
#pragma once

#include <sys/mman.h>

#include <cstddef>

namespace hapticd {

/**
 * Locks the pages of [start, start + bytes) into memory, as far as the process may (RLIMIT_MEMLOCK); without the right
 * they stay ordinary memory, as the servo's own then is. Control thread. Undone when the memory is unmapped.
 */
inline void keepResident(const void* start, std::size_t bytes) noexcept {
  if (bytes > 0) (void)mlock(start, bytes);
}

}  // namespace hapticd
