#include "rt/guard/guard.h"

#include <algorithm>
#include <cmath>

#include "rt/guard/damping_left.h"

namespace hapticd {
namespace {

/** No device makes a kilonewton; what asks for more is brought to this, direction kept, so that no sum overflows. */
constexpr double kLargest = 1024;  // [N], [N m], [W]
/** Forces are whole multiples of 2^-40 N: sums and differences below 2^13 N are exact, denormals cannot occur. */
constexpr double kGrid = 0x1p-40;
constexpr double kPerGrid = 0x1p40;
/** Faster than this is a broken sensor whatever the limit says. */
constexpr double kFastest = 100;       // [m/s]
constexpr double kFastestTurn = 1000;  // [rad/s]
/** Below this no power is counted; the division by v^2 stays finite. */
constexpr double kSlowest = 1e-6;     // [m/s], [rad/s]
constexpr double kLongestTick = 0.1;  // [s]
static_assert(kLongestTick <= Guard::kFall_s, "in a tick nothing falls beyond zero");

double toGrid(double x) HD_RT {
  const double steps = x * kPerGrid;
  // As std::trunc, which is a function call without SSE 4.1. From 2^53 steps on every double lies on the grid.
  return std::abs(steps) < 0x1p53 ? static_cast<double>(static_cast<std::int64_t>(steps)) * kGrid : x;
}
/** Toward zero: never longer than x. */
Vec3 toGrid(const Vec3& x) HD_RT { return {toGrid(x.x()), toGrid(x.y()), toGrid(x.z())}; }

/** Finite x within kLargest by component, on the grid. */
Vec3 bounded(const Vec3& x) HD_RT {
  const double most = x.cwiseAbs().maxCoeff();
  return toGrid(most > kLargest ? Vec3(x * (kLargest / most)) : x);
}

/** As bounded(), but with the sum of what is larger, if that is not: a press takes along one axis what it gives. */
Vec3 boundedWithSum(const Vec3& x) HD_RT {
  const Vec3 mean = Vec3::Constant(std::clamp(x.sum() / 3, -kLargest, kLargest));
  const Vec3 rest = x - mean;
  const double most = rest.cwiseAbs().maxCoeff(), room = kLargest - std::abs(mean.x());
  return x.cwiseAbs().maxCoeff() > kLargest ? toGrid(Vec3(mean + rest * std::min(1.0, room / most))) : bounded(x);
}

/** clampNorm with the rounding on the safe side. */
Vec3 clampStrictly(const Vec3& x, double limit) HD_RT {
  const double n = x.norm();
  return n > limit ? Vec3(x * (limit * (1 - 1e-14) / n)) : x;
}

/** Radius of the ball that forces are kept in: a few grid steps inside the limit, so that rounding never leaves it. */
double radiusOf(double limit) HD_RT { return std::max(0.0, std::min(limit, kLargest) - 4 * kGrid); }

/**
 * How far what is sent may go on the way to what shall be sent though the slew limit is slower: by as much of itself in
 * each tick as goes in Guard::kFall_s, and as long as it only becomes smaller, which it does up to the point of the way
 * that is nearest to zero.
 */
double falls(const Vec3& from, const Vec3& way, double dt) HD_RT {
  const double toward = -from.dot(way);
  return toward > 0 ? std::min(toward / way.norm(), from.norm() * (dt / Guard::kFall_s)) : 0.0;
}

/** Since the last tick. */
double passed_ns(const GuardInput& input) HD_RT { return 1e9 * (1.0 + input.missed) * input.dt; }

bool finite(const Twist& x) HD_RT { return isFinite(x.v) && isFinite(x.w); }

/** Causes that latch even while disarmed: they say that something is broken. The others are daily life there. */
bool latchesWhileDisarmed(std::uint32_t cause) HD_RT {
  return cause == HD_FAULT_STOP_LINE || cause == HD_FAULT_NOT_FINITE || cause == HD_FAULT_DEVICE_LOST ||
         cause == HD_FAULT_DEVICE_ERROR;
}

}  // namespace

Guard::Guard(const GuardConfig& config) noexcept
    : config_(config),
      passivity_(config.max_damping),
      heating_(config.continuous_force, config.peak_force, config.heating_s, config.heat) {
  if (!valid(config_.limits)) config_.limits = GuardLimits{};
  config_.delay = config_.delay > 0 ? std::min(config_.delay, PastForces::kMaxDelay) : 0.0;  // NaN: 0.
}

ErrorCode Guard::arm() HD_RT {
  if (present_cause_ != HD_FAULT_NONE) {
    fault_ = HD_FAULT_NONE;
    latch(present_cause_);
    return ErrorCode::kFaultLatched;
  }
  fault_ = HD_FAULT_NONE;
  if (state_ == State::kWaiting || state_ == State::kArmed) return ErrorCode::kOk;
  if (state_ == State::kDisarmed) forgetEnergy();
  state_ = State::kWaiting;
  small_ticks_ = 0;
  ramped_ns_ = 0;
  ramp_ = 0;
  return ErrorCode::kOk;
}

void Guard::disarm() HD_RT {
  if (state_ == State::kDisarmed) return;
  if (state_ == State::kArmed) lowered_s_ = 0;
  state_ = State::kLowering;
}

void Guard::latch(std::uint32_t cause) HD_RT {
  if (cause == HD_FAULT_NONE || cause >= HD_FAULT_COUNT) return;
  if (fault_ == HD_FAULT_NONE) fault_ = cause;
  state_ = State::kDisarmed;
  last_ = Sent{};
  forgetEnergy();
}

void Guard::forgetEnergy() HD_RT {
  last_passive_.setZero();
  last_carried_.setZero();
  last_ramped_.setZero();
  past_passive_.reset();
  last_stored_ = -1;
  v_buzz_.reset();
  carried_power_ = 0;
  passivity_.reset();
}

ErrorCode Guard::setLimits(const GuardLimits& limits) HD_RT {
  if (!valid(limits)) return ErrorCode::kInvalidArgument;
  config_.limits = limits;
  return ErrorCode::kOk;
}

bool Guard::gather(const GuardInput& input, Wanted& wanted) HD_RT {
  bool all_finite = true;
  Vec3 torque = Vec3::Zero();
  for (std::size_t i = 0; i < HD_SOURCE_GUARD; ++i) {
    const Wrench& source = input.source[i];
    const bool good = isFinite(source.force) && isFinite(source.torque);
    all_finite = all_finite && good;
    wanted.by_source[i] = good ? bounded(source.force) : Vec3(Vec3::Zero());
    if (good) torque += bounded(source.torque);
  }
  all_finite = all_finite && std::isfinite(input.gripper_force) && isFinite(input.local_active) &&
               isFinite(input.relief) && isFinite(input.carried);
  if (!all_finite) return false;
  const Vec3 springs = bounded(input.local_active), relief = bounded(input.relief);
  wanted.passive = wanted.by_source[HD_SOURCE_SURFACE] + relief + (wanted.by_source[HD_SOURCE_LOCAL_MODEL] - springs);
  wanted.active = wanted.by_source[HD_SOURCE_EFFECT] + springs + wanted.by_source[HD_SOURCE_CLIENT] +
                  (wanted.by_source[HD_SOURCE_TEXTURE] - relief) + wanted.by_source[HD_SOURCE_TRANSIENT];
  wanted.gravity = wanted.by_source[HD_SOURCE_GRAVITY];
  wanted.torque = torque;
  wanted.gripper = input.gripper_force;  // limit() bounds it; no sum has it.
  wanted.carried = boundedWithSum(input.carried);
  return true;
}

std::uint32_t Guard::causeOf(const GuardInput& input, bool sources_finite) const HD_RT {
  if (input.stop_line) return HD_FAULT_STOP_LINE;
  const std::uint32_t status = input.sample->status;
  const bool let_go = input.deadman_open || (status & kDeviceDeadmanOpen) != 0;
  // Only the first cause is told: what is daily life while disarmed must not hide what latches even there.
  if (let_go && armed()) return HD_FAULT_DEADMAN;
  if ((status & (kDeviceError | kDeviceGone)) != 0) return HD_FAULT_DEVICE_ERROR;
  const bool tick_usable = input.dt > 0 && input.dt <= kLongestTick;  // False for NaN.
  if (!sources_finite || !tick_usable || !finite(input.velocity)) return HD_FAULT_NOT_FINITE;
  if (!usable(*input.sample)) return HD_FAULT_NOT_FINITE;
  // Unsigned: a clock that ran backwards is as bad as a silent device. Before the velocity, which is then a former one.
  const auto silent = static_cast<std::uint64_t>(input.now_ns) - static_cast<std::uint64_t>(last_fresh_ns_);
  if (silent > static_cast<std::uint64_t>(config_.stale_ns)) return HD_FAULT_DEVICE_LOST;
  if (let_go) return HD_FAULT_DEADMAN;
  if (!(input.velocity.v.norm() <= std::min(config_.limits.velocity, kFastest))) return HD_FAULT_VELOCITY;
  if (!(input.velocity.w.norm() <= kFastestTurn)) return HD_FAULT_VELOCITY;
  if (input.missed != 0 && input.missed >= config_.missed_limit) return HD_FAULT_OVERRUN;
  return HD_FAULT_NONE;
}

double Guard::storedIn(const GuardInput& input, const Wanted& wanted) HD_RT {
  // A stated energy is used even while damping cancels the whole force, which is then zero only up to rounding.
  if (input.stored >= 0 && input.stored <= kLargest) return input.stored;
  return wanted.passive.isZero(0) ? 0 : -1;
}

bool Guard::takenBack(const GuardInput& input) const HD_RT {
  constexpr double kRounding_ns = 0.5;
  return config_.life_ns > 0 && static_cast<double>(config_.life_ns) <= passed_ns(input) + kRounding_ns;
}

double Guard::stoodFor(const GuardInput& input) const HD_RT {
  return takenBack(input) ? std::min(1.0, static_cast<double>(config_.life_ns) / passed_ns(input)) : 1.0;
}

void Guard::bookEnergy(const GuardInput& input, const Wanted& wanted) HD_RT {
  Vec3 moved = input.sample->p - last_p_;
  // A metre within a tick is no motion of a hand; the velocity limit deals with it.
  if (!(moved.cwiseAbs().maxCoeff() <= 1)) moved.setZero();
  const double stood = stoodFor(input);
  past_passive_.push(stood * last_passive_);
  const Vec3 acted = past_passive_.acted(config_.delay);
  if (takenBack(input)) past_passive_.reset();  // What was on its way has come and gone.
  const double stored = storedIn(input, wanted);
  // Bodies kept moving in missed periods: what they bring in one tick counts for each; limitStore() caps the sum.
  const Vec3 carried = stood * (1.0 + input.missed) * last_carried_;
  passivity_.observe(acted, moved, carried + last_ramped_);
  passivity_.limitStore(stored);
  if (stored >= 0 && last_stored_ >= 0) {
    const double leaked = last_share_ * (stored - last_stored_) + acted.dot(moved) - carried.sum();
    // A wall can leak at most the way times the change of its force, from what acted to what it is now. Anything
    // beyond that comes from somebody who moved or changed the wall without saying so.
    passivity_.follow(std::min(leaked, (last_share_ * wanted.passive - acted).norm() * moved.norm()));
  }
  last_stored_ = stored;
  v_buzz_.update(moved / (1.0 + input.missed), input.dt, config_.delay);
}

void Guard::advanceState(const Wanted& wanted, const GuardInput& input) HD_RT {
  const double dt = input.dt;
  // Missed periods count toward deadlines; the ramp rises only by ticks that ran.
  const double passed = dt * (1.0 + input.missed);
  ramp_rose_ = 0;
  switch (state_) {
    case State::kDisarmed:
      return;
    case State::kWaiting: {
      lowered_s_ += passed;
      const bool small = (wanted.passive + wanted.active).norm() < config_.small_force &&
                         wanted.torque.norm() < config_.small_torque &&
                         std::abs(wanted.gripper) < config_.small_force && last_.isNothing();
      small_ticks_ = small ? small_ticks_ + 1 : 0;
      if (small_ticks_ >= config_.small_force_ticks) state_ = State::kArmed;
      return;
    }
    case State::kArmed: {
      const double former = ramp_;
      ramped_ns_ += static_cast<std::int64_t>(dt * 1e9 + 0.5);
      ramp_ =
          ramped_ns_ < config_.ramp_ns ? static_cast<double>(ramped_ns_) / static_cast<double>(config_.ramp_ns) : 1.0;
      ramp_rose_ = ramp_ > 0 ? 1 - former / ramp_ : 0.0;
      return;
    }
    case State::kLowering:
      lowered_s_ += passed;
      return;
  }
}

Guard::Sent Guard::limit(const GuardInput& input, const Wanted& wanted, const Sent& target,
                         std::uint32_t& flags) const HD_RT {
  const GuardLimits& limits = config_.limits;
  Sent out;
  // The ramp scales the limits too: however much is asked for, a hundredth of the ramp lets a hundredth through.
  out.force = clampStrictly(target.force, radiusOf(std::min(ramp_ * limits.force, heating_.allowed())));
  out.torque = clampStrictly(target.torque, radiusOf(ramp_ * limits.torque));
  const double grip = radiusOf(ramp_ * limits.gripper_force);
  out.gripper = std::clamp(target.gripper, -grip, grip);
  bool limited = out.force != target.force || out.torque != target.torque || out.gripper != target.gripper;

  const Vec3& v = input.velocity.v;
  const Vec3& w = input.velocity.w;
  const double vv = v.squaredNorm();
  const double ww = w.squaredNorm();
  const double linear = vv > kSlowest * kSlowest ? out.force.dot(v) : 0.0;
  const double angular = ww > kSlowest * kSlowest ? std::max(0.0, out.torque.dot(w)) : 0.0;
  // Power of the active sources after the limits above. All torque counts as active: no passive source makes any.
  const double wanted_norm = (wanted.passive + wanted.active + wanted.gravity).norm();
  const double share = wanted_norm > 0 ? std::min(1.0, out.force.norm() / wanted_norm) : 0.0;
  const double active = std::max(0.0, share * (wanted.active.dot(v) + carried_power_));
  const double in_budget = active + angular > limits.active_power ? limits.active_power / (active + angular) : 1.0;
  double linear_allowed = std::max(0.0, linear - (1 - in_budget) * active);
  double angular_allowed = in_budget * angular;
  const double delivered = linear_allowed + angular_allowed;
  const double in_power = delivered > limits.power ? limits.power / delivered : 1.0;
  linear_allowed *= in_power;
  angular_allowed *= in_power;
  if (linear > linear_allowed || angular > angular_allowed) {
    if (linear > 0) out.force -= ((linear - linear_allowed) / vv) * v;
    if (angular > 0) out.torque -= ((angular - angular_allowed) / ww) * w;
    limited = true;
  }
  if (limited) flags |= HD_SAMPLE_LIMITED;
  out.force = toGrid(out.force);
  out.torque = toGrid(out.torque);
  return out;
}

Guard::Sent Guard::slew(const Sent& target, double dt) const HD_RT {
  const GuardLimits& limits = config_.limits;
  const auto step = [dt](const Vec3& from, const Vec3& to, double rate) {
    const Vec3 way = to - from;
    return Vec3(from + toGrid(clampStrictly(way, std::max(rate * dt, falls(from, way, dt)))));
  };
  Sent out;
  // A lowered limit, that of warm motors too, clamps the present force at once; the slew limit applies from there.
  const double most = radiusOf(std::min(limits.force, heating_.allowed()));
  out.force = step(toGrid(clampStrictly(last_.force, most)), target.force, limits.force_slew);
  out.torque = step(toGrid(clampStrictly(last_.torque, radiusOf(limits.torque))), target.torque, limits.torque_slew);
  const double grip = radiusOf(limits.gripper_force);
  const double from = std::clamp(last_.gripper, -grip, grip);
  const double way = target.gripper - from;
  const double by = std::max(limits.force_slew * dt, falls(Vec3(from, 0, 0), Vec3(way, 0, 0), dt));
  out.gripper = from + std::clamp(way, -by, by);
  return out;
}

Guard::Sent Guard::pass(const GuardInput& input, const Wanted& wanted, std::uint32_t& flags) HD_RT {
  passivity_.setMaxDamping(dampingLeft(config_.max_damping, input.damping));
  const Vec3 passive = config_.passivity ? passivity_.control(wanted.passive, input.velocity.v, v_buzz_.velocity(),
                                                              wanted.carried, input.dt)
                                         : wanted.passive;
  if (config_.passivity && passivity_.acting()) flags |= HD_SAMPLE_PASSIVITY;
  const Vec3 total = passive + wanted.active + wanted.gravity;
  carried_power_ += (wanted.carried.sum() - carried_power_) * std::min(1.0, input.dt / kCarried_s);

  Sent target;
  const double target_share = state_ == State::kArmed ? ramp_ : 0.0;
  if (state_ == State::kArmed) target = {ramp_ * total, ramp_ * wanted.torque, ramp_ * wanted.gripper};
  Sent out = slew(limit(input, wanted, target, flags), input.dt);
  if (state_ != State::kArmed && lowered_s_ >= kLower_s) out = Sent{};

  // Split what is sent by source: ramp and limits scale all alike; what the slew still holds counts as passive.
  const double tt = total.squaredNorm();
  // Sources that cancel each other count as sent in full, though nothing is left of their sum.
  const double share = tt > 0 ? std::clamp(out.force.dot(total) / tt, 0.0, 1.0) : target_share;
  last_passive_ = out.force - share * (wanted.active + wanted.gravity);
  last_share_ = share;
  last_carried_ = share * input.dt * wanted.carried;
  last_ramped_.setZero();
  if (ramp_rose_ > 0) {
    // A spring capped at the share b of its force gives back b (2 - b) of its energy: the cap, then what is below it.
    const double bound = std::min(1.0, share / ramp_);
    last_ramped_ = byAxis(ramp_rose_ * ramp_ * bound * (2 - bound) * std::max(0.0, last_stored_), wanted.passive);
  }
  return out;
}

void Guard::step(const GuardInput& input, GuardOutput& output) HD_RT {
  Wanted wanted;
  const bool sources_finite = gather(input, wanted);
  const double held = last_.force.norm();
  if (!started_ || input.sample->fresh) last_fresh_ns_ = input.now_ns;
  started_ = true;

  present_cause_ = causeOf(input, sources_finite);
  if (present_cause_ == HD_FAULT_NONE && armed()) {
    bookEnergy(input, wanted);
    if (config_.passivity && passivity_.energy() < -config_.energy_limit) latch(HD_FAULT_ENERGY);
  }
  if (present_cause_ != HD_FAULT_NONE && (armed() || latchesWhileDisarmed(present_cause_))) latch(present_cause_);
  if (isFinite(input.sample->p)) last_p_ = input.sample->p;
  // The former force stood through the missed periods, even if this tick is a fault; then the driver took it back, and
  // the slew starts from what the hand feels.
  heating_.book(held, std::max(0.0, stoodFor(input) * (1.0 + input.missed) - 1) * input.dt);
  if (takenBack(input)) last_ = Sent{};

  output.flags = 0;
  Sent sent;
  if (armed()) {
    advanceState(wanted, input);
    sent = pass(input, wanted, output.flags);
    if (!isFinite(sent.force) || !isFinite(sent.torque) || !std::isfinite(sent.gripper)) {
      latch(HD_FAULT_NOT_FINITE);
      sent = Sent{};
    }
    if (state_ == State::kLowering && sent.isNothing()) state_ = State::kDisarmed;
  }
  last_ = sent;
  heating_.book(sent.force.norm(), input.dt);
  output.heat = heating_.heat();
  output.warm = heating_.warm();

  output.command.force = sent.force;
  output.command.torque = sent.torque;
  output.command.gripper_force = sent.gripper;
  output.command.enabled = armed();
  if (armed()) output.flags |= HD_SAMPLE_ARMED;
  if (armed() && state_ != State::kLowering && ramp_ < 1) output.flags |= HD_SAMPLE_RAMPING;
  if (armed() && state_ == State::kWaiting) output.flags |= HD_SAMPLE_WAITING;
  if (fault_ != HD_FAULT_NONE) output.flags = (output.flags & ~std::uint32_t{HD_SAMPLE_PASSIVITY}) | HD_SAMPLE_FAULT;
  output.fault = fault_;
  output.energy = passivity_.energy();

  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < HD_SOURCE_GUARD; ++i) {
    output.by_source[i] = wanted.by_source[i];
    sum += wanted.by_source[i];
  }
  output.by_source[HD_SOURCE_GUARD] = sent.force - sum;
}

}  // namespace hapticd
