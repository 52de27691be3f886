/** @file
 * What is written onto a slow disk by a thread that is to end.
 */
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

namespace hapticd {

inline constexpr std::int64_t kDiskPart_bytes = 4 * 1024 * 1024;  ///< On the disk before the next is begun.

/**
 * A part of what was written, onto the disk; false and errno if that cannot be. What went wrong is told here, and by
 * fsync() no more. Of what has no disk, a pipe, or no such call it is left to that.
 */
[[nodiscard]] inline bool putOntoDisk(int fd, off_t at, off_t bytes) {
  constexpr unsigned kAll = SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER;
  return ::sync_file_range(fd, at, bytes, kAll) == 0 || (errno != EIO && errno != ENOSPC && errno != EDQUOT);
}

/** As fsync(), which hears nothing until the end; false and ECANCELED where `go_on` says no before a part. */
template <class GoOn>
[[nodiscard]] bool syncInParts(int fd, GoOn go_on) {
  struct stat file {};
  if (::fstat(fd, &file) != 0) return false;
  for (off_t at = 0; at < file.st_size; at += kDiskPart_bytes) {
    if (!go_on()) {
      errno = ECANCELED;
      return false;
    }
    if (!putOntoDisk(fd, at, kDiskPart_bytes)) return false;
  }
  return ::fsync(fd) == 0;
}

}  // namespace hapticd
