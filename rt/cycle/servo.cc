#include "rt/cycle/servo.h"

#include <algorithm>
#include <limits>

#include "rt/ring/shared.h"

namespace hapticd {
namespace {

/** Publishes one field of region A that the servo alone writes; the client reads it at any time. */
template <class T>
void publishField(T& field, T value) HD_RT {
  std::atomic_ref<T>(field).store(value, std::memory_order_relaxed);
}

std::uint32_t clampToU32(std::int64_t x) HD_RT {
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(x, 0, std::numeric_limits<std::uint32_t>::max()));
}

/** What all sessions see alike of a device's tick: in the world. */
void fillSample(const DeviceSample& in, const DeviceOutput& out, const Mount& mount, bool clutched,
                hd_sample& sample) HD_RT {
  store(out.pose.p, sample.p);
  store(out.pose.q, sample.q);
  store(out.velocity.v, sample.v);
  store(out.velocity.w, sample.w);
  store(out.contact.object != 0 ? out.contact.proxy : out.pose.p, sample.proxy);
  const Wrench sent = mount.toWorld(Wrench{out.command.force, out.command.torque});
  store(sent.force, sample.force);
  store(sent.torque, sample.torque);
  for (std::uint32_t s = 0; s < HD_SOURCES; ++s) {
    const Vec3 force = mount.toWorld(out.guard.by_source[s]);
    for (int axis = 0; axis < 3; ++axis) sample.by_source[s][axis] = static_cast<float>(force[axis]);
  }
  sample.buttons = in.buttons;
  sample.gripper_rad = in.gripper_rad;
  sample.gripper_force_n = out.command.gripper_force;
  sample.energy_j = static_cast<float>(out.guard.energy);
  sample.depth_m = static_cast<float>(out.contact.depth);
  sample.contact_object = out.contact.object;
  sample.fault = out.guard.fault;
  sample.flags = out.guard.flags;
  if (out.contact.object != 0) sample.flags |= HD_SAMPLE_CONTACT;
  if (out.contact.slip) sample.flags |= HD_SAMPLE_SLIP;
  if (clutched) sample.flags |= HD_SAMPLE_CLUTCHED;
  if (!in.fresh) sample.flags |= HD_SAMPLE_STALE;
  if ((in.status & kDeviceSaturated) != 0) sample.flags |= HD_SAMPLE_SATURATED;
}

}  // namespace

Servo::Servo(const CycleConfig& config, std::array<Device*, kMaxDevices> devices, const MeshTable& meshes, Clock& clock)
    : config_(config),
      devices_(devices),
      clock_(clock),
      cycle_(config, meshes),
      input_(std::make_unique<CycleInput>()),
      output_(std::make_unique<CycleOutput>()),
      question_(std::make_unique<CollideRequest>()) {
  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    const DeviceInfo& info = devices_[d]->info();
    cycle_.setResolution(d, info.position_resolution, info.rotation_resolution);
  }
}

void Servo::begin() HD_RT { deadline_ns_ = (clock_.now() / config_.period_ns + 1) * config_.period_ns; }

void Servo::skipPassed() HD_RT {
  const std::int64_t late_ns = clock_.now() - deadline_ns_;
  if (late_ns < 0) return;
  const std::int64_t passed = late_ns / config_.period_ns + 1;
  deadline_ns_ += passed * config_.period_ns;
  tick_ += static_cast<std::uint64_t>(passed);
}

void Servo::publishPoses() HD_RT {
  for (std::uint32_t i = 0; i < kMaxObjects; i += PoseBoard::kPerCycle) {
    poses.publish(cycle_.scene(), tick_, orders_taken_);
  }
}

