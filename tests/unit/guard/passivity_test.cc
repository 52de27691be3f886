#include "rt/guard/passivity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/unit/guard/hand_sim.h"

namespace hapticd {
namespace {

/** Solid below n.x = 0: force k d - b v.n, seen `delay` ticks late. */
struct DelayedWall {
  Vec3 n = Vec3::UnitX();
  double k = 600, b = 0;
  std::size_t delay = 0;
  bool tell_stored = true;
  std::array<double, 32> past{};
  std::size_t tick = 0;

  void operator()(GuardInput& in, const Vec3& x, const Vec3& v) {
    const double d = -n.dot(x);
    past[tick % past.size()] = d > 0 ? std::max(0.0, k * d - b * n.dot(v)) : 0.0;
    const Vec3 f = tick >= delay ? Vec3(past[(tick - delay) % past.size()] * n) : Vec3(Vec3::Zero());
    ++tick;
    in.source[HD_SOURCE_SURFACE].force = f;
    in.stored = tell_stored ? 0.5 * k * std::max(0.0, d) * std::max(0.0, d) : -1;
  }
};

GuardConfig open() {
  GuardConfig config = rigConfig();
  config.limits.force = 100;
  config.limits.force_slew = 1e6;
  config.limits.velocity = 10;
  config.limits.power = config.limits.active_power = 1000;
  return config;
}

TEST(Passivity, ObserverBooksTheWorkOfTheForceHeld) {
  Passivity p(1);
  p.observe({2, -1, 0.5}, {1e-3, 2e-3, 0}, {0, 0, 0});
  EXPECT_DOUBLE_EQ(p.byAxis().x(), -2e-3);
  EXPECT_DOUBLE_EQ(p.byAxis().y(), 2e-3);
  EXPECT_DOUBLE_EQ(p.energy(), 0);
  p.observe({0, 0, 0}, {1, 1, 1}, {1e-3, 0, 0});
  EXPECT_DOUBLE_EQ(p.energy(), 1e-3) << "what a moving body puts in may be given back";
}

TEST(Passivity, StoreIsBoundByWhatTheWorldHolds) {
  Passivity p(1);
  p.observe({-10, -5, 0}, {0.02, 0.02, 0}, Vec3::Zero());
  ASSERT_DOUBLE_EQ(p.energy(), 0.3);
  p.limitStore(0.05);
  EXPECT_NEAR(p.energy(), 0.05 + Passivity::kMargin, 1e-15);
  EXPECT_NEAR(p.byAxis().x() / p.byAxis().y(), 2, 1e-12);
  p.limitStore(0);
  EXPECT_NEAR(p.energy(), Passivity::kMargin, 1e-15);
}

TEST(Passivity, ControllerRepaysTheDebtAndNoMore) {
  Passivity p(100);
  p.observe({1, 0, 0}, {3e-3, 0, 0}, Vec3::Zero());  // 3 mJ given away.
  const Vec3 v(0.2, 0, 0);
  const Vec3 f = p.control(Vec3::Zero(), v, v, Vec3::Zero(), 1e-3);
  ASSERT_TRUE(p.acting());
  EXPECT_NEAR(-f.dot(v) * Passivity::kRepay_s, 3e-3 - Passivity::kDeadZone, 1e-12);
  EXPECT_EQ(p.control(Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), 1e-3), Vec3(0, 0, 0))
      << "no force at rest";
  EXPECT_FALSE(p.acting());
}

// The force of this tick acts until the next: what it will put in then counts now.
TEST(Passivity, ControllerLooksOneTickAhead) {
  Passivity p(100);
  const Vec3 f(10, 0, 0), v(0.1, 0, 0);
  EXPECT_EQ(p.control(f, v, v, Vec3::Zero(), 1e-6), f);
  const double debt = 10 * 0.1 * 1e-3 - Passivity::kDeadZone;
  EXPECT_NEAR(p.control(f, v, v, Vec3::Zero(), 1e-3).x(), 10 - debt / Passivity::kRepay_s / 0.1, 1e-9);
  EXPECT_EQ(p.control(f, v, v, {1, 0, 0}, 1e-3), f) << "who moves the wall pays for it";
  EXPECT_EQ(p.control(f, -v, -v, Vec3::Zero(), 1e-3), f);
}

TEST(Passivity, LeakAndDebtTogetherHaveOneBound) {
  Passivity p(2);
  p.follow(1);
  p.observe({10, 0, 0}, {1, 0, 0}, Vec3::Zero());
  EXPECT_NEAR(p.control({10, 0, 0}, {0.5, 0, 0}, {0.5, 0, 0}, Vec3::Zero(), 1e-3).x(), 10 - 2 * 0.5, 1e-12);
}

TEST(Passivity, BothBooksAreForgotten) {
  Passivity p(2);
  p.follow(1);
  p.observe({10, 0, 0}, {1, 0, 0}, Vec3::Zero());
  p.reset();
  EXPECT_EQ(p.energy(), 0);
  EXPECT_EQ(p.control({10, 0, 0}, {0.01, 0, 0}, {0.01, 0, 0}, Vec3::Zero(), 1e-3), Vec3(10, 0, 0));
  EXPECT_FALSE(p.acting());
}

TEST(Passivity, ControllerDampingIsBounded) {
  Passivity p(5);
  p.observe({1, 1, 1}, {0.1, 0.05, -0.01}, Vec3::Zero());
  const Vec3 v(0.01, -0.02, 0.3);
  const Vec3 f = p.control(Vec3::Zero(), v, v, Vec3::Zero(), 1e-3);
  EXPECT_NEAR(f.x(), -5 * 0.01, 1e-12) << "the axis with the largest debt has it all";
  EXPECT_NEAR(f.y(), 5 * 0.5 * 0.02, 1e-12);
  EXPECT_EQ(f.z(), 0) << "an axis in credit has none";
}

/** Runs a tap against the wall; true if every force came through as it was wanted. */
bool untouched(HandSim<DelayedWall> sim, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    const GuardOutput& out = sim.tick();
    if ((out.flags & HD_SAMPLE_PASSIVITY) != 0 || out.fault != HD_FAULT_NONE) return false;
    if ((out.command.force - sim.rig.in.source[HD_SOURCE_SURFACE].force).norm() > 1e-11) return false;
  }
  return true;
}

