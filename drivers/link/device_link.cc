#include "drivers/link/device_link.h"

#include <time.h>

namespace hapticd {

void DeviceLink::read(std::int64_t now_ns, DeviceSample& sample) HD_RT {
  sample.fresh = false;
  if (to_servo_.take(taken_)) {
    if (taken_.measured) {
      sample = taken_.sample;
      sample.fresh = true;
      age.record(now_ns - sample.t_ns);
    } else {
      sample.status = taken_.sample.status;
    }
  }
  // After take(), which acquires what publishStatus() did before a reading that came later: told with that one.
  if (told_.load(std::memory_order_relaxed) != 0) sample.status |= told_.exchange(0);
}

void DeviceLink::write(std::int64_t now_ns, const DeviceCommand& command) HD_RT {
  to_device_.put({command, now_ns});
  // After the command that is off, so that no older one can follow.
  if (!command.enabled) safe_.store(false, std::memory_order_release);  // R, pairs with A in command()
}

void DeviceLink::publishStatus(std::uint32_t status) HD_RT {
  Reading reading;
  reading.sample.status = status;
  told_.fetch_or(status);  // Before put(), which releases it: the servo may see it early, never late.
  to_servo_.put(reading);
}

DeviceCommand DeviceLink::command(std::int64_t now_ns) HD_RT {
  const bool safe = safe_.load();  // A, before the command is taken; and after S1
  (void)to_device_.take(order_);
  if (safe || !order_.command.enabled) return {};
  if (now_ns - order_.t_ns > stale_ns_) {
    LinkCounters::add(counters.stale_commands);
    return {};
  }
  return order_.command;
}

bool DeviceLink::awaitSent(std::int64_t most_ns) const noexcept {
  constexpr std::int64_t kLook_ns = 50'000;
  for (std::int64_t waited_ns = 0; sending_.load(); waited_ns += kLook_ns) {
    if (waited_ns >= most_ns) return false;
    const timespec look{0, kLook_ns};
    (void)clock_nanosleep(CLOCK_MONOTONIC, 0, &look, nullptr);
  }
  return true;
}

}  // namespace hapticd
