// From the configuration to what a group of devices is started with.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/device/device_manager.h"

namespace hapticd {

/** What the configuration says of that device alone; null: nothing. */
const DeviceConfig* DeviceManager::entryOf(const DeviceInfo& info) const {
  if (const DeviceConfig* const entry = config_.entryOf(info.uri, info.serial)) return entry;
  // A URI like falcon://default stands for a certain device only once that is plugged in.
  const auto means = [&](const DeviceConfig& entry) {
    if (entry.uri.find("://") == std::string::npos) return false;
    const auto made = make_(entry.uri, {});
    return made && (*made)->info().uri == info.uri;
  };
  const auto entry = std::find_if(config_.devices.begin(), config_.devices.end(), means);
  return entry == config_.devices.end() ? nullptr : &*entry;
}

GroupOptions DeviceManager::options(const GroupConfig& group,
                                    const std::vector<std::unique_ptr<Device>>& devices) const {
  constexpr double kNsPerMs = 1e6;
  const double rate_hz = group.rate_hz > 0 ? group.rate_hz : config_.servo.rate_hz;
  GroupOptions o;
  o.volumes = &meshes_.volumes();
  o.cycle.period_ns = std::llround(1e9 / rate_hz);
  o.cycle.loss_fade_ns = std::llround(config_.sessions.loss_fade_ms * kNsPerMs);
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const DeviceInfo& info = devices[i]->info();
    GuardConfig& guard = o.cycle.guard[i];
    guard.ramp_ns = std::llround(config_.guard.arm_ramp_ms * kNsPerMs);
    guard.small_force = config_.guard.small_force_n;
    guard.small_force_ticks = config_.guard.small_force_ticks;
    guard.stale_ns = std::llround(config_.guard.device_stale_ms * kNsPerMs);
    guard.life_ns = devices[i]->commandLife_ns();
    guard.missed_limit = config_.servo.missed_limit;
    guard.passivity = config_.guard.passivity;
    guard.continuous_force = info.continuous_force;
    guard.peak_force = info.max_force;
    guard.heating_s = config_.guard.motor_heating_s;
    guard.delay = info.latency_s * rate_hz;
    if (info.max_damping > 0) guard.max_damping = info.max_damping;
  }
  o.ingest.budget_per_session = config_.sessions.budget_per_tick;
  o.ingest.stale_after_ns = std::llround(config_.sessions.stale_after_ms * kNsPerMs);
  o.ingest.max_ahead_ticks = static_cast<std::uint64_t>(config_.sessions.max_ahead_s * rate_hz);
  o.servo_priority = static_cast<int>(config_.servo.servo_priority);
  o.ingest_priority = static_cast<int>(config_.servo.ingest_priority);
  o.cpus = group.cpus;
  o.allow_no_rt = config_.servo.allow_no_rt;
  o.lines = lines_;
  o.threads = threads_;
  return o;
}

std::string DeviceManager::shortName(const DeviceInfo& info, const std::vector<std::string>& taken) const {
  std::string base;
  for (const char c : info.driver.empty() ? info.uri.substr(0, info.uri.find(':')) : info.driver) {
    const bool allowed = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    const bool upper = c >= 'A' && c <= 'Z';
    if (allowed || upper) base.push_back(upper ? static_cast<char>(c - 'A' + 'a') : c);
  }
  base = base.substr(0, 32);
  if (base.empty()) base = "device";
  std::string name = base;
  for (int n = 2; std::find(taken.begin(), taken.end(), name) != taken.end(); ++n) name = fmt::format("{}{}", base, n);
  return name;
}

}  // namespace hapticd
