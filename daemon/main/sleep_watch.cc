#include "daemon/main/sleep_watch.h"

#include <cstring>
#include <utility>

namespace hapticd {
namespace {

constexpr const char* kName = "org.freedesktop.login1";
constexpr const char* kPath = "/org/freedesktop/login1";
constexpr const char* kManager = "org.freedesktop.login1.Manager";
constexpr int kMessages = 16;  // In a step.

}  // namespace

SleepWatch::SleepWatch(Core& core, Open open) : core_(core), open_(std::move(open)) {}

SleepWatch::~SleepWatch() = default;

void SleepWatch::step() {
  if (!lock_.valid() && !asleep_ && core_.now() >= next_try_ns_) {
    next_try_ns_ = core_.now() + kAgain_ns;
    if (const int r = bus_ ? takeLock() : connect(); r < 0) return lose(r);
  }
  for (int i = 0, r = 1; bus_ && i < kMessages && r > 0; ++i) {
    r = sd_bus_process(bus_.get(), nullptr);
    if (r < 0) return lose(r);
  }
  if (asleep_ && lock_.valid() && core_.allOff()) lock_.reset();
  if (asleep_ && core_.now() - since_ns_ > kFallingAsleep_ns) sleeps(false);
}

int SleepWatch::connect() {
  sd_bus* bus = nullptr;
  if (const int r = open_(&bus); r < 0) return r;
  bus_.reset(bus);
  const int r =
      sd_bus_match_signal_async(bus, nullptr, kName, kPath, kManager, "PrepareForSleep", onSleep, nullptr, this);
  return r < 0 ? r : takeLock();
}

int SleepWatch::takeLock() {
  return sd_bus_call_method_async(bus_.get(), nullptr, kName, kPath, kManager, "Inhibit", onLock, this, "ssss", "sleep",
                                  "hapticd", "Takes the force off the haptic devices", "delay");
}

/** Without a bus nobody would say that the machine is awake again. */
void SleepWatch::lose(int error) {
  bus_.reset();
  lock_.reset();
  if (asleep_) sleeps(false);
  if (std::exchange(told_, true)) return;
  log::info("no way to learn when the machine goes to sleep: {}", std::strerror(-error));
}

void SleepWatch::sleeps(bool asleep) {
  asleep_ = asleep;
  since_ns_ = core_.now();
  core_.setAsleep(asleep);
}

int SleepWatch::onSleep(sd_bus_message* message, void* self, sd_bus_error*) {
  auto& watch = *static_cast<SleepWatch*>(self);
  int asleep = 0;
  if (sd_bus_message_read(message, "b", &asleep) < 0) return 0;
  watch.sleeps(asleep != 0);
  if (asleep == 0 && !watch.lock_.valid()) (void)watch.takeLock();  // A bus that is lost is seen by step().
  return 0;
}

int SleepWatch::onLock(sd_bus_message* message, void* self, sd_bus_error*) {
  auto& watch = *static_cast<SleepWatch*>(self);
  if (const sd_bus_error* const refused = sd_bus_message_get_error(message); refused != nullptr) {
    if (!std::exchange(watch.told_, true)) {
      log::info("sleep is not held up for the devices: {}",
                log::printable(refused->message != nullptr ? refused->message : refused->name));
    }
    return 0;
  }
  int fd = -1;  // The message's own.
  if (sd_bus_message_read(message, "h", &fd) < 0) return 0;
  if (auto held = duplicate(fd)) watch.lock_ = std::move(*held);
  return 0;
}

}  // namespace hapticd
