#include "drivers/sim/sim_device.h"

#include <algorithm>

#include "drivers/resident.h"

namespace hapticd {
namespace {

double toStep(double value, double step) HD_RT { return step > 0 ? std::round(value / step) * step : value; }
Vec3 toStep(const Vec3& value, double step) HD_RT {
  return {toStep(value.x(), step), toStep(value.y(), step), toStep(value.z(), step)};
}

/** To the resolution, then at most `limit` in the same direction. Sizes beyond any motor first lose what overflows. */
Vec3 producible(const Vec3& wanted, double step, double limit, bool& cut) HD_RT {
  constexpr double kBeyondAnyMotor = 1e6;
  const double largest = wanted.cwiseAbs().maxCoeff();
  const Vec3 stepped = toStep(largest > kBeyondAnyMotor ? Vec3(wanted * (kBeyondAnyMotor / largest)) : wanted, step);
  cut = cut || stepped.norm() > limit;
  return clampNorm(stepped, limit);
}

BodyParameters linearBody(const SimParameters& p) {
  return {p.mass + p.hand_mass, p.viscous, p.coulomb, p.hand_stiffness, p.hand_damping};
}
BodyParameters rotatingBody(const SimParameters& p) {
  return {p.inertia + p.hand_inertia, p.angular_viscous, p.angular_coulomb, p.hand_angular_stiffness,
          p.hand_angular_damping};
}
BodyParameters gripperBody(const SimParameters& p) {
  return {p.gripper_mass, 0, 0, p.hand_pinch_stiffness, p.hand_pinch_damping};
}
Stops edges(const SimParameters& p) { return {p.lower, p.upper, p.stop_stiffness, p.stop_damping}; }
/** The gripper moves along x by angle times lever. */
Stops jaws(const SimParameters& p) {
  Stops stops;
  stops.lower.x() = 0;
  stops.upper.x() = p.gripper_max_angle * p.gripper_lever;
  stops.stiffness = p.stop_stiffness;
  stops.damping = p.stop_damping;
  return stops;
}
std::int64_t periodOf(const SimParameters& p) { return std::llround(1e9 / p.rate); }
int subStepsOf(const SimParameters& p) {
  return static_cast<int>(std::ceil(static_cast<double>(periodOf(p)) * 1e-9 / SimDevice::kMaxSubStep_s - 1e-9));
}

}  // namespace

SimDevice::SimDevice(SimSetup setup)
    : setup_(std::move(setup)),
      period_ns_(periodOf(setup_.parameters)),
      sub_steps_(subStepsOf(setup_.parameters)),
      sub_step_s_(static_cast<double>(period_ns_) * 1e-9 / sub_steps_),
      point_(linearBody(setup_.parameters), edges(setup_.parameters), sub_step_s_),
      gripper_(gripperBody(setup_.parameters), jaws(setup_.parameters), sub_step_s_),
      rotating_(rotatingBody(setup_.parameters), sub_step_s_),
      motion_(setup_.parameters) {}

Result<void> SimDevice::open() {
  if (setup_.file.valid()) {
    auto track = setup_.file.read(given_up_);
    if (!track) return track.error();
    keepResident((*track)->rows().data(), (*track)->bytes());
    held_bytes_ = (*track)->bytes();
    play(std::move(*track));
  }
  const PoseOnTrack start = motion_.at(0);
  point_.place(start.p, start.v);
  rotating_.place(start.q, start.w);
  gripper_.place(Vec3(start.gripper_rad * setup_.parameters.gripper_lever, 0, 0), Vec3::Zero());
  started_ = false;
  period_ = 0;
  reported_ = -1;
  skipped_ = 0;
  acting_ = {};
  acting_status_ = kDeviceOk;
  pending_.fill({});
  safe_.store(false, std::memory_order_relaxed);
  measure();
  keepResident(this, sizeof *this);
  return {};
}

void SimDevice::play(std::shared_ptr<const PoseTrack> track) {
  MotionParameters motion = setup_.parameters;
  motion.track = std::move(track);
  motion_ = IntendedMotion(motion);
}

void SimDevice::close() noexcept {
  safe();
  if (setup_.file.valid()) play(nullptr);
  held_bytes_ = 0;
}

void SimDevice::safe() noexcept { safe_.store(true, std::memory_order_release); }  // Pairs with advanceTo.

void SimDevice::advanceTo(std::int64_t now_ns) HD_RT {
  if (safe_.load(std::memory_order_acquire)) {  // Pairs with safe().
    safe_.store(false, std::memory_order_relaxed);
    pending_.fill({});
    acting_ = {};
  }
  const std::int64_t target = now_ns / period_ns_;
  if (!started_) {
    started_ = true;
    offset_ = target;
    measured_[0].t_ns = target * period_ns_;
  }
  std::int64_t due = target - offset_ - period_;
  const auto most = static_cast<std::int64_t>(kMaxCatchUp_s * setup_.parameters.rate);
  if (due > most) {
    skipped_ += static_cast<std::uint64_t>(due - most);
    offset_ += due - most;
    due = most;
  }
  for (; due > 0; --due) runPeriod();
}

void SimDevice::runPeriod() HD_RT {
  const Pending& pending = pending_[static_cast<std::size_t>(period_) % pending_.size()];
  if (pending.period == period_) {
    acting_ = pending.command;
    acting_status_ = pending.status;
  }
  const bool rotates = setup_.info.sensed_rotation;
  const double lever = setup_.parameters.gripper_lever;
  const double start_s = static_cast<double>(period_) * static_cast<double>(period_ns_) * 1e-9;
  for (int i = 0; i < sub_steps_; ++i) {
    const PoseOnTrack goal = motion_.at(start_s + (i + 0.5) * sub_step_s_);
    point_.step(acting_.force, goal.p, goal.v);
    if (rotates) rotating_.step(acting_.torque, goal.q, goal.w);
    if (setup_.parameters.gripper) {
      gripper_.step(Vec3(acting_.gripper_force, 0, 0), Vec3(goal.gripper_rad * lever, 0, 0), Vec3::Zero());
    }
  }
  ++period_;
  measure();
}

void SimDevice::measure() HD_RT {
  const SimParameters& p = setup_.parameters;
  DeviceSample& sample = measured_[static_cast<std::size_t>(period_) % measured_.size()];
  sample = {};
  sample.t_ns = (period_ + offset_) * period_ns_;
  sample.p = toStep(point_.position(), p.resolution);
  if (setup_.info.sensed_rotation) {
    sample.q = p.rotation_resolution > 0
                   ? fromRotationVector(toStep(rotationVector(rotating_.orientation()), p.rotation_resolution))
                   : rotating_.orientation();
  }
  if (p.gripper) sample.gripper_rad = toStep(gripper_.position().x() / p.gripper_lever, p.gripper_resolution);
  if (p.buttons > 0) {
    const double t_s = static_cast<double>(period_) * static_cast<double>(period_ns_) * 1e-9;
    const auto mask = static_cast<std::uint32_t>((std::uint64_t{1} << p.buttons) - 1);
    sample.buttons = motion_.at(t_s).buttons & mask;
  }
}

void SimDevice::read(std::int64_t now_ns, DeviceSample& sample) HD_RT {
  advanceTo(now_ns);
  const auto delay = static_cast<std::int64_t>(setup_.parameters.position_delay);
  const std::int64_t seen = std::max<std::int64_t>(0, period_ - delay);
  if (seen == reported_) {
    sample.fresh = false;
  } else {
    sample = measured_[static_cast<std::size_t>(seen) % measured_.size()];
    sample.fresh = true;
    sample.status = acting_status_;
    reported_ = seen;
  }
}

SimDevice::Pending SimDevice::limited(const DeviceCommand& command) const HD_RT {
  const SimParameters& p = setup_.parameters;
  Pending out;
  out.period = period_ + static_cast<std::int64_t>(p.delay);
  if (!command.enabled) return out;
  if (!command.force.allFinite() || !command.torque.allFinite() || !std::isfinite(command.gripper_force)) {
    out.status = kDeviceError;
    return out;
  }
  out.command.enabled = true;
  bool cut = false;
  out.command.force = producible(command.force, p.force_resolution, p.max_force, cut);
  if (setup_.info.actuated_rotation) {
    out.command.torque = producible(command.torque, p.torque_resolution, p.max_torque, cut);
  }
  if (p.gripper) {
    out.command.gripper_force = std::clamp(command.gripper_force, -p.max_gripper_force, p.max_gripper_force);
    cut = cut || std::abs(command.gripper_force) > p.max_gripper_force;
  }
  if (cut) out.status = kDeviceSaturated;
  return out;
}

void SimDevice::write(std::int64_t now_ns, const DeviceCommand& command) HD_RT {
  advanceTo(now_ns);
  const Pending next = limited(command);
  pending_[static_cast<std::size_t>(next.period) % pending_.size()] = next;
}

}  // namespace hapticd
