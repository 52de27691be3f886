/** @file
 * Standard streams that are closed: else the next file that is opened, a device perhaps, gets their number, and the
 * log. And standard error that takes nothing.
 */
#pragma once

#include <fcntl.h>

#include <cstdio>
#include <string_view>

namespace hapticd {

/** Takes the numbers 0 to 2 where they are free. To read and to write fails there as before. First in main(). */
inline void holdStandardStreams() noexcept {
  for (int fd = 0; fd <= 2; ++fd) {
    if (::fcntl(fd, F_GETFD) >= 0) continue;
    (void)::open("/dev/null", fd == 0 ? O_WRONLY : O_RDONLY);  // Gets the lowest number that is free.
  }
}

/** On standard error, be there room and a reader or not: of a full disk fmt::print() throws, which would end a program.
 */
inline void tellError(std::string_view text) noexcept {
  if (std::fwrite(text.data(), 1, text.size(), stderr) != text.size()) return;  // Nobody to tell.
}

}  // namespace hapticd
