// What the guard promises for any input whatever: docs/safety.md names these
// tests.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rt/guard/guard.h"
#include "tests/property/guard_adversary.h"
#include "tests/support/for_seeds.h"

namespace hapticd {
namespace {

constexpr double kDt = 1e-3;

using test::Adversary;
using test::randomLimits;

Vec3 inside(const Vec3& x, double limit) { return x.norm() > limit ? Vec3(x * (limit / x.norm())) : x; }

/** By the slew; by more only what becomes smaller, by as much of itself as goes in kFall_s. */
void expectChange(const Vec3& from, const Vec3& to, double slew) {
  const double change = (to - from).norm();
  if (change <= slew) return;
  ASSERT_LT(to.norm(), from.norm()) << "more than the slew, and not smaller";
  ASSERT_LE(change, from.norm() * kDt / Guard::kFall_s * (1 + 1e-9) + 1e-11);
}

/** A guard in an adversary's hands, with what it must keep from one tick to the next. */
class Duel {
 public:
  Duel(unsigned seed, bool calm) : a_(seed, calm), calm_(calm) {}

  void tick(int number) {
    order();
    const GuardLimits before = a_.guard.limits();
    changeLimits();
    a_.draw();
    a_.step(1'000'000'000 + number * std::int64_t{1'000'000});
    cause_ = a_.cause();
    expectBounds();
    expectFaults();
    expectSlew(before);
    expectOwners();
    last_ = a_.out.command;
  }
  int armed_ticks = 0, faults = 0;

 private:
  void order() {
    if (rest_-- <= 0 && a_.random.once(10)) {
      const ErrorCode code = a_.guard.arm();
      ASSERT_EQ(code, cause_ ? ErrorCode::kFaultLatched : ErrorCode::kOk) << "armed while the cause persists, or not";
      fault_ = a_.guard.fault();
      ASSERT_EQ(fault_ == HD_FAULT_NONE, code == ErrorCode::kOk);
      if (code == ErrorCode::kOk) lowering_ = false;
    }
    if (a_.random.once(200)) {
      a_.guard.disarm();
      lowering_ = true;
      if (!calm_ && a_.random.once(2)) rest_ = a_.random.below(400);
    }
    if (!calm_ && a_.random.once(300)) a_.guard.latch(static_cast<std::uint32_t>(a_.random.below(12)));
    if (fault_ == HD_FAULT_NONE) fault_ = a_.guard.fault();
  }
  void changeLimits() {
    if (!a_.random.once(100)) return;
    GuardLimits limits = randomLimits(a_.random);
    if (a_.random.once(5)) limits.power = a_.random.broken();
    const bool good = std::isfinite(limits.power);
    ASSERT_EQ(a_.guard.setLimits(limits), good ? ErrorCode::kOk : ErrorCode::kInvalidArgument);
  }
  /** Always. */
  void expectBounds() {
    const DeviceCommand& now = a_.out.command;
    ASSERT_TRUE(isFinite(now.force) && isFinite(now.torque) && std::isfinite(now.gripper_force));
    ASSERT_LE(now.force.norm(), a_.guard.limits().force);
    ASSERT_LE(now.torque.norm(), a_.guard.limits().torque);
    ASSERT_LE(std::abs(now.gripper_force), a_.guard.limits().gripper_force);
  }
  /** Causes latch, first cause first, and stay. */
  void expectFaults() {
    const bool latched = a_.out.fault != HD_FAULT_NONE;
    ASSERT_TRUE(latched || !cause_ || !last_.enabled);
    ASSERT_TRUE(latched || !a_.broken()) << "what is broken latches, armed or not";
    if (fault_ != HD_FAULT_NONE) {
      ASSERT_EQ(a_.out.fault, fault_) << "a latched fault changed";
    } else if (latched) {
      fault_ = a_.out.fault;
      ++faults;
      ASSERT_TRUE(cause_ || fault_ == HD_FAULT_ENERGY) << "a fault without a cause: " << fault_;
    }
    ASSERT_FALSE(latched && a_.out.command.enabled);
    ASSERT_EQ((a_.out.flags & HD_SAMPLE_FAULT) != 0, fault_ != HD_FAULT_NONE);
    ASSERT_EQ((a_.out.flags & HD_SAMPLE_ARMED) != 0, a_.out.command.enabled);
  }
  /** Not enabled: exactly nothing. */
  void expectSlew(const GuardLimits& before) {
    const DeviceCommand& now = a_.out.command;
    if (!now.enabled) {
      ASSERT_TRUE(now.force.isZero(0) && now.torque.isZero(0) && now.gripper_force == 0);
      ASSERT_TRUE(fault_ != HD_FAULT_NONE || lowering_ || !last_.enabled) << "switched off for no reason";
      return;
    }
    ++armed_ticks;
    if (now.force.isZero(0) && now.torque.isZero(0)) return;  // Re-armed in mid-lowering, second over.
    const GuardLimits& limits = a_.guard.limits();
    const bool lowered =
        limits.force < before.force || limits.torque < before.torque || limits.gripper_force < before.gripper_force;
    const double share = lowered ? 1 + 1e-9 : 1, rounding = lowered ? 1e-11 : 0;
    if (a_.takenBack()) last_ = {};  // What the hand feels until now.
    const Vec3 from_f = lowered ? inside(last_.force, limits.force) : last_.force;
    const Vec3 from_t = lowered ? inside(last_.torque, limits.torque) : last_.torque;
    expectChange(from_f, now.force, limits.force_slew * kDt * share + rounding);
    expectChange(from_t, now.torque, limits.torque_slew * kDt * share + rounding);
    const Vec3 grip = inside(Vec3(last_.gripper_force, 0, 0), limits.gripper_force);
    expectChange(grip, Vec3(now.gripper_force, 0, 0), limits.force_slew * kDt + 1e-11);
  }
  void expectOwners() {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& part : a_.out.by_source) {
      ASSERT_TRUE(isFinite(part));
      sum += part;
    }
    ASSERT_EQ(sum, a_.out.command.force) << "by_source does not sum exactly";
  }

