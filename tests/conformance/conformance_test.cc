// What any driver must do; see rig.h. Each test is its own servo at 1 kHz.
#include <gtest/gtest.h>

#include <array>

#include "tests/conformance/rig.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

class Conformance : public ::testing::TestWithParam<RigCase> {
 protected:
  void SetUp() override { rig_ = GetParam().make(); }
  Device& device() { return rig_->device(); }

  /** Cycles of a servo: read, write, wait. Returns how many readings were fresh. */
  int run(int cycles, const DeviceCommand& command) {
    int fresh = 0;
    for (int i = 0; i < cycles; ++i) {
      device().read(rig_->now(), sample_);
      fresh += sample_.fresh ? 1 : 0;
      device().write(rig_->now(), command);
      rig_->advance(kMs);
    }
    return fresh;
  }
  /** So many cycles that what was commanded is felt. */
  int settle() { return 2 + static_cast<int>(rig_->mostDelay_ns() / kMs); }

  /** Places well inside the workspace. */
  std::array<Vec3, 5> places() {
    const DeviceInfo& info = device().info();
    const Vec3 middle = (info.workspace_lower + info.workspace_upper) / 2;
    const Vec3 half = (info.workspace_upper - info.workspace_lower) / 2;
    std::array<Vec3, 5> out{middle};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 corner(i < 2 ? 1 : -1, i % 2 == 0 ? 1 : -1, i == 0 || i == 3 ? 1 : -1);
      out[i + 1] = middle + 0.5 * half.cwiseProduct(corner);
    }
    return out;
  }
  /** Six directions along the axes and two across. */
  static std::array<Vec3, 8> directions() {
    return {Vec3(1, 0, 0),
            Vec3(-1, 0, 0),
            Vec3(0, 1, 0),
            Vec3(0, -1, 0),
            Vec3(0, 0, 1),
            Vec3(0, 0, -1),
            Vec3(1, 2, -2).normalized(),
            Vec3(-2, 1, 1).normalized()};
  }
  double modest() { return 0.25 * device().info().max_force; }

  /** Held in the middle and pushing; the starting point of what takes the force away. */
  void pushing() {
    rig_->makeReady();
    rig_->hold(places()[0]);
    run(settle() + 20, push(Vec3(0, 0, modest())));
    ASSERT_NEAR(rig_->trueForce().z(), modest(), 0.1 * modest());
  }
  bool still() { return rig_->trueForce().norm() == 0; }

  std::unique_ptr<Rig> rig_;
  DeviceSample sample_;
};

TEST_P(Conformance, SaysWhatItIsInSaneUnits) {
  const DeviceInfo& info = device().info();
  EXPECT_FALSE(info.uri.empty());
  EXPECT_FALSE(info.driver.empty());
  EXPECT_GT(info.max_force, 0.1);
  EXPECT_LT(info.max_force, 200);
  EXPECT_GT(info.position_resolution, 1e-9);
  EXPECT_LT(info.position_resolution, 1e-3);
  EXPECT_TRUE(((info.workspace_upper - info.workspace_lower).array() > 0.01).all());
  EXPECT_TRUE(((info.workspace_upper - info.workspace_lower).array() < 2).all());
  EXPECT_TRUE((info.max_workspace_lower.array() <= info.workspace_lower.array()).all());
  EXPECT_TRUE((info.max_workspace_upper.array() >= info.workspace_upper.array()).all());
}

TEST_P(Conformance, ReadsWhereTheGripIs) {
  rig_->makeReady();
  for (const Vec3& p : places()) {
    rig_->hold(p);
    run(100, {});
    EXPECT_EQ(sample_.status, kDeviceOk);
    EXPECT_LT((sample_.p - rig_->truePosition()).norm(), rig_->positionTolerance()) << p.transpose();
    EXPECT_LT((rig_->truePosition() - p).norm(), 1e-3);
    EXPECT_LE(sample_.t_ns, rig_->now());
    EXPECT_GT(sample_.t_ns, rig_->now() - rig_->mostDelay_ns() - 2 * kMs);
  }
}

// The Jacobian against the kinematics: the motors' torques do the work that the force should do, wherever the grip is.
TEST_P(Conformance, TheForceIsTheOneCommandedInEveryPlaceAndDirection) {
  rig_->makeReady();
  for (const Vec3& p : places()) {
    rig_->hold(p);
    run(60, {});
    for (const Vec3& direction : directions()) {
      const Vec3 force = modest() * direction;
      run(settle() + 4, push(force));
      EXPECT_LT((rig_->trueForce() - force).norm(), rig_->forceTolerance() + 2e-3 * force.norm())
          << "at " << p.transpose() << ": " << force.transpose() << " is " << rig_->trueForce().transpose();
    }
  }
}

TEST_P(Conformance, SaturationKeepsTheDirectionAndIsTold) {
  rig_->makeReady();
  for (const Vec3& p : places()) {
    rig_->hold(p);
    run(60, {});
    for (const Vec3& direction : directions()) {
      for (const double newtons : {100.0, 1e5, 1e300}) {
        run(settle() + 4, push(newtons * direction));
        const Vec3 force = rig_->trueForce();
        EXPECT_GT(force.norm(), 0.3 * device().info().max_force);
        EXPECT_LT(force.norm(), 5 * device().info().max_force);
        EXPECT_GT(force.normalized().dot(direction), 0.999) << newtons << " N along " << direction.transpose();
        EXPECT_NE(sample_.status & kDeviceSaturated, 0u);
      }
    }
  }
}

