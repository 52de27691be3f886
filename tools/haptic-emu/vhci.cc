#include "tools/haptic-emu/vhci.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "rt/base/clock.h"
#include "tools/haptic-emu/usbip.h"

namespace haptic_emu {
namespace {

using hapticd::Error;
using hapticd::ErrorCode;
using hapticd::Result;

constexpr std::int64_t kVhciStep_ns = 250'000;
constexpr int kFullSpeed = 2;
constexpr int kBusAndNumber = 0x10001;  ///< Any, but not zero.

/** A descriptor that closes itself. */
class Fd {
 public:
  explicit Fd(int fd = -1) : fd_(fd) {}
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  ~Fd() { reset(); }
  void reset(int fd = -1) {
    if (fd_ >= 0) close(fd_);
    fd_ = fd;
  }
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

/** One end to the kernel, the other is returned. */
Result<int> attach(const VhciOptions& options) {
  int ends[2] = {-1, -1};
  const std::string path = options.folder + "/attach";
  const auto failed = [&](const char* what) {
    Error error{ErrorCode::kSystem, path, std::string(what) + ": " + std::strerror(errno),
                "run it as root after modprobe vhci_hcd, with a port that is free"};
    for (const int end : ends) {
      if (end >= 0) close(end);
    }
    return error;
  };
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return failed("no socket");
  const Fd file(open(path.c_str(), O_WRONLY | O_CLOEXEC));
  const std::string order = std::to_string(options.port) + ' ' + std::to_string(ends[1]) + ' ' +
                            std::to_string(kBusAndNumber) + ' ' + std::to_string(kFullSpeed);
  if (file.get() < 0 || write(file.get(), order.data(), order.size()) < 0) return failed("cannot plug it in");
  close(ends[1]);  // The kernel has its own.
  return ends[0];
}

bool sendAll(int fd, const std::vector<std::uint8_t>& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t sent = send(fd, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += static_cast<std::size_t>(sent);
  }
  return true;
}

/** One round: what the kernel says, what the world does, what the device says. False: the kernel is gone. */
bool serve(int fd, UsbIp& usbip, std::int64_t until_ns, hapticd::Clock& clock) {
  const std::int64_t left_ns = std::max<std::int64_t>(0, until_ns - clock.now());
  pollfd waiting{fd, POLLIN, 0};
  const timespec timeout{0, left_ns};
  if (ppoll(&waiting, 1, &timeout, nullptr) > 0) {
    std::array<std::uint8_t, 8192> buffer{};
    const ssize_t got = recv(fd, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return false;
    if (got > 0) {
      usbip.advance(clock.now());
      if (!usbip.feed({buffer.data(), static_cast<std::size_t>(got)})) return false;
    }
  }
  usbip.advance(clock.now());
  return sendAll(fd, usbip.take());
}

}  // namespace

Result<void> playToKernel(UsbModel& model, const VhciOptions& options, const std::atomic<bool>& stop,
                          const std::function<void(std::int64_t)>& each) {
  hapticd::MonotonicClock clock;
  const std::int64_t start_ns = clock.now();
  model.startAt(start_ns);
  Fd fd;
  std::unique_ptr<UsbIp> usbip;
  for (std::int64_t next_ns = start_ns; !stop.load();
       next_ns = std::max(next_ns + kVhciStep_ns, clock.now() - kVhciStep_ns)) {
    each(clock.now() - start_ns);
    if (!model.plugged()) {
      fd.reset();
      model.advance(clock.now());
      clock.sleepUntil(next_ns + kVhciStep_ns);
      continue;
    }
    if (fd.get() < 0) {
      auto end = attach(options);
      if (!end) return end.error();
      fd.reset(*end);
      usbip = std::make_unique<UsbIp>(model);
    }
    while (clock.now() < next_ns + kVhciStep_ns) {
      if (!serve(fd.get(), *usbip, next_ns + kVhciStep_ns, clock)) return {};
    }
  }
  return {};
}

}  // namespace haptic_emu