  Adversary a_;
  const bool calm_;
  DeviceCommand last_;
  bool lowering_ = false, cause_ = false;
  int rest_ = 0;  ///< Ticks in which nobody arms it.
  std::uint32_t fault_ = HD_FAULT_NONE;
};

void runAdversary(unsigned seed, bool calm, int ticks, int& armed_ticks, int& faults) {
  SCOPED_TRACE(testing::Message() << "HAPTICD_SEED=" << seed << (calm ? " calm" : " hostile"));
  Duel duel(seed, calm);
  for (int tick = 1; tick <= ticks && !testing::Test::HasFatalFailure(); ++tick) {
    SCOPED_TRACE(tick);
    duel.tick(tick);
  }
  armed_ticks += duel.armed_ticks;
  faults += duel.faults;
}

TEST(GuardProperty, AnyInputWhatever) {
  int armed = 0, faults = 0;
  for (const unsigned seed : seeds(60)) {
    runAdversary(seed, false, 3000, armed, faults);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(armed, drawn(30'000)) << "too little of the run was armed to mean anything";
  EXPECT_GT(faults, drawn(500));
}

TEST(GuardProperty, CalmButWildSources) {
  int armed = 0, faults = 0;
  for (const unsigned seed : seeds(30)) {
    runAdversary(seed, true, 4000, armed, faults);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(armed, drawn(50'000));
}

GuardConfig wideOpen() {
  GuardConfig config;
  config.limits = {8, 0.5, 1e9, 1e9, 5, 50, 2, 0.7};
  config.ramp_ns = 0;
  config.passivity = false;
  return config;
}

/** Armed, past the ramp, with slew out of the way: each tick shows the limits
 * alone. */
struct Armed {
  Guard guard;
  DeviceSample sample;
  GuardInput in;
  GuardOutput out;
  explicit Armed(const GuardConfig& config) : guard(config) {
    in.dt = kDt;
    sample.fresh = true;
    step();
    (void)guard.arm();
    for (int i = 0; i < 10; ++i) step();
  }
  const GuardOutput& step() {
    in.now_ns += 1'000'000;
    in.sample = &sample;
    guard.step(in, out);
    return out;
  }
};

TEST(GuardProperty, PowerIsBoundAndOnlyItsPartOfTheForceTaken) {
  forSeeds(20, [&](unsigned seed) {
    Random random(seed);
    Armed a(wideOpen());
    int bound = 0;
    for (int i = 0; i < 2000; ++i) {
      a.in.source = {};
      a.in.source[HD_SOURCE_GRAVITY].force = random.vector(8);
      a.in.source[HD_SOURCE_CLIENT].torque = random.vector(0.5);
      a.in.velocity.v = random.vector(1);
      a.in.velocity.w = random.vector(10);
      const GuardOutput& out = a.step();
      const Vec3& f = out.command.force;
      const Vec3& v = a.in.velocity.v;
      const Vec3 asked = inside(a.in.source[HD_SOURCE_GRAVITY].force, 8);
      ASSERT_LE(std::max(0.0, f.dot(v)) + std::max(0.0, out.command.torque.dot(a.in.velocity.w)), 2 + 1e-9);
      ASSERT_LE(std::max(0.0, out.command.torque.dot(a.in.velocity.w)), 0.7 + 1e-9);
      // What was taken lies along v and never turns a push into a pull.
      const Vec3 taken = asked - f;
      ASSERT_LT((taken - taken.dot(v) / v.squaredNorm() * v).norm(), 1e-9);
      if (asked.dot(v) > 0) {
        ASSERT_GE(f.dot(v), -1e-9);
      } else {
        ASSERT_LT(taken.norm(), 1e-9) << "braking power was limited";
      }
      bound += taken.norm() > 1e-9;
    }
    EXPECT_GT(bound, 300);
  });
}

TEST(GuardProperty, ClampingKeepsTheDirection) {
  forSeeds(20, [&](unsigned seed) {
    Random random(seed);
    Armed a(wideOpen());
    for (int i = 0; i < 1000; ++i) {
      a.in.source = {};
      const Vec3 direction = random.vector(1).normalized();
      const double size = std::pow(10, random.in(-3, 300));
      a.in.source[HD_SOURCE_SURFACE].force = size * direction;
      const Vec3 f = a.step().command.force;
      ASSERT_NEAR(f.norm(), std::min(size, 8.0), 1e-9);
      ASSERT_LT((f.normalized() - direction).norm(), 1e-8);
    }
  });
}

/** Else what a wall takes while a client cancels it were forgotten, and a debt when it is given back. */
TEST(GuardProperty, AForceThatCancelsAWallIsBookedAsOneThatNearlyDoes) {
  for (const unsigned seed : seeds(20)) {
    SCOPED_TRACE(testing::Message() << "HAPTICD_SEED=" << seed);
    Random random(seed);
    GuardConfig config = wideOpen();
    config.limits.force = 200;
    config.limits.active_power = config.limits.power = 1e4;
    config.passivity = true;
    config.ramp_ns = random.once(2) ? 0 : 300'000'000;
    Armed exact(config), nearly(config);
    const double stiffness = random.in(500, 5000), deepest = random.in(0.005, 0.02), speed = random.in(1, 4);
    const bool by_gravity = random.once(3);
    double before = 0;
    for (int i = 0; i < 1000; ++i) {
      const double depth = deepest * 0.5 * (1 - std::cos(speed * 2 * M_PI * i * kDt));
      const Vec3 wall(stiffness * depth, 0, 0);
      const bool cancels = i < 400;
      for (Armed* a : {&exact, &nearly}) {
        a->sample.p = {-depth, 0, 0};
        a->in.velocity.v = {(before - depth) / kDt, 0, 0};
        a->in.source[HD_SOURCE_SURFACE].force = wall;
        a->in.stored = 0.5 * stiffness * depth * depth;
        a->in.source[by_gravity ? HD_SOURCE_GRAVITY : HD_SOURCE_CLIENT].force = cancels ? Vec3(-wall) : Vec3::Zero();
        if (a == &nearly) a->in.source[HD_SOURCE_TRANSIENT].force = {0, 0, 1e-6};
        a->step();
      }
      before = depth;
      ASSERT_EQ(exact.out.fault, nearly.out.fault) << i;
      ASSERT_NEAR(exact.out.energy, nearly.out.energy, 1e-5) << i;
      ASSERT_LT((exact.out.command.force - nearly.out.command.force).norm(), 1e-3) << i;
    }
  }
}

TEST(GuardProperty, RampBoundsEvenHugeForces) {
  forSeeds(10, [&](unsigned seed) {
    Random random(seed);
    GuardConfig config = wideOpen();
    config.ramp_ns = 2'000'000'000;
    Armed a(config);  // Ten ticks: six of them into the ramp at most.
    for (int i = 10; i <= 2000; ++i) {
      a.in.source[HD_SOURCE_SURFACE].force = random.wildVector();
      a.step();
      ASSERT_LE(a.out.command.force.norm(), 8.0 * i / 2000);
    }
  });
}

TEST(GuardProperty, SameInputsSameBits) {
  for (const unsigned seed : seeds(10)) {
    Adversary a(seed, false), b(seed, false);
    for (int tick = 1; tick <= 1000; ++tick) {
      for (Adversary* x : {&a, &b}) {
        if (tick % 50 == 1) (void)x->guard.arm();
        x->draw();
        x->step(tick * std::int64_t{1'000'000});
      }
      ASSERT_EQ(a.out.command.force, b.out.command.force);
      ASSERT_EQ(a.out.command.torque, b.out.command.torque);
      ASSERT_EQ(a.out.fault, b.out.fault);
      ASSERT_EQ(a.out.flags, b.out.flags);
    }
  }
}

/** A hand that is shaken against a spring wall whose force acts `delay` ticks late. */
struct Shaken {
  Guard guard;
  DeviceSample sample;
  GuardInput in;
  GuardOutput out;
  std::vector<double> sent{0};
  double given = 0;  ///< Energy that the hand got [J].
  std::size_t delay;
  std::uint32_t acted = 0;

  Shaken(const GuardConfig& config, std::size_t d, double damping) : guard(config), delay(d) {
    in.sample = &sample;
    in.dt = kDt;
    in.damping = damping;
    sample.fresh = true;
    (void)guard.arm();
  }
  void step(double depth, double stiffness) {
    const double before = sample.p.x();
    sample.p = {-depth, 0, 0};
    if (sent.size() > delay) given += sent[sent.size() - 1 - delay] * (sample.p.x() - before);
    in.now_ns += 1'000'000;
    in.source[HD_SOURCE_SURFACE].force = {stiffness * depth, 0, 0};
    in.stored = 0.5 * stiffness * depth * depth;
    guard.step(in, out);
    sent.push_back(out.command.force.x());
    acted += (out.flags & HD_SAMPLE_PASSIVITY) != 0 ? 1 : 0;
  }
};

TEST(GuardProperty, TheControllerTakesFromAShakenHandAndKeepsToWhatTheContactLeavesIt) {
  // The damping force is b (v + n dv) with n = delay + 1, and acts n ticks after the middle of the displacement that v
  // is of: at the angle a per tick it takes b A^2 w^2 / 2 Re{(1 + n (1 - e^-ia)) e^-ina}. Without dv that would be cos
  // na.
  const auto takes = [](double n, double a) { return std::cos(n * a) + n * (std::cos(n * a) - std::cos((n + 1) * a)); };
  std::uint32_t compared = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    const std::size_t delay = random.below(4);
    const double n = static_cast<double>(delay) + 1;
    double angle = random.in(0.02, 1.2);
    while (takes(n, angle) < 0.3) angle *= 0.9;
    GuardConfig config;
    config.limits = {200, 1, 1e6, 1, 1, 50, 1e4, 1e4};
    config.ramp_ns = 0;
    config.energy_limit = 1e9;
    config.delay = static_cast<double>(delay);
    config.max_damping = random.in(1, 20);
    const double damping = random.once(3) ? 1.5 * config.max_damping : random.in(0, 1.5 * config.max_damping);
    const double left = std::min(config.max_damping, 1.5 * config.max_damping - damping);
    config.passivity = true;
    Shaken with(config, delay, damping);
    config.passivity = false;
    Shaken without(config, delay, damping);
    const double amplitude = random.in(1e-4, 1e-3), stiffness = random.in(500, 5000);
    double before = 0, change = 0;
    for (int i = 0; i < 1500; ++i) {
      const double depth = i < 20 ? 0 : amplitude * std::min(1.0, (i - 20) / 200.0) * (1.5 - std::cos(angle * i));
      const double moved = depth - before;
      with.step(depth, stiffness);
      without.step(depth, stiffness);
      const double fast = (std::abs(moved) + n * std::abs(moved - change)) / kDt;
      ASSERT_LE(std::abs(with.sent.back() - without.sent.back()), left * fast * (1 + 1e-9) + 1e-9) << i;
      before = depth;
      change = moved;
    }
    EXPECT_LE(with.given, without.given + 1e-9) << "delay " << delay << " angle " << angle;
    compared += with.acted > 100 ? 1 : 0;
    if (left == 0) {
      EXPECT_EQ(with.acted, 0u);
    }
  });
  EXPECT_GT(compared, drawn(20u));
}

}  // namespace
}  // namespace hapticd