void Servo::runOnce() HD_RT {
  clock_.sleepUntil(deadline_ns_);
  const std::int64_t woke_ns = clock_.now();

  // Keep the phase: skip whole periods that have passed, never run one twice to catch up.
  const std::int64_t late_ns = woke_ns - deadline_ns_;
  const std::int64_t missed = late_ns >= config_.period_ns ? late_ns / config_.period_ns : 0;
  deadline_ns_ += missed * config_.period_ns;
  tick_ += static_cast<std::uint64_t>(missed) + 1;
  input_->tick = tick_;
  input_->now_ns = deadline_ns_;
  input_->missed = clampToU32(missed);
  input_->stop_line = stop_line.load(std::memory_order_acquire);
  input_->deadman_open = deadman_open.load(std::memory_order_acquire);
  if (lines != nullptr) {
    if (lines->stopAt(woke_ns)) input_->stop_line = true;
    if (lines->deadman_open.load(std::memory_order_acquire)) input_->deadman_open = true;
  }

  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    input_->device[d].fresh = false;
    devices_[d]->read(deadline_ns_, input_->device[d]);
    if (deadmanOpen(d)) input_->deadman_open = true;
    if (lines != nullptr) addButtons(d);
  }
  const std::int64_t read_ns = clock_.now();

  gather();
  cycle_.applyCommands(*input_, *output_);
  cycle_.render(*input_, *output_);
  const std::int64_t rendered_ns = clock_.now();

  cycle_.guard(*input_, *output_);
  const std::int64_t guarded_ns = clock_.now();

  bool enabled = false;
  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    const DeviceOutput& out = output_->device[d];
    if (out.has_intent) devices_[d]->setIntent(out.intent);
    enabled = enabled || out.command.enabled;
    counters.heat[d].store(static_cast<float>(out.guard.heat), std::memory_order_relaxed);
    devices_[d]->write(deadline_ns_, out.command);
  }
  if (sign != nullptr) {
    sign->enabled.store(enabled, std::memory_order_relaxed);
    sign->cycles.fetch_add(1, std::memory_order_release);  // R9, pairs with A9 in Panel::show(): `enabled` is of it
  }
  const std::int64_t written_ns = clock_.now();

  if (CycleLog* to = log.load(std::memory_order_acquire)) to->push(*input_, *output_, config_.device_count);
  askCollider();
  publish(woke_ns, late_ns);
  const std::int64_t done_ns = clock_.now();

  histograms.wake.record(late_ns);
  histograms.read.record(read_ns - woke_ns);
  histograms.render.record(rendered_ns - read_ns);
  histograms.guard.record(guarded_ns - rendered_ns);
  histograms.write.record(written_ns - guarded_ns);
  histograms.cycle.record(done_ns - woke_ns);
  last_cycle_duration_ns_ = done_ns - woke_ns;
  deadline_ns_ += config_.period_ns;
  count(done_ns, late_ns);
}

/** Of a device that is its group's. One that is no longer heard of is not held: what it said last says nothing now. */
bool Servo::deadmanOpen(std::uint32_t device) HD_RT {
  const DeviceSample& sample = input_->device[device];
  Deadman& deadman = deadman_[device];
  const bool open = (sample.status & kGroupDeadmanOpen) != 0;
  deadman.is_one = deadman.is_one || open;  // It begins open.
  if (sample.fresh) deadman.heard_ns = deadline_ns_;
  return open || (deadman.is_one && deadline_ns_ - deadman.heard_ns > SafetyLines::kDeaf_ns);
}

/** The panel's buttons follow the device's own. */
void Servo::addButtons(std::uint32_t device) HD_RT {
  const std::uint32_t count = lines->button_count.load(std::memory_order_relaxed);
  const std::uint32_t own = devices_[device]->info().buttons;
  if (count == 0 || own + count > 32) return;
  const std::uint32_t mask = ((count == 32 ? 0 : 1u << count) - 1u) << own;
  std::uint32_t& buttons = input_->device[device].buttons;
  buttons = (buttons & ~mask) | (lines->buttons.load(std::memory_order_relaxed) << own & mask);
}

void Servo::gather() HD_RT {
  std::uint32_t n = 0;
  std::uint32_t orders = 0;
  while (orders < kControlCommandsPerCycle && from_control.pop(input_->command[n])) {
    const Command& order = input_->command[n];
    if (order.kind == CommandKind::kAddSession || order.kind == CommandKind::kFreeSession) {
      const std::uint32_t slot = order.as<SessionRef>().slot;
      if (slot < kMaxSessions) {
        const bool add = order.kind == CommandKind::kAddSession;
        writers_[slot] = StateWriter(add ? ports[slot].region.load(std::memory_order_acquire) : nullptr);
      }
    }
    ++orders;
    ++n;
  }
  orders_taken_ += orders;
  if (ingest != nullptr) {
    const std::uint32_t end = n + kIngestCommandsPerCycle;
    while (n < end && ingest->commands.pop(input_->command[n])) ++n;
  }
  if (collider != nullptr) {
    const std::uint32_t end = n + kCollideCommandsPerCycle;
    while (n < end && collider->answers.pop(input_->command[n])) ++n;
  }
  input_->command_count = n;
}

void Servo::askCollider() HD_RT {
  if (collider == nullptr) return;
  const bool any = cycle_.ask(*question_);
  if (!any && !asked_) return;
  asked_ = any;  // when the last tool is gone an empty question replaces the one that names it
  question_->orders = orders_taken_;
  collider->questions.put(*question_);
}

