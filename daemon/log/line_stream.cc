#include "daemon/log/line_stream.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>

namespace hapticd {

LineStream::LineStream(int fd) noexcept : fd_(fd) {
  struct stat status {};
  socket_ = ::fstat(fd, &status) == 0 && S_ISSOCK(status.st_mode);
}

LineStream LineStream::unblocked(int fd) {
  LineStream out(fd);
  struct stat status {};
  // Not O_NONBLOCK on the descriptor itself: others share its description, the shell that started us among them.
  if (::fstat(fd, &status) != 0 || !(S_ISFIFO(status.st_mode) || ::isatty(fd) != 0)) return out;
  std::array<char, 32> path{};
  fmt::format_to_n(path.data(), path.size() - 1, "/proc/self/fd/{}", fd);
  out.own_.reset(::open(path.data(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (out.own_.valid()) out.fd_ = out.own_.get();
  return out;
}

void LineStream::write(std::string_view line) {
  if (lost_ != 0) {
    std::array<char, 128> note;
    const auto end = fmt::format_to_n(
        note.data(), note.size(), "{}{} lines are lost here: there was no room for them\n", cut_ ? "\n" : "", lost_);
    if (put({note.data(), end.size})) lost_ = 0;
  }
  if (lost_ != 0 || !put(line)) ++lost_;
}

/** In pieces of which a pipe that can be written to takes each without waiting. */
bool LineStream::put(std::string_view text) noexcept {
  for (bool first = true; !text.empty(); first = false) {
    pollfd room{fd_, POLLOUT, 0};
    const std::string_view piece = text.substr(0, PIPE_BUF);
    ssize_t n = -1;
    if (::poll(&room, 1, 0) == 1 && (room.revents & POLLOUT) != 0) {
      n = socket_ ? ::send(fd_, piece.data(), piece.size(), MSG_DONTWAIT | MSG_NOSIGNAL)
                  : ::write(fd_, piece.data(), piece.size());
    }
    if (n != static_cast<ssize_t>(piece.size())) {
      cut_ = cut_ || !first || n > 0;
      return false;
    }
    text.remove_prefix(piece.size());
  }
  cut_ = false;
  return true;
}

}  // namespace hapticd
