// The simulated device as a host sees it: encoders, force path, delays, time.
#include "drivers/sim/sim_device.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <complex>
#include <cstring>
#include <random>

#include "tests/support/seeds.h"
#include "tests/support/stepped/stepped_device.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

using test::SteppedDevice;

const Vec3 kZero = Vec3::Zero();
// A device nobody holds, without friction: what remains is what is tested.
constexpr const char* kBare = "hand_stiffness=0&hand_damping=0&hand_mass=0&viscous=0&coulomb=0";

SimDevice& sim(SteppedDevice& stepped) { return dynamic_cast<SimDevice&>(stepped.device()); }

bool same(const DeviceSample& a, const DeviceSample& b) {
  return a.t_ns == b.t_ns && std::memcmp(a.p.data(), b.p.data(), sizeof a.p) == 0 &&
         std::memcmp(a.q.coeffs().data(), b.q.coeffs().data(), sizeof a.q) == 0;
}

TEST(SimDevice, TheHandFollowsItsCircle) {
  SteppedDevice s("sim://default?motion=circle&radius=0.03&period=2&centre=0,0,0.02&hand_stiffness=400");
  double farthest = 0;
  for (int i = 0; i < 4000; ++i) {
    const DeviceSample& sample = s.step([](const DeviceSample&) { return kZero; });
    EXPECT_TRUE(sample.fresh);
    const double angle = 2 * EIGEN_PI * i * 1e-3 / 2;
    farthest = std::max(farthest, (sample.p - Vec3(0.03 * std::cos(angle), 0.03 * std::sin(angle), 0.02)).norm());
  }
  EXPECT_GT(farthest, 1e-5) << "a hand with mass and friction lags";
  EXPECT_LT(farthest, 3e-3);
}

TEST(SimDevice, ADrivenHandHasTheGainAndPhaseOfItsTransferFunction) {
  // x / x_h = (k + j w b_h) / (k - m w^2 + j w (b + b_h)) at 4 Hz, once the start has died away.
  const double w = 2 * EIGEN_PI * 4, m = 0.35, k = 400, b = 0.5, bh = 6;
  const std::complex<double> gain = std::complex<double>(k, w * bh) / std::complex<double>(k - m * w * w, w * (b + bh));
  SteppedDevice s("sim://default?motion=lissajous&amplitude=0,0.02,0&ratio=1,8,1&coulomb=0&resolution=0");
  s.run(3000);
  for (int i = 3000; i < 3500; ++i) {
    const double y = s.run(1).p.y();
    EXPECT_NEAR(y, 0.02 * std::imag(gain * std::polar(1.0, w * i * 1e-3)), 2e-7) << i;
  }
}

TEST(SimDevice, SteadyDeflectionIsForceOverGripStiffness) {
  SteppedDevice s("sim://default?motion=hold&centre=0.01,0,-0.02&hand_stiffness=500&coulomb=0&resolution=0");
  s.run(3000, [](const DeviceSample&) { return Vec3(0, 2, -1); });
  EXPECT_LT((s.sample().p - Vec3(0.01, 0.004, -0.022)).norm(), 1e-9);
}

TEST(SimDevice, EncodersStepExactly) {
  SteppedDevice s("sim://default?motion=lissajous&resolution=0.0001");
  for (int i = 0; i < 2000; ++i) {
    const DeviceSample& sample = s.step([](const DeviceSample&) { return kZero; });
    for (int k = 0; k < 3; ++k) {
      const double steps = sample.p[k] / 1e-4;
      EXPECT_NEAR(steps, std::round(steps), 1e-9);
      EXPECT_LE(std::abs(sample.p[k] - sim(s).body().position()[k]), 0.5e-4 * (1 + 1e-9));
    }
  }
}

