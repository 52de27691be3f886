#include "daemon/main/supervisor.h"

#include <fmt/format.h>
#include <systemd/sd-daemon.h>

#include <algorithm>

#include "daemon/device/device_status.h"

namespace hapticd {

Supervisor::Supervisor(Core& core, bool notify) : core_(core), notify_(notify) {
  std::uint64_t interval_us = 0;
  if (notify_ && sd_watchdog_enabled(0, &interval_us) > 0)
    watchdog_ns_ = static_cast<std::int64_t>(interval_us) * 1000 / 3;
}

void Supervisor::step() {
  const std::int64_t now = core_.now();
  const auto& links = core_.devices().links();
  if (!ready_) {
    ready_ = std::all_of(links.begin(), links.end(), [](const auto& link) { return link->cycles() >= kCleanCycles; });
    if (!ready_) return;
    log::info("ready: {}", core_.facts().control_socket);
    if (notify_) sd_notify(0, "READY=1");
  }
  if (!notify_) return;
  if (watchdog_ns_ != 0 && now >= next_ping_ns_) {
    next_ping_ns_ = now + watchdog_ns_;
    if (heartbeatsAdvanced()) sd_notify(0, "WATCHDOG=1");
  }
  if (now >= next_status_ns_) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    next_status_ns_ = now + kSecond;
    std::string status;
    for (const auto& device : core_.devices().devices()) {
      const DeviceNow s = statusOf(*device);
      status +=
          fmt::format("{}{} {:g} Hz, {} missed, {}", status.empty() ? "" : "; ", device->name, s.rate_hz, s.missed,
                      s.sample.fault != HD_FAULT_NONE ? faultText(s.sample.fault)
                      : s.armed                       ? "armed"
                                                      : "disarmed");
    }
    for (const auto& one : core_.wanted().absent())
      status += fmt::format("{}{} missing", status.empty() ? "" : "; ", one.uri);
    if (!core_.devices().realtime()) status += "; not real-time";
    sd_notify(0, ("STATUS=" + status).c_str());
  }
}

bool Supervisor::heartbeatsAdvanced() {
  bool all = true;
  std::map<const GroupLink*, std::uint64_t> seen;  // A fresh map: an address may be another group's by now.
  for (const auto& link : core_.devices().links()) {
    const std::uint64_t cycles = seen[link.get()] = link->cycles();
    const auto before = last_cycles_.find(link.get());
    if (before == last_cycles_.end() || before->second != cycles) continue;
    log::error("the servo of group {} stands still", link->name());
    all = false;
  }
  last_cycles_ = std::move(seen);
  return all;
}

void Supervisor::stopping() {
  if (notify_) sd_notify(0, "STOPPING=1");
}

}  // namespace hapticd
