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

/**
 * On standard error, be there room or not: of a full disk fmt::print() throws, which would end a program.
 * What would steer a terminal, in UTF-8 too, is '?': it may come of a file.
 */
inline void tellError(std::string_view text) noexcept {
  const auto put = [](std::string_view part) {
    return part.empty() || std::fwrite(part.data(), 1, part.size(), stderr) == part.size();
  };
  std::size_t said = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]), next = static_cast<unsigned char>(text.substr(i, 2).back());
    const bool c1 = byte == 0xc2 && next >= 0x80 && next < 0xa0;  // U+0080 to U+009F
    if (!c1 && byte != 0x7f && (byte >= 0x20 || byte == '\n' || byte == '\t')) continue;
    if (!put(text.substr(said, i - said)) || !put("?")) return;  // Nobody to tell.
    i += c1 ? 1 : 0;
    said = i + 1;
  }
  (void)put(text.substr(said));
}

}  // namespace hapticd