TEST(Passivity, DampedWallIsUntouched) {
  // Passive with zero-order hold once b > k T / 2 = 0.3 N s/m (Colgate and Schenkel 1994).
  for (const Vec3& n : {Vec3(1, 0, 0), Vec3(Vec3(1, -2, 0.5).normalized())}) {
    for (const double speed : {0.02, 0.1, 0.3}) {
      for (const double resolution : {0.0, 1e-5, 5e-5}) {
        for (const bool told : {true, false}) {
          HandSim sim(open(), DelayedWall{.n = n, .k = 600, .b = 1.5, .tell_stored = told});
          sim.resolution = resolution;
          sim.x = 2e-3 * n;
          sim.v = -speed * n;
          sim.push = -0.8 * n;
          EXPECT_TRUE(untouched(sim, 2000)) << n.transpose() << " " << speed << " " << resolution << " " << told;
        }
      }
    }
  }
}

TEST(Passivity, RestAtAWallIsSilent) {
  HandSim sim(open(), DelayedWall{.k = 1500, .b = 2});
  sim.resolution = 2e-5;
  sim.friction = 2;
  sim.push = {-2, 0, 0};
  for (int i = 0; i < 4000; ++i) {
    const GuardOutput& out = sim.tick();
    ASSERT_FALSE(out.flags & HD_SAMPLE_PASSIVITY) << i;
    ASSERT_LT((out.command.force - sim.rig.in.source[HD_SOURCE_SURFACE].force).norm(), 1e-11);
  }
  EXPECT_NEAR(sim.rig.out.command.force.x(), 2, 2 * (1500 + 2 / 15e-3) * 2e-5) << "within a count or two";
}

/** A ball of 40 mm that is pressed unevenly and stroked around: energy goes in along one axis, comes out along another.
 */
struct RoundWall {
  double k = 800;
  void operator()(GuardInput& in, const Vec3& x, const Vec3&) {
    const double d = 0.04 - x.norm();
    in.source[HD_SOURCE_SURFACE].force = d > 0 ? Vec3(k * d / x.norm() * x) : Vec3(Vec3::Zero());
    in.stored = d > 0 ? 0.5 * k * d * d : 0;
  }
};

