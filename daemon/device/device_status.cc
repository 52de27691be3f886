#include "daemon/device/device_status.h"

#include <fmt/format.h>

#include <atomic>

namespace hapticd {
namespace {

/** A field of region A that another thread of the daemon writes. */
template <class T>
T load(const T& field) {
  return std::atomic_ref<T>(const_cast<T&>(field)).load(std::memory_order_relaxed);
}

}  // namespace

std::array<Stage, 7> stagesOf(DeviceGroup& group) {
  ServoHistograms& h = group.servo().histograms;
  return {{{"wake", &h.wake},
           {"read", &h.read},
           {"render", &h.render},
           {"guard", &h.guard},
           {"write", &h.write},
           {"cycle", &h.cycle},
           {"collide", &group.colliderCounters().duration}}};
}

CollideNow collideOf(DeviceGroup& group) {
  const ColliderCounters& counters = group.colliderCounters();
  return {counters.queries.load(std::memory_order_relaxed), counters.exhausted.load(std::memory_order_relaxed),
          counters.unsent.load(std::memory_order_relaxed)};
}

DeviceNow statusOf(const OpenDevice& device) {
  DeviceGroup& group = device.link->group();
  Servo& servo = group.servo();
  const auto period_ns = static_cast<double>(group.options().cycle.period_ns);
  DeviceNow status;
  if (!device.link->latest(device.index, status.sample)) status.sample = {};
  status.armed = (status.sample.flags & HD_SAMPLE_ARMED) != 0 || !device.device().isOff();
  status.rate_hz = 1e9 / period_ns;
  status.cycles = servo.counters.cycles.load(std::memory_order_relaxed);
  status.missed = servo.counters.missed.load(std::memory_order_relaxed);
  status.overruns = servo.counters.overruns.load(std::memory_order_relaxed);
  status.stale = servo.counters.stale.load(std::memory_order_relaxed);
  status.busy = static_cast<double>(servo.histograms.cycle.summary().p50_ns) / period_ns;
  status.heat = servo.counters.heat[device.index].load(std::memory_order_relaxed);
  status.wake_p99_ns = servo.histograms.wake.summary().p99_ns;
  status.policy = group.realtime() ? fmt::format("SCHED_FIFO {}", group.options().servo_priority) : "SCHED_OTHER";
  return status;
}

SessionNow statusOf(const Session& session) {
  const hd_region_a& a = *session.regions.a();
  SessionNow status;
  status.received = session.link->group().ingest().received[session.slot].load(std::memory_order_relaxed);
  status.rejected = load(a.acks.rejected);
  status.stale = load(a.acks.stale_mailboxes);
  status.violations = load(a.acks.violations);
  status.applied_seq = load(a.acks.applied_seq);
  status.fade = load(a.acks.fade);
  status.heartbeat_age_ns = load(a.acks.heartbeat_age_ns);
  for (const hd_model_status& model : a.models)
    status.models += load(model.state) == 1 || load(model.state) == 2 ? 1 : 0;
  return status;
}

}  // namespace hapticd
