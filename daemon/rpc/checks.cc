// What doctor can learn from the daemon alone.
#include <fmt/format.h>
#include <sys/resource.h>

#include "daemon/device/device_status.h"
#include "daemon/rpc/status.h"
#include "drivers/vendor/vendor_driver.h"

namespace hapticd {
namespace {

using State = proto::Check::State;

std::string mebibytes(std::uint64_t bytes) { return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / 1048576); }

CheckLine scheduling(Core& core) {
  if (core.devices().links().empty()) return {"real-time scheduling", State::NOT_APPLICABLE, "no device is open", {}};
  if (core.devices().realtime()) {
    return {"real-time scheduling",
            State::GREEN,
            fmt::format("SCHED_FIFO {}, ingest {}", core.config().servo.servo_priority,
                        core.config().servo.ingest_priority),
            {}};
  }
  return {"real-time scheduling", State::RED, core.devices().schedulingNote(),
          "have '@haptic - rtprio 85' in /etc/security/limits.d/hapticd.conf and log in as a member of group haptic"};
}

CheckLine memory(Core& core) {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const std::string detail = fmt::format("limit {}, {} locked for clients",
                                         limit.rlim_cur == RLIM_INFINITY ? "unlimited" : mebibytes(limit.rlim_cur),
                                         mebibytes(core.lockedBytes()));
  if (core.facts().memory_locked) return {"memory lock", State::GREEN, detail, {}};
  if (!core.config().servo.lock_memory) return {"memory lock", State::NOT_APPLICABLE, "servo.lock_memory is off", {}};
  return {"memory lock", State::RED, core.facts().memory_note + "; " + detail,
          "LimitMEMLOCK=1G in the unit, or memlock in /etc/security/limits.d"};
}

CheckLine latency(Core& core) {
  if (!core.config().servo.hold_cpu_latency)
    return {"cpu_dma_latency", State::NOT_APPLICABLE, "servo.hold_cpu_latency is off", {}};
  if (core.facts().cpu_latency_held) return {"cpu_dma_latency", State::GREEN, "held at 0", {}};
  return {"cpu_dma_latency", State::RED, core.facts().cpu_latency_note,
          "install the udev rules: KERNEL==\"cpu_dma_latency\", GROUP=\"haptic\", MODE=\"0660\""};
}

CheckLine builder(Core& core) {
  const BuilderLeash* leash = core.uploads().builder();
  if (leash == nullptr) {
    return {"builder", State::RED, core.uploads().builderNote(),
            "install hapticd-builder beside hapticd, or set builder.program"};
  }
  if (const std::string& trouble = leash->trouble(); !trouble.empty()) {
    return {"builder", State::RED, trouble + ", and had built nothing",
            "set builder.program to hapticd-builder of this version, or leave it out; the next mesh starts it again"};
  }
  return {"builder",
          State::GREEN,
          leash->pid() != 0 ? fmt::format("pid {}, {} restarts", leash->pid(), leash->restarts())
                            : std::string("starts with the next mesh"),
          {}};
}

CheckLine folderOfVolumes(Core& core) {
  VolumeCache* const cache = core.uploads().cache();
  if (cache == nullptr)
    return {"volumes on disk", State::NOT_APPLICABLE, "none are kept (builder.cache, builder.cache_mb)", {}};
  if (const auto trouble = cache->trouble())
    return {"volumes on disk", State::RED, trouble->where + ": " + trouble->what, trouble->remedy};
  return {"volumes on disk", State::GREEN, cache->directory(), {}};
}

CheckLine socketLine(const char* name, const std::string& path) {
  if (path.empty()) return {name, State::NOT_APPLICABLE, "not served", {}};
  return {name, State::GREEN, path, {}};
}

/** Nobody needs one who has no such device. */
CheckLine vendors() {
  std::string detail, absent;
  for (const SdkPresence& sdk : vendorSdks()) {
    detail += fmt::format("{}{}: {}", detail.empty() ? "" : "; ", sdk.name,
                          sdk.path.empty() ? fmt::format("no {}", sdk.library) : sdk.path);
    if (sdk.path.empty()) absent += fmt::format("{}{}://", absent.empty() ? "" : " and ", sdk.scheme);
  }
  return {"vendor SDKs", absent.find(' ') == std::string::npos ? State::GREEN : State::NOT_APPLICABLE, detail,
          absent.empty()
              ? std::string()
              : fmt::format("for {}: install the maker's SDK, or name its library by sdk= in hapticd.toml", absent)};
}

CheckLine device(const OpenDevice& device) {
  const DeviceNow s = statusOf(device);
  const std::string name = "device " + device.name;
  if (s.sample.fault != HD_FAULT_NONE) {
    return {name, State::RED, fmt::format("fault: {}", faultText(s.sample.fault)),
            fmt::format("{}, then: hapticctl arm {}",
                        s.sample.fault == HD_FAULT_OVERRUN ? "see which line above is not green" : "clear the cause",
                        device.name)};
  }
  return {name,
          State::GREEN,
          fmt::format("{}, {:g} Hz, {} of {} periods missed, {}", device.info().uri, s.rate_hz, s.missed,
                      s.cycles + s.missed, s.armed ? "armed" : "disarmed"),
          {}};
}

/** Told to be open, and not open. */
CheckLine missing(const WantedGroups::Absent& one) {
  return {"missing device", State::RED,
          fmt::format("{}, group {}: {}: {}{}", one.uri, one.group, one.why.where, one.why.what,
                      one.passed_over ? "; another was taken" : ""),
          fmt::format("{}{}hapticctl arm {}", one.why.remedy, one.why.remedy.empty() ? "" : "; then: ", one.uri)};
}

CheckLine heartbeat(Core& core, GroupLink& link) {
  constexpr std::int64_t kLateNs = 100'000'000;
  const std::int64_t age_ns = core.now() - link.group().servo().counters.last_cycle_ns.load(std::memory_order_relaxed);
  const std::string name = "servo " + link.name();
  if (link.cycles() != 0 && age_ns < kLateNs) return {name, State::GREEN, fmt::format("{} cycles", link.cycles()), {}};
  return {name, State::RED, fmt::format("no cycle for {:.1f} ms", static_cast<double>(age_ns) * 1e-6),
          "restart hapticd and report it"};
}

/** What the collide thread could not do. */
CheckLine collision(GroupLink& link) {
  constexpr double kMost = 0.01;  ///< Share of the answers since the servo's start.
  const CollideNow c = collideOf(link.group());
  const std::string name = "collision " + link.name();
  if (c.queries == 0) return {name, State::NOT_APPLICABLE, "nothing is held or moves freely", {}};
  const std::string detail =
      fmt::format("{} answers, {} cut short for want of time or work, {} lost", c.queries, c.exhausted, c.unsent);
  const double most = kMost * static_cast<double>(c.queries);
  if (static_cast<double>(c.unsent) > most) {
    return {name, State::RED, detail, "the servo stands or is late: mend what is red above"};
  }
  if (static_cast<double>(c.exhausted) > most) {
    return {
        name, State::RED, detail,
        "contacts come late: hold and move fewer things, load them with volumes, or with larger voxels (hapticctl load "
        "--voxel)"};
  }
  return {name, State::GREEN, detail, {}};
}

}  // namespace

std::vector<CheckLine> makeChecks(Core& core) {
  std::vector<CheckLine> lines{scheduling(core),
                               memory(core),
                               latency(core),
                               builder(core),
                               folderOfVolumes(core),
                               vendors(),
                               socketLine("control socket", core.facts().control_socket),
                               socketLine("administration socket", core.facts().admin_socket)};
  for (const auto& link : core.devices().links()) {
    lines.push_back(heartbeat(core, *link));
    lines.push_back(collision(*link));
  }
  for (const auto& d : core.devices().devices()) lines.push_back(device(*d));
  for (const auto& one : core.wanted().absent()) lines.push_back(missing(one));
  return lines;
}

}  // namespace hapticd
