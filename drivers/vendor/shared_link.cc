#include "drivers/vendor/shared_link.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/** Those that a device of its own may set: a helper cannot be a group's dead-man switch. */
constexpr std::uint32_t kDeviceStatusBits = kDeviceError | kDeviceGone | kDeviceSaturated | kDeviceDeadmanOpen;

}  // namespace

static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<std::uint32_t>::is_always_lock_free);

void SharedServoEnd::read(std::int64_t now_ns, DeviceSample& sample) HD_RT {
  sample.fresh = false;
  SharedSample taken;
  if (memory_.up.take(taken, seen_) != Taken::kNew) return;
  if (taken.measured == 0) {
    if ((taken.status & kDeviceGone) != 0) gone_.store(true);
    sample.status = (taken.status & kDeviceStatusBits) | kDeviceError;  // A helper has no good news without a reading.
    return;
  }
  const Vec3 p(taken.p[0], taken.p[1], taken.p[2]);
  const Quat q(taken.q[0], taken.q[1], taken.q[2], taken.q[3]);
  const double norm = q.squaredNorm();
  if (!p.allFinite() || !(std::abs(norm - 1) < 0.01) || !std::isfinite(taken.gripper_rad)) {
    sample.status |= kDeviceError;
    return;
  }
  sample.t_ns = std::clamp<std::int64_t>(taken.t_ns, 0, now_ns);  // Differences of times must not overflow.
  sample.p = p;
  sample.q = q.normalized();
  sample.gripper_rad = taken.gripper_rad;
  sample.buttons = taken.buttons;
  sample.status = taken.status & kDeviceStatusBits;
  sample.fresh = true;
  gone_.store(false);
  if (off_since_ns_ != 0 && taken.answers_ns >= off_since_ns_) off_.store(true);
  if (taken.answers_ns > 0 && taken.answers_ns <= now_ns) round_trip.record(now_ns - taken.answers_ns);
}

void SharedServoEnd::write(std::int64_t now_ns, const DeviceCommand& command) HD_RT {
  SharedOrder order{};
  order.t_ns = now_ns;
  for (int i = 0; i < 3; ++i) {
    order.force[i] = command.force[i];
    order.torque[i] = command.torque[i];
  }
  order.gripper_force = command.gripper_force;
  order.enabled = command.enabled ? 1 : 0;
  if (command.enabled) {
    off_.store(false);
    off_since_ns_ = 0;
  } else if (off_since_ns_ == 0) {
    off_since_ns_ = now_ns;
  }
  memory_.down.put(order);
  // After the order that is off, so that no older one can follow.
  if (!command.enabled) memory_.safe.store(0, std::memory_order_release);
}

bool SharedDeviceEnd::current() const HD_RT {
  return memory_.generation.load(std::memory_order_relaxed) == generation_;
}

void SharedDeviceEnd::publish(const DeviceSample& sample) HD_RT {
  if (!current()) return;
  SharedSample out{};
  out.t_ns = sample.t_ns;
  if (isTaken()) answers_ns_ = order_.t_ns;
  out.answers_ns = answers_ns_;
  for (int i = 0; i < 3; ++i) out.p[i] = sample.p[i];
  out.q[0] = sample.q.w();
  out.q[1] = sample.q.x();
  out.q[2] = sample.q.y();
  out.q[3] = sample.q.z();
  out.gripper_rad = sample.gripper_rad;
  out.buttons = sample.buttons;
  out.status = sample.status | (tell_ > 0 ? told_ : 0u);
  tell_ = std::max(0, tell_ - 1);
  out.measured = 1;
  memory_.up.put(out);
}

void SharedDeviceEnd::publishStatus(std::uint32_t status) HD_RT {
  if (!current()) return;
  SharedSample out{};
  out.status = status;
  told_ = tell_ > 0 ? told_ | status : status;
  tell_ = kTell;
  memory_.up.put(out);
}

DeviceCommand SharedDeviceEnd::command(std::int64_t now_ns) HD_RT {
  const bool safe = memory_.safe.load() != 0;  // Before the order is taken.
  const Taken taken = memory_.down.take(order_, seen_);
  if (safe || !current() || order_.enabled == 0) return {};
  // What there is instead of a newer order may be from before one that was off.
  if (taken == Taken::kBusy || now_ns - order_.t_ns > stale_ns_ || order_.t_ns > now_ns) {
    LinkCounters::add(counters.stale_commands);
    return {};
  }
  DeviceCommand command;
  command.enabled = true;
  command.force = vec3(order_.force);
  command.torque = vec3(order_.torque);
  command.gripper_force = order_.gripper_force;
  return command;
}

}  // namespace hapticd
