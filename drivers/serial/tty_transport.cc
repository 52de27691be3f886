#include "drivers/serial/tty_transport.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "rt/base/clock.h"

namespace hapticd {
namespace {

constexpr std::int64_t kWriteWait_ns = 10'000'000;

timespec within(std::int64_t ns) noexcept {
  ns = std::max<std::int64_t>(ns, 0);
  return {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
}

constexpr const char* kToBeAllowed =
    "hapticd must be in the group of that line, mostly dialout; the service also needs "
    "/usr/share/hapticd/serial/hapticd-serial.conf";

/** Waits for `what` on the line; false at the end of time, or when it is gone. */
bool waitFor(int fd, short what, std::int64_t ns, bool& gone) noexcept {
  pollfd one{fd, what, 0};
  const timespec limit = within(ns);
  const int ready = ::ppoll(&one, 1, &limit, nullptr);
  gone = ready > 0 && (one.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 && (one.revents & what) == 0;
  return ready > 0 && !gone;
}

}  // namespace

Result<void> TtyTransport::open() {
  close();
  const auto refused = [&](int error) {
    const ErrorCode code = error == EACCES || error == EPERM                      ? ErrorCode::kPermissionDenied
                           : error == ENOENT || error == ENXIO || error == ENODEV ? ErrorCode::kNotFound
                           : error == EBUSY || error == EWOULDBLOCK               ? ErrorCode::kDeviceBusy
                                                                                  : ErrorCode::kSystem;
    return Error{code, path_, std::strerror(error),
                 code == ErrorCode::kDeviceBusy         ? fmt::format("'fuser -v {}' names who has it", path_)
                 : code == ErrorCode::kPermissionDenied ? kToBeAllowed
                                                        : "is it plugged in?"};
  };
  const int fd = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return refused(errno);
  termios line{};
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0 || ::tcgetattr(fd, &line) != 0) {
    const int error = errno;
    ::close(fd);
    return refused(error);
  }
  ::cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | HUPCL);
  ::cfsetspeed(&line, B115200);
  if (::tcsetattr(fd, TCSANOW, &line) != 0) {
    const int error = errno;
    ::close(fd);
    return refused(error);
  }
  (void)::ioctl(fd, TIOCEXCL);
  (void)::tcflush(fd, TCIOFLUSH);
  fd_.lend(fd);
  return {};
}

void TtyTransport::close() noexcept {
  const int fd = fd_.takeBack();
  if (fd < 0) return;
  (void)::ioctl(fd, TIOCNXCL);
  ::close(fd);
}

std::int64_t TtyTransport::now() const noexcept { return MonotonicClock().now(); }

bool TtyTransport::read(std::span<std::uint8_t> buffer, std::size_t& size, std::int64_t until_ns) noexcept {
  size = 0;
  const int fd = fd_.get();
  bool gone = fd < 0;
  if (gone || !waitFor(fd, POLLIN, until_ns - now(), gone)) return !gone;
  const ssize_t got = ::read(fd, buffer.data(), buffer.size());
  if (got == 0) return false;  // Hung up.
  if (got < 0) return errno == EAGAIN || errno == EINTR;
  size = static_cast<std::size_t>(got);
  return true;
}

bool TtyTransport::write(std::span<const std::uint8_t> bytes) noexcept {
  const int fd = fd_.get();
  if (fd < 0) return false;
  const std::int64_t until_ns = now() + kWriteWait_ns;
  while (!bytes.empty()) {
    const ssize_t sent = ::write(fd, bytes.data(), bytes.size());
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
      continue;
    }
    if (sent < 0 && errno != EAGAIN && errno != EINTR) return false;
    bool gone = false;
    if (!waitFor(fd, POLLOUT, until_ns - now(), gone)) return false;
  }
  return true;
}

void TtyTransport::lastWords(std::span<const std::uint8_t> bytes) noexcept {
  fd_.use([&](int fd) {
    const int before = errno;
    [[maybe_unused]] const ssize_t sent = ::write(fd, bytes.data(), bytes.size());
    errno = before;
  });
}

}  // namespace hapticd