TEST(SimDevice, OrientationStepsExactly) {
  SteppedDevice s("sim://default?dof=6&motion=hold&sway=0.4,-0.3,0.2&rotation_resolution=0.01");
  int moved = 0;
  Vec3 last = kZero;
  for (int i = 0; i < 2000; ++i) {
    const DeviceSample& sample = s.step([](const DeviceSample&) { return kZero; });
    const Vec3 steps = rotationVector(sample.q) / 0.01;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(steps[k], std::round(steps[k]), 1e-6);
    moved += (steps - last).norm() > 0.5 ? 1 : 0;
    last = steps;
  }
  EXPECT_GT(moved, 50);
}

TEST(SimDevice, SaturationKeepsTheDirectionAndSaysSo) {
  SteppedDevice s("sim://default?max_force=3&delay=0");
  s.run(3, [](const DeviceSample&) { return Vec3(10, -20, 20); });
  EXPECT_LT((sim(s).acting().force - Vec3(1, -2, 2)).norm(), 1e-12);
  EXPECT_EQ(s.sample().status, kDeviceSaturated);
  s.run(3, [](const DeviceSample&) { return Vec3(1, 1, 1); });
  EXPECT_EQ(s.sample().status, kDeviceOk);
}

TEST(SimDevice, ForceStepsExactlyAndNeverExceedsTheMaximum) {
  SteppedDevice s("sim://default?max_force=3&force_resolution=0.25&delay=0");
  s.run(2, [](const DeviceSample&) { return Vec3(0.3, -0.62, 0.1); });
  EXPECT_EQ(sim(s).acting().force, Vec3(0.25, -0.5, 0));
  s.run(2, [](const DeviceSample&) { return Vec3(2.9, 2.9, 2.9); });
  EXPECT_NEAR(sim(s).acting().force.norm(), 3, 1e-12);
  EXPECT_TRUE(sim(s).acting().enabled);
}

TEST(SimDevice, ForceActsExactlyNPeriodsLater) {
  for (const int delay : {0, 1, 2, 7, 64}) {
    SteppedDevice s(fmt::format("sim://default?rate=1000&delay={}&resolution=0&{}", delay, kBare));
    // At 1 N on 0.2 kg the sample after k acting periods is 1/2 (F/m) (k ms)^2: the acting time is read off it.
    for (int i = 0; i < delay + 10; ++i) {
      const DeviceSample& sample = s.step([&](const DeviceSample&) { return Vec3(1, 0, 0); });
      const double acting_s = std::max(0, i - delay) * 1e-3;
      EXPECT_NEAR(sample.p.x(), 0.5 * 5 * acting_s * acting_s, 1e-12) << delay << " " << i;
    }
  }
}

TEST(SimDevice, PositionIsSeenExactlyNPeriodsLater) {
  const char* motion = "sim://default?rate=1000&motion=lissajous&position_delay=";
  for (const int delay : {1, 3, 64}) {
    SteppedDevice now(fmt::format("{}0", motion)), late(fmt::format("{}{}", motion, delay));
    std::vector<DeviceSample> seen;
    for (int i = 0; i < 300; ++i) {
      seen.push_back(now.run(1));
      const DeviceSample& sample = late.run(1);
      const auto shown = static_cast<std::size_t>(std::max(0, i - delay));
      EXPECT_TRUE(same(sample, seen[shown])) << delay << " " << i;
      EXPECT_EQ(sample.fresh, i == 0 || i > delay);
    }
  }
}

TEST(SimDevice, LatenessWithinAPeriodChangesNothing) {
  const char* uri = "sim://default?motion=circle&rate=1000";
  SteppedDevice punctual(uri), late(uri);
  std::mt19937 random(seedOf(7));
  std::uniform_int_distribution<std::int64_t> lateness(0, kMs - 1);
  const test::SpringWall wall{Vec3::Zero(), Vec3::UnitX(), 500};
  DeviceSample sample;
  for (int i = 0; i < 3000; ++i) {
    punctual.step(wall);
    const std::int64_t period = punctual.now() - kMs;
    const std::int64_t read = lateness(random);
    late.device().read(period + read, sample);
    DeviceCommand command;
    command.force = wall(sample);
    command.enabled = true;
    late.device().write(period + read + std::uniform_int_distribution<std::int64_t>(0, kMs - 1 - read)(random),
                        command);
    ASSERT_TRUE(same(sample, punctual.sample())) << i;
  }
}

