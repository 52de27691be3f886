#include "drivers/hid/hidraw_transport.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <hidapi/hidapi.h>
#include <poll.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "rt/base/clock.h"

namespace hapticd {
namespace {

Error refusal(const std::string& path, int error) {
  const std::string what = std::strerror(error);
  if (error == EACCES || error == EPERM) {
    return {ErrorCode::kPermissionDenied, path, what,
            "hapticd's udev rules give such devices to the group haptic; run the daemon in it"};
  }
  const bool gone = error == ENOENT || error == ENODEV || error == ENXIO;
  return {gone ? ErrorCode::kDeviceGone : ErrorCode::kSystem, path, what, gone ? "plug it in again" : ""};
}

}  // namespace

HidPlugged pluggedAmong(const std::vector<HidFound>& all, const HidFound& one) {
  HidPlugged plugged{fmt::format("{:04x}:{:04x} {}", one.vendor, one.product, one.serial), one.instance};
  for (const HidFound& other : all) {
    if (!other.instance.empty() && other.instance != one.instance) plugged.beside.push_back(other.instance);
  }
  return plugged;
}

Result<void> HidrawTransport::open() {
  close();
  const std::vector<HidFound> all = findHid();
  Result<HidFound> found = choose(all, wanted_);
  if (!found) return found.error();
  const std::string& path = found->path;
  const int node = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (node < 0) return refusal(path, errno);
  if (::flock(node, LOCK_EX | LOCK_NB) != 0) {
    ::close(node);
    return Error{ErrorCode::kDeviceBusy, path, "another hapticd has it",
                 fmt::format("stop that one; 'fuser -v {}' names it", path)};
  }
  {
    const std::lock_guard lock(hidapiLock());
    errno = 0;
    device_ = hid_open_path(path.c_str());
  }
  if (device_ == nullptr) {
    const int error = errno != 0 ? errno : EIO;
    ::close(node);
    return refusal(path, error);
  }
  node_.lend(node);
  descriptor_ = found->descriptor;
  plugged_ = pluggedAmong(all, *found);
  wanted_.same = std::move(*found);
  return {};
}

void HidrawTransport::close() noexcept {
  const int node = node_.takeBack();
  if (device_ != nullptr) hid_close(device_);
  device_ = nullptr;
  if (node >= 0) ::close(node);
}

std::int64_t HidrawTransport::now() const noexcept { return MonotonicClock().now(); }

HidResult HidrawTransport::failure() const noexcept {
  // hidapi keeps no errno; the node itself knows whether the device is there.
  pollfd probe{node_.get(), 0, 0};
  if (probe.fd < 0 || ::poll(&probe, 1, 0) < 0) return HidResult::kGone;
  return (probe.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 ? HidResult::kGone : HidResult::kRefused;
}

HidResult HidrawTransport::read(std::span<std::uint8_t> buffer, std::size_t& size, std::int64_t until_ns) noexcept {
  if (device_ == nullptr) return HidResult::kGone;
  constexpr std::int64_t kMs = 1'000'000, kLongest_ms = 1000;
  const std::int64_t left_ns = until_ns - now();
  const std::int64_t wait_ms = left_ns <= 0 ? 0 : std::min((left_ns + kMs - 1) / kMs, kLongest_ms);
  const int got = hid_read_timeout(device_, buffer.data(), buffer.size(), static_cast<int>(wait_ms));
  if (got < 0) return HidResult::kGone;  // hidraw's read fails for nothing else.
  size = static_cast<std::size_t>(got);
  return got > 0 ? HidResult::kOk : HidResult::kNothing;
}

HidResult HidrawTransport::write(std::span<const std::uint8_t> report) noexcept {
  if (device_ == nullptr) return HidResult::kGone;
  return hid_write(device_, report.data(), report.size()) >= 0 ? HidResult::kOk : failure();
}

HidResult HidrawTransport::setFeature(std::span<const std::uint8_t> report) noexcept {
  if (device_ == nullptr) return HidResult::kGone;
  return hid_send_feature_report(device_, report.data(), report.size()) >= 0 ? HidResult::kOk : failure();
}

HidResult HidrawTransport::getFeature(std::span<std::uint8_t> buffer, std::size_t& size) noexcept {
  if (device_ == nullptr) return HidResult::kGone;
  const int got = hid_get_feature_report(device_, buffer.data(), buffer.size());
  if (got < 0) return failure();
  size = static_cast<std::size_t>(got);
  return HidResult::kOk;
}

void HidrawTransport::lastWords(std::span<const std::uint8_t> report) noexcept {
  node_.use([&](int node) {
    const int before = errno;
    [[maybe_unused]] const ssize_t sent = ::write(node, report.data(), report.size());
    errno = before;
  });
}

}  // namespace hapticd
