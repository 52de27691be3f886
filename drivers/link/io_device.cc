#include "drivers/link/io_device.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <future>

#include "drivers/resident.h"

namespace hapticd {
namespace {

constexpr std::size_t kStackBytes = 512 * 1024;
constexpr std::size_t kPrefaultBytes = 128 * 1024;

/** While it stands this thread has no real-time priority: it could keep a servo from its processor for milliseconds. */
class WithoutPriority {
 public:
  WithoutPriority() noexcept {
    if (pthread_getschedparam(pthread_self(), &policy_, &before_) != 0) return;
    const sched_param none{};
    const bool realtime = (policy_ & ~SCHED_RESET_ON_FORK) == SCHED_FIFO;
    // The flag stays: taking it off needs a right that the daemon does not have.
    lowered_ = realtime && pthread_setschedparam(pthread_self(), SCHED_OTHER | SCHED_RESET_ON_FORK, &none) == 0;
  }
  ~WithoutPriority() {
    if (lowered_) (void)pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &before_);
  }
  WithoutPriority(const WithoutPriority&) = delete;
  WithoutPriority& operator=(const WithoutPriority&) = delete;

 private:
  int policy_ = SCHED_OTHER;
  sched_param before_{};
  bool lowered_ = false;
};

}  // namespace

IoDevice::IoDevice(std::unique_ptr<DeviceIo> io, IoOptions options)
    : io_(std::move(io)), options_(options), clock_(monotonic_), link_(options.stale_ns) {}

IoDevice::IoDevice(std::unique_ptr<DeviceIo> io, IoOptions options, Clock& clock)
    : io_(std::move(io)), options_(options), clock_(clock), link_(options.stale_ns) {}

Calibration IoDevice::calibration() const noexcept {
  const Calibration told = io_->calibration();
  return told == Calibration::kNotNeeded || there_.load() ? told : Calibration::kNeeded;
}

Result<void> IoDevice::open() {
  close();
  stop_.store(false);
  if (given_up_.load()) stop_.store(true);  // After the line above, so that giveUp() is not lost whenever it comes.
  if (auto opened = io_->open(stop_); !opened) {
    io_->close();
    return opened;
  }
  open_ = there_ = true;
  link_.write(clock_.now(), {});  // What was commanded before it was closed is over.
  link_.forget();
  keepResident(this, sizeof *this);
  if (!options_.thread) return {};
  std::promise<std::string> scheduled;
  auto note = scheduled.get_future();
  auto started = thread_.start("device-io", kStackBytes, [this, &scheduled] {
    prefaultStack(kPrefaultBytes);
    const Result<void> rights = becomeRealtime(options_.priority);
    scheduled.set_value(rights ? std::string() : toString(rights.error()));
    while (!stop_.load(std::memory_order_relaxed)) serve(clock_.now() + options_.service_ns);
  });
  if (!started) {
    close();
    return started;
  }
  note_ = note.get();
  return {};
}

void IoDevice::close() noexcept {
  if (!open_) return;
  link_.safe();
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
  io_->close();
  open_ = there_ = false;
}

void IoDevice::giveUp() noexcept {
  given_up_.store(true);
  stop_.store(true);
}

void IoDevice::safe() noexcept {
  link_.safe();                                  // First: what the I/O thread takes from now on is zeros.
  (void)link_.awaitSent(options_.in_flight_ns);  // What it had taken before goes out before the zeros below, not after.
  io_->safe();
}

void IoDevice::pump(std::int64_t until_ns) noexcept {
  while (open_ && clock_.now() < until_ns) serve(until_ns);
}

void IoDevice::serve(std::int64_t until_ns) noexcept {
  if (!there_) {
    lookAgain(until_ns);
    return;
  }
  if (io_->exchange(link_, until_ns)) return;
  there_ = false;  // before the servo is told
  link_.publishStatus(io_->statusWhenGone());
  io_->close();
  link_.lost();
  next_look_ns_ = clock_.now() + options_.retry_ns;
}

void IoDevice::lookAgain(std::int64_t until_ns) noexcept {
  if (clock_.now() < next_look_ns_) {
    clock_.sleepUntil(std::min(until_ns, next_look_ns_));
    return;
  }
  {
    const WithoutPriority looking;  // It reads sysfs, and waits for firmware.
    there_ = io_->open(stop_).ok();
  }
  if (there_) {
    LinkCounters::add(link_.counters.replugs);
    return;
  }
  io_->close();
  next_look_ns_ = clock_.now() + options_.retry_ns;
}

}  // namespace hapticd