TEST(SimDevice, ReadingMoreOftenChangesNothing) {
  const char* uri = "sim://default?motion=minjerk&seed=3";
  SteppedDevice slow(uri, kMs), fast(uri, kMs / 4);
  for (int i = 0; i < 1000; ++i) {
    slow.run(1);
    fast.run(1);
    ASSERT_TRUE(same(slow.sample(), fast.sample())) << i;
    fast.run(3);
  }
}

TEST(SimDevice, TwoRunsAreTheSameToTheBit) {
  const char* uri = "sim://omega7?motion=minjerk&seed=11&sway=0.2,0.1,0.3";
  SteppedDevice a(uri), b(uri);
  const test::SpringWall wall{Vec3(0, 0, 0.01), Vec3::UnitZ(), 2000};
  for (int i = 0; i < 2000; ++i) {
    a.step(wall);
    b.step(wall);
    ASSERT_TRUE(same(a.sample(), b.sample())) << i;
  }
}

TEST(SimDevice, OnceAPeriodIsFreshAndMoreIsNot) {
  SteppedDevice s("sim://default?rate=1000");
  DeviceSample sample;
  s.device().read(5 * kMs, sample);
  EXPECT_TRUE(sample.fresh);
  EXPECT_EQ(sample.t_ns, 5 * kMs);
  const DeviceSample before = sample;
  s.device().read(5 * kMs + kMs / 2, sample);
  EXPECT_FALSE(sample.fresh);
  EXPECT_TRUE(same(before, sample));
  s.device().read(6 * kMs, sample);
  EXPECT_TRUE(sample.fresh);
  s.device().read(5 * kMs, sample);
  EXPECT_FALSE(sample.fresh) << "time that runs backwards gives nothing new";
}

