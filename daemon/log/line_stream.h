/** @file
 * Lines into a descriptor that somebody else reads, or does not.
 */
#pragma once

#include <cstdint>
#include <string_view>

#include "daemon/ipc/unique_fd.h"

namespace hapticd {

/** Never waits for the reader of a pipe, a terminal or a socket. One thread at a time. */
class LineStream {
 public:
  /** `fd` stays the caller's. */
  explicit LineStream(int fd) noexcept;
  /** Through a description of its own that cannot block, where the kind of file and the rights allow one. */
  [[nodiscard]] static LineStream unblocked(int fd);

  /** A line, or nothing of it if there is no room; the next for which there is some says first how many are lost. */
  void write(std::string_view line);

 private:
  [[nodiscard]] bool put(std::string_view text) noexcept;

  int fd_;
  UniqueFd own_;
  bool socket_ = false;
  bool cut_ = false;  ///< The last line lacks its end.
  std::uint64_t lost_ = 0;
};

}  // namespace hapticd
