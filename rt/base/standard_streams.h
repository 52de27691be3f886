/** @file
 * Standard streams that are closed: else the next file that is opened, a device perhaps, gets their number, and the
 * log.
 */
#pragma once

#include <fcntl.h>

namespace hapticd {

/** Takes the numbers 0 to 2 where they are free. To read and to write fails there as before. First in main(). */
inline void holdStandardStreams() noexcept {
  for (int fd = 0; fd <= 2; ++fd) {
    if (::fcntl(fd, F_GETFD) >= 0) continue;
    (void)::open("/dev/null", fd == 0 ? O_WRONLY : O_RDONLY);  // Gets the lowest number that is free.
  }
}

}  // namespace hapticd