TEST(SimDevice, AGapIsBoundedCountedAndWithoutAJump) {
  SteppedDevice s("sim://default?rate=1000&motion=circle&period=1");
  s.run(500);
  const Vec3 before = s.sample().p;
  s.setNow(s.now() + 10'000 * kMs);  // Ten seconds: ten turns of the circle.
  s.run(1);
  EXPECT_EQ(sim(s).skippedPeriods(), 10'001u - 20u);
  EXPECT_EQ(s.sample().t_ns, s.now() - kMs);
  EXPECT_LT((s.sample().p - before).norm(), 0.03 * 2 * EIGEN_PI * 0.021);
  const Vec3 after = s.sample().p;
  s.run(1);
  EXPECT_LT((s.sample().p - after).norm(), 0.03 * 2 * EIGEN_PI * 0.0015);
}

TEST(SimDevice, GapsAddUp) {
  for (const unsigned rate : {100u, 1000u}) {
    const std::int64_t period_ns = 1'000'000'000 / rate;
    const unsigned most = rate / 50;
    SteppedDevice s(fmt::format("sim://default?rate={}&motion=circle", rate), period_ns);
    s.run(5);
    EXPECT_EQ(sim(s).skippedPeriods(), 0u) << rate;
    for (unsigned gaps = 1; gaps <= 3; ++gaps) {
      s.setNow(s.now() + 99 * period_ns);
      s.run(5);
      EXPECT_EQ(sim(s).skippedPeriods(), gaps * (100 - most)) << rate;
    }
  }
}

TEST(SimDevice, SafeEndsTheForceAtTheNextPeriod) {
  SteppedDevice s(fmt::format("sim://default?rate=1000&delay=5&resolution=0&{}", kBare));
  s.run(10, [](const DeviceSample&) { return Vec3(1, 0, 0); });
  s.device().safe();
  s.device().safe();
  DeviceSample a, b, c;
  s.device().read(s.now(), a);
  EXPECT_EQ(sim(s).acting().force, kZero);
  s.device().read(s.now() + 10 * kMs, b);
  s.device().read(s.now() + 20 * kMs, c);
  EXPECT_GT(a.p.x(), 0);
  EXPECT_LT(((b.p - a.p) - (c.p - b.p)).norm(), 1e-12) << "it coasts: commands on their way are gone too";
  s.setNow(s.now() + 21 * kMs);
  s.run(10, [](const DeviceSample&) { return Vec3(1, 0, 0); });
  EXPECT_EQ(sim(s).acting().force, Vec3(1, 0, 0)) << "what is told after it counts";
}

TEST(SimDevice, DisabledMeansNoForce) {
  SteppedDevice s("sim://default?delay=0");
  s.run(5, [](const DeviceSample&) { return Vec3(1, 0, 0); });
  DeviceCommand command;
  command.force = Vec3(5, 5, 5);
  command.enabled = false;
  s.device().write(s.now(), command);
  DeviceSample sample;
  s.device().read(s.now() + kMs, sample);
  EXPECT_EQ(sim(s).acting().force, kZero);
  EXPECT_FALSE(sim(s).acting().enabled);
}

TEST(SimDevice, ACommandThatIsNotANumberIsNoForceAndAnError) {
  SteppedDevice s("sim://default?delay=0");
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    s.run(3, [&](const DeviceSample&) { return Vec3(0, bad, 0); });
    EXPECT_EQ(sim(s).acting().force, kZero);
    EXPECT_EQ(s.sample().status, kDeviceError);
    EXPECT_TRUE(isFinite(s.sample().p));
  }
  s.run(3);
  EXPECT_EQ(s.sample().status, kDeviceOk);
}

TEST(SimDevice, LiveHandGoesWhereTheClientSaysAndStays) {
  SteppedDevice s("sim://default?motion=live&coulomb=0&resolution=0");
  s.run(10);
  EXPECT_LT(s.sample().p.norm(), 1e-12);
  DeviceIntent intent;
  intent.p = Vec3(0.01, 0.02, -0.03);
  s.device().setIntent(intent);
  s.run(3000);
  EXPECT_LT((s.sample().p - intent.p).norm(), 1e-9);
  DeviceIntent bad = intent;
  bad.p.x() = std::nan("");
  s.device().setIntent(bad);
  bad = intent;
  bad.q = Quat(0, 0, 0, 0);
  s.device().setIntent(bad);
  s.run(1000);
  EXPECT_LT((s.sample().p - intent.p).norm(), 1e-9);
}

TEST(SimDevice, TorqueTurnsTheWristAndThreeDegreesOfFreedomIgnoreIt) {
  for (const int dof : {3, 6}) {
    SteppedDevice s(fmt::format("sim://default?dof={}&sense_rotation=1&motion=hold&rotation_resolution=0", dof));
    DeviceSample sample;
    for (int i = 0; i < 3000; ++i) {
      s.device().read(s.now(), sample);
      DeviceCommand command;
      command.torque = Vec3(0, 0.1, 0);
      command.enabled = true;
      s.device().write(s.now(), command);
      s.setNow(s.now() + kMs);
    }
    // Grip of 2 N m/rad: 0.05 rad.
    const Vec3 expected = dof == 6 ? Vec3(0, 0.05, 0) : kZero;
    EXPECT_LT((rotationVector(sample.q) - expected).norm(), 1e-6) << dof;
  }
}

TEST(SimDevice, GripperYieldsToForceAndStopsAtItsEnds) {
  SteppedDevice s(
      "sim://default?gripper=1&gripper_angle=0.2&hand_pinch_stiffness=500&gripper_resolution=0&delay=0"
      "&gripper_lever=0.05&gripper_max_angle=0.45&stop_stiffness=2000");
  const auto settle = [&](double force) {
    DeviceSample sample;
    for (int i = 0; i < 2000; ++i) {
      DeviceCommand command;
      command.gripper_force = force;
      command.enabled = true;
      s.device().write(s.now(), command);
      s.setNow(s.now() + kMs);
      s.device().read(s.now(), sample);
    }
    return sample;
  };
  EXPECT_NEAR(settle(0).gripper_rad, 0.2, 1e-9);
  EXPECT_NEAR(settle(2).gripper_rad, 0.2 + 2.0 / 500 / 0.05, 1e-9);  // 4 mm at 5 cm.
  // Cut to 8 N, which pinch and stop bear together: 500 (x - 10 mm) + 2000 (x - end) = +-8 N.
  const DeviceSample open = settle(100), closed = settle(-100);
  EXPECT_NEAR(open.gripper_rad * 0.05, (500 * 0.01 + 2000 * 0.0225 + 8) / 2500, 1e-9);
  EXPECT_NEAR(closed.gripper_rad * 0.05, (500 * 0.01 - 8) / 2500, 1e-9);
  EXPECT_EQ(open.status, kDeviceSaturated);
  EXPECT_EQ(closed.status, kDeviceSaturated);
}

TEST(SimDevice, ReopeningStartsAfresh) {
  SteppedDevice s("sim://default?motion=stroke&wait=1");
  s.run(500, [](const DeviceSample&) { return Vec3(3, 0, 0); });
  s.device().close();
  ASSERT_TRUE(s.device().open().ok());
  DeviceSample sample;
  s.device().read(77 * kMs, sample);
  EXPECT_EQ(sample.t_ns, 77 * kMs);
  EXPECT_LT((sample.p - Vec3(0, -0.03, 0)).norm(), 1e-12);
}

/** Whatever it went through, and whatever was still on its way to its motors. */
TEST(SimDevice, ReopenedItIsAsNew) {
  for (const int before : {1, 30, 200}) {
    const char* uri =
        "sim://default?dof=6&gripper=1&motion=minjerk&seed=5&sway=0.3,0.1,0.2&delay=5&max_force=3&gripper_angle=0.2";
    SteppedDevice again(uri), fresh(uri);
    DeviceCommand command;
    command.force = {5, -4, 3};
    command.torque = {0.05, 0.1, 0};
    command.gripper_force = 2;
    command.enabled = true;
    DeviceSample sample, other;
    for (int i = 0; i < before; ++i) {
      again.device().read(again.now(), sample);
      again.device().write(again.now(), command);
      again.setNow(again.now() + (i == 20 ? 1000 : 1) * kMs);
    }
    again.device().close();
    ASSERT_TRUE(again.device().open().ok());
    for (int i = 0; i < 300; ++i) {
      const std::int64_t now = again.now() + i * kMs;
      again.device().read(now, sample);
      fresh.device().read(now, other);
      ASSERT_TRUE(same(sample, other)) << before << " then " << i;
      ASSERT_EQ(sample.gripper_rad, other.gripper_rad) << before << " then " << i;
      ASSERT_EQ(sample.fresh, other.fresh) << before << " then " << i;
      ASSERT_EQ(sample.status, other.status) << before << " then " << i;
      if (i < 100) continue;
      again.device().write(now, command);
      fresh.device().write(now, command);
    }
    EXPECT_EQ(sim(again).skippedPeriods(), 0u);
  }
}

TEST(SimDevice, TheStabilityBoundaryOfAWallIsTheOneOfTheLiterature) {
  // K = b / (T/2 + t_d) for a heavy device in steady contact (Gil et al. 2009): just below it settles, just above not.
  const double b = 5, period_s = 1e-3;
  for (const int delay : {0, 1, 3}) {
    const double limit = b / (period_s / 2 + delay * period_s);
    const auto amplitude = [&](double stiffness) {
      SteppedDevice s(
          fmt::format("sim://default?rate=1000&delay={}&mass=5&viscous={}&coulomb=0&resolution=0&max_force=200&"
                      "hand_stiffness=0&hand_damping=0&hand_mass=0&centre=0,0,0.001&motion=hold",
                      delay, b));
      const auto spring = [&](const DeviceSample& sample) { return Vec3(-stiffness * sample.p); };
      s.run(20000, spring);
      double largest = 0;
      for (int i = 0; i < 500; ++i) largest = std::max(largest, s.step(spring).p.norm());
      return largest;
    };
    EXPECT_LT(amplitude(0.93 * limit), 0.9e-3) << delay;
    EXPECT_GT(amplitude(1.07 * limit), 1.1e-3) << delay;
  }
}

}  // namespace
}  // namespace hapticd