void Servo::publish(std::int64_t woke_ns, std::int64_t late_ns) HD_RT {
  hd_sample sample{};
  sample.tick = tick_;
  sample.t_ns = woke_ns;
  sample.wake_ns = clampToU32(late_ns);
  sample.cycle_ns = clampToU32(last_cycle_duration_ns_);
  sample.missed =
      clampToU32(static_cast<std::int64_t>(counters.missed.load(std::memory_order_relaxed) + input_->missed));
  sample.applied_commands = output_->applied_commands;
  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    sample.device = d;
    fillSample(input_->device[d], output_->device[d], cycle_.mount(d), cycle_.clutch(d).frozen(), sample);
    if (no_realtime.load(std::memory_order_relaxed)) sample.flags |= HD_SAMPLE_NO_RT;
    for (std::uint32_t s = 0; s < kMaxSessions; ++s) {
      if (writers_[s].region() == nullptr) continue;
      const Vec3 own = cycle_.clutch(d).weight() * cycle_.session(s).last(d);
      for (int axis = 0; axis < 3; ++axis) sample.own[axis] = static_cast<float>(own[axis]);
      writers_[s].publish(sample);
    }
  }
  for (std::uint32_t s = 0; s < kMaxSessions; ++s) {
    if (writers_[s].region() != nullptr) publishSession(s);
  }
  poses.publish(cycle_.scene(), tick_, orders_taken_);
  const EventBatch& batch = output_->events;
  std::uint32_t dropped = batch.dropped;
  for (std::uint32_t i = 0; i < batch.count; ++i) {
    // What is of clients, and control does not fetch in time, leaves half of the way to what devices and hands do.
    const bool full = isOfClients(batch.event[i].kind) && events.size() >= decltype(events)::kCapacity / 2;
    if (full || !events.push(batch.event[i])) ++dropped;
  }
  if (dropped != 0) counters.events_dropped.fetch_add(dropped, std::memory_order_relaxed);
}

void Servo::publishSession(std::uint32_t slot) HD_RT {
  hd_region_a& a = *writers_[slot].region();
  const SessionShare& session = cycle_.session(slot);
  publishField(a.acks.applied_tick, session.appliedTick());
  // R8, pairs with A8 in haptic_session_acks(): who sees a command in force sees its tick, and the samples until now.
  storeRelease(a.acks.applied_seq, session.appliedSeq());
  publishField(a.acks.fade, session.fade(input_->now_ns));
  for (std::uint32_t m = 0; m < HD_MODEL_SLOTS; ++m) {
    const hd_model_status status = session.model(m).status(input_->now_ns);
    publishField(a.models[m].seq, status.seq);
    publishField(a.models[m].age_ns, status.age_ns);
    publishField(a.models[m].weight, status.weight);
    publishField(a.models[m].state, status.state);
  }
  publishField(a.counters.cycles, counters.cycles.load(std::memory_order_relaxed));
  publishField(a.counters.missed, counters.missed.load(std::memory_order_relaxed));
  publishField(a.counters.overruns, counters.overruns.load(std::memory_order_relaxed));
  publishField(a.counters.stale_samples, counters.stale.load(std::memory_order_relaxed));
  publishField(a.counters.contacts, counters.contacts.load(std::memory_order_relaxed));
  publishField(a.counters.faults, counters.faults.load(std::memory_order_relaxed));
  publishField(a.counters.max_wake_ns, max_wake_ns_);
  publishField(a.counters.max_cycle_ns, max_cycle_ns_);
}

void Servo::count(std::int64_t done_ns, std::int64_t late_ns) HD_RT {
  const auto add = [](std::atomic<std::uint64_t>& counter, std::uint64_t n) noexcept {
    if (n != 0) counter.store(counter.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
  };
  std::uint64_t contacts = 0;
  std::uint64_t faults = 0;
  for (std::uint32_t i = 0; i < output_->events.count; ++i) {
    contacts += output_->events.event[i].kind == ServoEventKind::kTouch ? 1 : 0;
    faults += output_->events.event[i].kind == ServoEventKind::kFault ? 1 : 0;
  }
  std::uint64_t stale = 0;
  for (std::uint32_t d = 0; d < config_.device_count; ++d) stale += input_->device[d].fresh ? 0 : 1;
  const bool overran = input_->missed != 0 || done_ns > deadline_ns_;
  max_wake_ns_ = std::max(max_wake_ns_, clampToU32(late_ns));
  max_cycle_ns_ = std::max(max_cycle_ns_, clampToU32(last_cycle_duration_ns_));
  // R7, pairs with A7 in GroupLink::cycles(): what this cycle had to leave in a log is there.
  counters.cycles.store(counters.cycles.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  add(counters.missed, input_->missed);
  add(counters.overruns, overran ? 1 : 0);
  add(counters.stale, stale);
  add(counters.contacts, contacts);
  add(counters.faults, faults);
  counters.tick.store(tick_, std::memory_order_relaxed);
  counters.last_cycle_ns.store(done_ns, std::memory_order_relaxed);
  // R2, pairs with A2 in DeviceGroup::taken(): what the taken orders replaced is no longer in use.
  counters.control_applied.store(orders_taken_, std::memory_order_release);
}

void Servo::end() HD_RT {
  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    devices_[d]->write(deadline_ns_, DeviceCommand{});
  }
}

}  // namespace hapticd