TEST(Passivity, CurvedPassiveSurfaceIsNotTakenForActive) {
  // The hand's path is given, not simulated: circles with a pressure that makes the books of single axes drift.
  GuardRig rig(open());
  rig.armFully();
  Passivity books(0);
  RoundWall ball;
  for (int i = 0; i < 20000; ++i) {
    const double a = i * 2e-3;
    const double r = 0.04 - 3e-3 * (1 + 0.8 * std::sin(2 * a)) * std::min(1.0, i / 200.0);
    const Vec3 x = r * Vec3(std::cos(a), std::sin(a), 0);
    const Vec3 moved = i > 0 ? Vec3(x - rig.sample.p) : Vec3(Vec3::Zero());
    books.observe(rig.out.command.force, moved, Vec3::Zero());
    rig.in.velocity.v = moved * 1e3;
    rig.sample.p = x;
    ball(rig.in, x, {});
    rig.step();
    ASSERT_FALSE(rig.out.flags & HD_SAMPLE_PASSIVITY) << i << " " << rig.out.energy;
    ASSERT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_NONE});
  }
  EXPECT_LT(books.byAxis().minCoeff(), -0.05) << "one axis alone looks very active";
  EXPECT_GT(books.energy(), 0) << "the port is not";
}

struct Outcome {
  double delivered = 0, energy = 0, last_speed = 0, peak_speed = 0;
};
Outcome bounce(bool controlled, std::size_t delay, double k) {
  GuardConfig config = open();
  config.passivity = controlled;
  config.max_damping = 10;
  config.energy_limit = 1;
  HandSim sim(config, DelayedWall{.k = k, .delay = delay});
  sim.resolution = 1e-5;
  sim.x = {1e-3, 0, 0};
  sim.push = {-0.5, 0, 0};
  Outcome out;
  for (int i = 0; i < 6000; ++i) {
    sim.tick();
    out.energy = std::min(out.energy, sim.rig.out.energy);
    out.peak_speed = std::max(out.peak_speed, std::abs(sim.v.x()));
    if (i >= 5000) out.last_speed = std::max(out.last_speed, std::abs(sim.v.x()));
  }
  out.delivered = sim.delivered;
  return out;
}

TEST(Passivity, DelayedWallBouncesWithoutAndRestsWithTheController) {
  for (const std::size_t delay : {2, 4, 8}) {
    for (const double k : {400.0, 1000.0}) {
      SCOPED_TRACE(testing::Message() << "delay " << delay << " k " << k);
      const Outcome without = bounce(false, delay, k);
      const Outcome with = bounce(true, delay, k);
      EXPECT_GT(without.last_speed, 0.5) << "left alone the wall throws the hand about for ever";
      EXPECT_GT(without.delivered, 0.1);
      EXPECT_LT(with.peak_speed, 0.25);
      EXPECT_LT(with.last_speed, 0.05) << "the hand comes to rest, but for what a tick of delay leaves";
      EXPECT_LT(with.delivered, 2e-3);
      EXPECT_GT(with.energy, -5e-3);
    }
  }
}

TEST(Passivity, FaultsWhenTheWorldKeepsPushing) {
  // A "surface" that pulls the hand along for ever: no damping can repay that.
  struct Tug {
    void operator()(GuardInput& in, const Vec3&, const Vec3&) { in.source[HD_SOURCE_SURFACE].force = {3, 0, 0}; }
  };
  HandSim<Tug> sim(open(), {});
  for (int i = 0; i < 5000 && sim.rig.out.fault == HD_FAULT_NONE; ++i) sim.tick();
  EXPECT_EQ(sim.rig.out.fault, std::uint32_t{HD_FAULT_ENERGY});
  EXPECT_LT(sim.delivered, sim.rig.config.energy_limit + 0.02);
  EXPECT_GT(sim.delivered, sim.rig.config.energy_limit - 0.02);
}

