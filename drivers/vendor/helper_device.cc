#include "drivers/vendor/helper_device.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/resident.h"
#include "drivers/vendor/helper_protocol.h"

namespace hapticd {
namespace {

constexpr std::size_t kWatchStackBytes = 256 * 1024;
constexpr int kLook_ms = 50;

Error refused(const char* call) {
  return {ErrorCode::kSystem, "vendor link", std::string(call) + ": " + std::strerror(errno), {}};
}

/** A library's `default` may be any that is plugged in: what was told of one, to the guard too, must be true of it. */
bool isSame(const DeviceInfo& a, const DeviceInfo& b) {
  const auto told = [](const DeviceInfo& i) {
    return std::tuple(i.model, i.max_force, i.max_torque, i.max_gripper_force, i.max_stiffness, i.max_damping,
                      i.left_hand, i.actuated_rotation, i.actuated_gripper);
  };
  return told(a) == told(b) && (a.serial.empty() || b.serial.empty() || a.serial == b.serial);
}

}  // namespace

SharedLinkMapping::~SharedLinkMapping() {
  if (memory_ != nullptr) ::munmap(memory_, sizeof *memory_);
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> SharedLinkMapping::make() {
  descriptor_ = ::memfd_create("hapticd-vendor", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (descriptor_ < 0) return refused("memfd_create");
  if (::ftruncate(descriptor_, sizeof(SharedLinkMemory)) != 0) return refused("ftruncate");
  if (::fcntl(descriptor_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) return refused("F_ADD_SEALS");
  return map();
}

Result<void> SharedLinkMapping::take(int descriptor) {
  descriptor_ = descriptor;
  struct stat file {};
  if (::fstat(descriptor_, &file) != 0) return refused("fstat");
  if (file.st_size != sizeof(SharedLinkMemory)) {
    return Error{ErrorCode::kVersionMismatch, "vendor link", "memory of another size", "install both from one package"};
  }
  return map();
}

Result<void> SharedLinkMapping::map() {
  void* const at = ::mmap(nullptr, sizeof(SharedLinkMemory), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, 0);
  if (at == MAP_FAILED) return refused("mmap");
  memory_ = static_cast<SharedLinkMemory*>(at);
  keepResident(memory_, sizeof *memory_);
  return {};
}

Calibration HelperDevice::calibration() const noexcept {
  if (gone_.load() || told_gone_.load() || mapping_.get() == nullptr) return Calibration::kNeeded;
  const std::uint32_t told = mapping_.get()->calibration.load(std::memory_order_relaxed);
  return told <= static_cast<std::uint32_t>(Calibration::kDone) ? static_cast<Calibration>(told) : Calibration::kNeeded;
}

Result<void> HelperDevice::open() {
  close();
  if (mapping_.get() == nullptr) {
    if (auto made = mapping_.make(); !made) return made;
    end_ = std::make_unique<SharedServoEnd>(*mapping_.get());
    keepResident(end_.get(), sizeof *end_);
  }
  end_->write(clock_.now(), {});  // What was commanded before it was closed is over.
  stop_.store(false);
  told_gone_.store(false);
  died_.store(false);
  if (given_up_.load()) stop_.store(true);  // After the line above, so that giveUp() is not lost whenever it comes.
  auto started = startHelper();
  if (!started) return started.error();
  const std::string uri = info_.uri, driver = info_.driver, style = info_.calibration_style;
  const std::uint32_t buttons = info_.buttons;
  info_ = std::move(*started);
  info_.uri = uri;
  info_.driver = driver;
  info_.calibration_style = style;
  info_.buttons = buttons;
  live_.store(end_.get());
  return watcher_.start("vendor-watch", kWatchStackBytes, [this] { watch(); });
}

void HelperDevice::close() noexcept {
  if (end_) end_->safe();
  stop_.store(true);
  watcher_.join();
  live_.store(nullptr);
  gone_.store(true);
  process_.reset();  // Hangs up; the helper sends zeros, closes the device and ends.
  pid_.store(0);
}

void HelperDevice::giveUp() noexcept {
  given_up_.store(true);
  stop_.store(true);
}

void HelperDevice::read(std::int64_t now_ns, DeviceSample& sample) HD_RT {
  end_->read(now_ns, sample);
  // In this order: where another helper is back already, the death of the last is there to be seen.
  const bool gone = gone_.load(std::memory_order_acquire);
  if (died_.exchange(false, std::memory_order_acq_rel) || gone) {
    sample.fresh = false;
    sample.status |= kDeviceGone;
  }
  // Release, pairs with calibration(): who sees it back sees what the helper that brought it back said of itself.
  told_gone_.store((sample.status & kDeviceGone) != 0, std::memory_order_release);
}

void HelperDevice::safe() noexcept {
  // The helper's one thread sends zeros next, and after whatever it is sending.
  if (SharedServoEnd* const end = live_.load()) end->safe();
}

Result<DeviceInfo> HelperDevice::startHelper(const DeviceInfo* same) {
  auto started = HelperProcess::start(options_);
  if (!started) return started.error();
  process_ = std::make_unique<HelperProcess>(std::move(*started));
  mapping_.get()->generation.store(++generation_);
  Result<void> sent = sendRequest(process_->socket(), {info_.uri, generation_}, mapping_.descriptor());
  Result<HelperAnswer> answer = sent ? Error{ErrorCode::kTimeout, {}, {}, {}} : Result<HelperAnswer>(sent.error());
  for (int waited_ms = 0; sent && waited_ms < kOpen_ms && !stop_.load(); waited_ms += kLook_ms) {
    answer = receiveAnswer(process_->socket(), kLook_ms);
    if (answer || answer.error().code != ErrorCode::kTimeout) break;
  }
  if (answer && answer->opened && same != nullptr && !isSame(*same, answer->info)) {
    process_.reset();  // Its limits are another's, and its client would push a stranger's hand.
    return Error{ErrorCode::kDeviceBusy, info_.uri, "another device stands in its place", "plug in the one that was"};
  }
  if (answer && answer->opened) {
    pid_.store(process_->pid());
    gone_.store(false, std::memory_order_release);
    return std::move(answer->info);
  }
  process_.reset();
  return answer ? answer->opened.error() : answer.error();
}

bool HelperDevice::waitUntilItEnds() noexcept {
  while (!stop_.load()) {
    pollfd look{process_->socket(), POLLIN, 0};
    // It has nothing more to say: whatever comes is its end.
    if (::poll(&look, 1, kLook_ms) > 0) return true;
  }
  return false;
}

void HelperDevice::watch() noexcept {
  while (!stop_.load()) {
    if (process_ && !waitUntilItEnds()) return;
    if (process_) died_.store(true, std::memory_order_release);
    gone_.store(true, std::memory_order_release);
    pid_.store(0);
    process_.reset();
    end_->lost();  // Again with each attempt: the servo may not have heard yet that it is gone.
    const bool back =
        startHelper(&info_).ok();  // At once: what its library has left in the motors goes to zero by that.
    for (int waited_ms = 0; !back && waited_ms < kRetry_ms && !stop_.load(); waited_ms += kLook_ms) {
      (void)::poll(nullptr, 0, kLook_ms);
    }
  }
}

}  // namespace hapticd
