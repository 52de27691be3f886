// What sampling and delay leak from a wall's store, against closed forms.
#include <gtest/gtest.h>

#include <vector>

#include "rt/guard/past_forces.h"
#include "tests/unit/guard/hand_sim.h"

namespace hapticd {
namespace {

constexpr double kPeriod = 1e-3;

GuardConfig wide(double delay = 0) {
  GuardConfig config = rigConfig();
  config.limits.force = 100;
  config.limits.force_slew = 1e6;
  config.limits.velocity = 10;
  config.limits.power = config.limits.active_power = 1000;
  config.max_damping = 20;
  config.delay = delay;
  return config;
}

TEST(PastForces, MixesTheTicksThatADelayFallsBetween) {
  PastForces past;
  for (int i = 1; i <= 40; ++i) past.push({1.0 * i, 0, 0});
  EXPECT_EQ(past.acted(0).x(), 40);
  EXPECT_EQ(past.acted(3).x(), 37);
  EXPECT_DOUBLE_EQ(past.acted(2.25).x(), 0.75 * 38 + 0.25 * 37);
  EXPECT_EQ(past.acted(PastForces::kMaxDelay).x(), 24);
  past.reset();
  EXPECT_EQ(past.acted(1.5), Vec3(0, 0, 0));
}

/** A spring of stiffness k pressed along a given path; the hand is moved, not simulated. */
struct GivenPath {
  GuardRig rig;
  double k;
  GivenPath(const GuardConfig& config, double stiffness) : rig(config), k(stiffness) { rig.armFully(); }
  /** Depth d [m]: what the guard takes from the spring's force [N]. */
  double step(double d) {
    rig.sample.p = {-d, 0, 0};
    rig.in.velocity.v = Vec3::Zero();  // What the controller damps is the displacement.
    rig.ask(HD_SOURCE_SURFACE, {std::max(0.0, k * d), 0, 0});
    rig.in.stored = 0.5 * k * d * d;
    rig.step();
    return k * d - rig.out.command.force.x();
  }
};

/** Ticks of 0.2 mm to and fro about 1 mm; compares the first damping with the leak summed up by `leaked`. */
template <class Leaked>
void expectLeak(double delay, Leaked leaked) {
  constexpr double kStiffness = 1000, kStep = 2e-4;
  GivenPath path(wide(delay), kStiffness);
  std::vector<double> depth;
  double owed = 0;
  for (int i = 0; i < 60; ++i) {
    // In slowly, so that the leak of the way in is all but nothing; then to and fro.
    const double d = i < 40 ? 1e-3 * i / 40 : 1e-3 + (i % 2 == 0 ? kStep : 0);
    depth.push_back(d);
    if (i > 0) owed += leaked(kStiffness, depth);
    const double taken = path.step(d);
    const double moved = i > 0 ? depth[i] - depth[i - 1] : 0, before = i > 1 ? depth[i - 1] - depth[i - 2] : 0;
    const double v = (moved + (delay + 1) * (moved - before)) / kPeriod;  // BuzzVelocity, where there are no steps
    if (owed <= Passivity::kLeakZone) {
      ASSERT_NEAR(taken, 0, 1e-9) << i;
      continue;
    }
    // Damping repays what is beyond the zone over kRepayLeak_s: b v^2 kRepayLeak_s = owed. Inward it adds to the force.
    EXPECT_GE(i, 40);
    EXPECT_NEAR(taken * -v * Passivity::kRepayLeak_s, owed - Passivity::kLeakZone, 1e-9) << i;
    return;
  }
  FAIL() << "never owed anything";
}

TEST(PassivityLeak, AHeldSpringLosesHalfKTimesTheSquareOfEachStep) {
  // Received: F held before the step, k d0 (d1 - d0); stored: k (d1^2 - d0^2) / 2.
  expectLeak(0, [](double k, const std::vector<double>& d) {
    const double step = d[d.size() - 1] - d[d.size() - 2];
    return 0.5 * k * step * step;
  });
}

TEST(PassivityLeak, DelayLosesTheForceThatIsLateTimesTheStep) {
  expectLeak(1.5, [](double k, const std::vector<double>& d) {
    const std::size_t n = d.size() - 1;
    const auto at = [&](std::size_t back) { return back <= n ? d[n - back] : 0.0; };
    const double acted = k * (0.5 * at(2) + 0.5 * at(3));
    return 0.5 * k * (at(0) * at(0) - at(1) * at(1)) - acted * (at(0) - at(1));
  });
}

TEST(PassivityLeak, AWallThatIsMovedWithoutSayingSoLeaksLittle) {
  // Each tick the wall comes 0.1 mm nearer and the hand gives way 0.01 mm: the store grows, but sampling did not do it.
  GivenPath path(wide(), 1000);
  double taken = 0;
  for (int i = 0; i < 20; ++i) {
    path.rig.sample.p = {i * 1e-5, 0, 0};
    const double d = 1e-3 + i * 1e-4;
    path.rig.ask(HD_SOURCE_SURFACE, {1000 * d, 0, 0});
    path.rig.in.stored = 500 * d * d;
    path.rig.step();
    taken = std::max(taken, std::abs(1000 * d - path.rig.out.command.force.x()));
  }
  // Leak at most 0.1 N x 0.01 mm a tick: 20 uJ in all, within the zone. What was put in is a hundred times that.
  EXPECT_LT(taken, 1e-9);
}

TEST(PassivityLeak, DampingNeverMakesASurfacePull) {
  Passivity p(1000);
  p.follow(1);
  const Vec3 out = p.control({2, 0, 0}, Vec3::Zero(), {0.5, 3, 0}, Vec3::Zero(), kPeriod);
  EXPECT_TRUE(p.acting());
  EXPECT_EQ(out, Vec3(0, 0, 0)) << "500 N of damping on the way out only take the force away";
  const Vec3 in = p.control({2, 0, 0}, Vec3::Zero(), {-0.01, 3, 0}, Vec3::Zero(), kPeriod);
  EXPECT_NEAR(in.x(), 12, 1e-12);
  EXPECT_EQ(in.y(), 0) << "along the force alone: sliding is free";
}

/** Also where the other book, of which one axis owes, asks for none. */
TEST(PassivityLeak, DampingIsToldHoweverLittle) {
  Passivity p(0.5);
  p.observe(Vec3::Zero(), Vec3::Zero(), {10e-3, -1e-3, 0});
  p.follow(1);
  const Vec3 out = p.control({2, 0, 0}, Vec3::Zero(), {0.5, 0, 0}, Vec3::Zero(), kPeriod);
  EXPECT_NEAR(out.x(), 2 - 0.5 * 0.5, 1e-12);
  EXPECT_TRUE(p.acting());
}

TEST(PassivityLeak, LostEnergyPaysForLittle) {
  Passivity p(10);
  p.follow(-1);
  EXPECT_DOUBLE_EQ(p.leak(), -Passivity::kMargin);
  p.follow(1e9);
  EXPECT_DOUBLE_EQ(p.leak(), Passivity::kMaxStored) << "bounded, whatever it is told";
}

/** Solid below x = 0. */
struct Wall {
  double k;
  void operator()(GuardInput& in, const Vec3& x, const Vec3&) {
    const double d = std::max(0.0, -x.x());
    in.source[HD_SOURCE_SURFACE].force = {k * d, 0, 0};
    in.stored = 0.5 * k * d * d;
  }
};

TEST(PassivityLeak, AWallBeyondTheLimitRestsInsteadOfBuzzing) {
  // Alone it is unstable beyond 2 b / T = 2 x 1.5 / 1 ms = 3000 N/m (Colgate and Schenkel); here twice that and more.
  for (const double k : {4000.0, 6500.0}) {
    double span[2];
    for (const bool controlled : {false, true}) {
      GuardConfig config = wide();
      config.passivity = controlled;
      HandSim sim(config, Wall{k});
      sim.resolution = 1e-5;
      sim.friction = 1.5;
      sim.x = {1e-3, 0, 0};
      sim.push = {-3, 0, 0};
      double low = 1, high = -1, force = 0, depth = 0;
      for (int i = 0; i < 4000; ++i) {
        sim.tick();
        if (i < 3000) continue;
        low = std::min(low, sim.x.x());
        high = std::max(high, sim.x.x());
        force += sim.rig.out.command.force.x();
        depth -= sim.rig.sample.p.x();
      }
      span[controlled] = high - low;
      if (controlled) {
        EXPECT_NEAR(force / depth / k, 1, 0.05) << "as stiff as it was asked to be";
      }
    }
    EXPECT_GT(span[0], 2e-4) << k;
    EXPECT_LT(span[1], 8e-5) << k << ": eight steps of the encoder";
  }
}

}  // namespace
}  // namespace hapticd