TEST(Passivity, OfATextureTheReliefIsTheObserversBusiness) {
  struct Tug {
    Vec3 relief;
    void operator()(GuardInput& in, const Vec3&, const Vec3&) {
      in.source[HD_SOURCE_TEXTURE].force = {3, 0, 0};
      in.relief = relief;
    }
  };
  for (const double relief : {0.0, 3.0}) {
    HandSim<Tug> sim(open(), {{relief, 0, 0}});
    for (int i = 0; i < 5000 && sim.rig.out.fault == HD_FAULT_NONE; ++i) sim.tick();
    EXPECT_EQ(sim.rig.out.fault, std::uint32_t{relief > 0 ? HD_FAULT_ENERGY : HD_FAULT_VELOCITY}) << relief;
  }
}

TEST(Passivity, ActiveSourcesAreNotTheObserversBusiness) {
  struct Push {
    void operator()(GuardInput& in, const Vec3&, const Vec3&) {
      in.source[HD_SOURCE_CLIENT].force = {1, 0, 0};
      in.source[HD_SOURCE_LOCAL_MODEL].force = {0, 1, 0};
      in.local_active = {0, 1, 0};
    }
  };
  HandSim<Push> sim(open(), {});
  sim.friction = 5;
  for (int i = 0; i < 5000; ++i) sim.tick();
  EXPECT_GT(sim.delivered, 1.0);
  EXPECT_EQ(sim.rig.out.fault, std::uint32_t{HD_FAULT_NONE});
  EXPECT_NEAR(sim.rig.out.energy, 0, 1e-9);
}

TEST(Passivity, AWallThatMovesIsCharged) {
  // The wall travels at 50 mm/s and takes the hand along. Told of it, the observer stays calm; else it sees activity.
  struct Mover {
    bool told = true;
    double at = 0;
    void operator()(GuardInput& in, const Vec3& x, const Vec3&) {
      at += 0.05 * 1e-3;
      const double d = at - x.x();
      in.source[HD_SOURCE_SURFACE].force = {std::max(0.0, 800 * d), 0, 0};
      in.carried = told ? Vec3(in.source[HD_SOURCE_SURFACE].force * 0.05) : Vec3(Vec3::Zero());
      in.stored = 0.5 * 800 * std::max(0.0, d) * std::max(0.0, d);
    }
  };
  for (const bool told : {true, false}) {
    HandSim<Mover> sim(open(), {.told = told});
    sim.friction = 30;  // A hand that resists: 1.5 N.
    double least = 0;
    for (int i = 0; i < 6000; ++i) least = std::min(least, sim.tick().energy);
    EXPECT_EQ(sim.rig.out.fault, std::uint32_t(told ? HD_FAULT_NONE : HD_FAULT_ENERGY));
    if (told) {
      EXPECT_GT(least, -Passivity::kDeadZone);
    }
  }
}

TEST(Passivity, AHandThatLeansOnAWallWhileTheRampRisesLeavesNoDebt) {
  for (const double limit : {100.0, 5.0}) {
    GuardConfig config = open();
    config.limits.force = limit;  // 5 N: bound until the ramp's end.
    HandSim<DelayedWall> sim(config, {.k = 600, .b = 1});
    sim.friction = 100;  // A hand that gives way slowly.
    sim.rig.guard.disarm();
    for (int i = 0; i < 20; ++i) sim.tick();
    ASSERT_EQ(sim.rig.guard.arm(), ErrorCode::kOk);
    double least = 0, deepest = 0;
    for (int i = 0; i < 3000; ++i) {
      sim.push.x() = i < 60 ? 0.0 : -3.0;
      least = std::min(least, sim.tick().energy);
      deepest = std::min(deepest, sim.x.x());
    }
    EXPECT_LT(deepest, -0.01) << "while the ramp was low";
    EXPECT_GT(sim.delivered, 0.005) << "by which the ramp pushed it out";
    EXPECT_NEAR(sim.x.x(), -0.005, 1e-4);
    EXPECT_GT(least, -0.1e-3) << "limit " << limit;
  }
}

/** Whatever anybody says that springs hold. */
TEST(Passivity, NoStoreIsLargerThanTheMost) {
  for (const double said : {-1.0, double{NAN}, 2.0, 1e9}) {
    Passivity passivity(2);
    passivity.observe({-100, 0, 0}, {1, 0, 0}, Vec3::Zero());
    passivity.limitStore(said);
    EXPECT_NEAR(passivity.energy(), Passivity::kMaxStored + Passivity::kMargin, 1e-12) << said;
  }
}

}  // namespace
}  // namespace hapticd