TEST_P(Conformance, WhatIsNotANumberIsNoForce) {
  pushing();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    run(settle() + 4, push(Vec3(0, bad, 1)));
    EXPECT_TRUE(still());
    run(settle() + 4, push(Vec3(0, 0, 1)));
    EXPECT_FALSE(still());
  }
}

TEST_P(Conformance, SwitchedOffMeansZero) {
  pushing();
  run(settle(), {});
  EXPECT_TRUE(still());
  DeviceCommand off = push(Vec3(0, 0, 1));
  off.enabled = false;
  run(settle(), off);
  EXPECT_TRUE(still()) << "a force that is not enabled is none";
}

TEST_P(Conformance, SafeMeansZeroWithoutTheServo) {
  pushing();
  device().safe();
  rig_->advance(rig_->mostDelay_ns());
  EXPECT_TRUE(still());
  device().safe();
  rig_->advance(100 * kMs);
  EXPECT_TRUE(still());
}

TEST_P(Conformance, CloseMeansZeroAndItOpensAgainWithout) {
  pushing();
  device().close();
  rig_->advance(kMs);
  EXPECT_TRUE(still());
  device().close();
  device().safe();  // As a signal handler might: nothing to speak to is left.
  rig_->makeReady();
  rig_->hold(places()[0]);
  rig_->advance(50 * kMs);
  EXPECT_TRUE(still());
  EXPECT_GT(run(50, {}), 40);
}

/**
 * Drivers behind a wire (RigCase::wire): it is pulled, falls silent or garbles. Every reading that gets through is
 * where the grip is.
 */
class Wire : public Conformance {
 protected:
  /** Fresh readings in a second of trouble; each within the tolerance. */
  int suffer(Trouble trouble) {
    rig_->makeReady();
    const Vec3 p = places()[1];
    rig_->hold(p);
    run(100, {});
    before_ = rig_->complaints();
    rig_->trouble(trouble, true);
    int fresh = 0;
    worst_ = 0;
    for (int i = 0; i < 1000; ++i) {
      fresh += run(1, push(Vec3(0, 0, modest())));
      if (sample_.fresh) worst_ = std::max(worst_, (sample_.p - p).norm());
    }
    return fresh;
  }
  void recovers() {
    rig_->trouble(Trouble::kSilence, false);
    run(1200, {});
    EXPECT_GE(run(200, {}), 0.2 * rig_->leastRate_hz() - 2);
    EXPECT_LT((sample_.p - places()[1]).norm(), rig_->positionTolerance());
  }
  double worst_ = 0;
  std::uint64_t before_ = 0;
};

TEST_P(Wire, ASilentServoLosesItsForce) {
  EXPECT_EQ(rig_->device().commandLife_ns(), 10 * kMs) << "what the guard is told";
  pushing();
  rig_->advance(20 * kMs + rig_->mostDelay_ns());
  EXPECT_TRUE(still());
}

TEST_P(Conformance, KeepsTheRate) {
  rig_->makeReady();
  rig_->hold(places()[0]);
  run(50, {});
  EXPECT_GE(run(1000, push(Vec3(0, 0, 1))), rig_->leastRate_hz());
}

TEST_P(Wire, UnplugIsToldPushesNotAndReplugGoesOn) {
  pushing();
  rig_->unplug();
  run(20, push(Vec3(0, 0, 1)));
  EXPECT_FALSE(sample_.fresh);
  EXPECT_NE(sample_.status & (kDeviceGone | kDeviceError), 0u);
  run(3000, {});
  EXPECT_NE(sample_.status & (kDeviceGone | kDeviceError), 0u);
  rig_->plugIn();
  // A servo whose guard has not seen the fault still pushes: nothing moves before the user has made it ready.
  run(1500, push(Vec3(0, 0, 1)));
  rig_->makeReadyAgain();
  rig_->hold(places()[1]);
  EXPECT_GT(run(200, {}), 150);
  EXPECT_EQ(sample_.status, kDeviceOk);
  EXPECT_LT((sample_.p - places()[1]).norm(), 1e-3);
}

TEST_P(Wire, TornPacketsAreDroppedAndCounted) {
  suffer(Trouble::kTruncation);
  EXPECT_LT(worst_, rig_->positionTolerance());
  EXPECT_GT(rig_->complaints(), before_ + 20);
  recovers();
}

TEST_P(Wire, StrayBytesCostTheirPacketOnly) {
  suffer(Trouble::kGarbage);
  EXPECT_LT(worst_, rig_->positionTolerance());
  EXPECT_GT(rig_->complaints(), before_);
  recovers();
}

TEST_P(Wire, SilenceIsNotFreshAndPushesNotForLong) {
  const int fresh = suffer(Trouble::kSilence);
  EXPECT_LE(fresh, 5);
  EXPECT_TRUE(still());
}

TEST_P(Wire, APlaceThatCannotBeIsNeverRead) {
  suffer(Trouble::kEncoderJump);
  EXPECT_LT(worst_, rig_->positionTolerance());
  EXPECT_TRUE(still());
}

const auto kName = [](const auto& info) { return info.param.name; };
INSTANTIATE_TEST_SUITE_P(Drivers, Conformance, ::testing::ValuesIn(rigCases()), kName);
INSTANTIATE_TEST_SUITE_P(Drivers, Wire, ::testing::ValuesIn(wireCases()), kName);

}  // namespace
}  // namespace hapticd::test
