#include "rt/guard/guard.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/unit/guard/guard_rig.h"

namespace hapticd {
namespace {

TEST(Guard, StartsDisarmed) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  rig.in.velocity.v = {1, 0, 0};
  for (int i = 0; i < 100; ++i) {
    rig.sample.p.x() += 1e-3;
    rig.step();
    EXPECT_TRUE(rig.out.command.force.isZero(0));
    EXPECT_EQ(rig.out.energy, 0);
    EXPECT_FALSE(rig.out.command.enabled);
    EXPECT_EQ(rig.out.flags, 0u);
  }
  EXPECT_EQ(rig.out.by_source[HD_SOURCE_SURFACE].x(), rig.out.by_source[HD_SOURCE_GUARD].x() * -1);
}

struct Cause {
  std::uint32_t fault;
  void (*apply)(GuardRig&);
  void (*clear)(GuardRig&);
};

TEST(Guard, FaultsFallToZeroInOneTickLatchAndRefuseToArmWhileTheyLast) {
  const Cause causes[] = {
      {HD_FAULT_STOP_LINE, [](GuardRig& r) { r.in.stop_line = true; }, [](GuardRig& r) { r.in.stop_line = false; }},
      {HD_FAULT_DEADMAN, [](GuardRig& r) { r.in.deadman_open = true; }, [](GuardRig& r) { r.in.deadman_open = false; }},
      {HD_FAULT_DEADMAN, [](GuardRig& r) { r.sample.status = kDeviceDeadmanOpen; },
       [](GuardRig& r) { r.sample.status = kDeviceOk; }},
      {HD_FAULT_DEVICE_ERROR, [](GuardRig& r) { r.sample.status = kDeviceError; },
       [](GuardRig& r) { r.sample.status = kDeviceOk; }},
      {HD_FAULT_DEVICE_ERROR, [](GuardRig& r) { r.sample.status = kDeviceGone; },
       [](GuardRig& r) { r.sample.status = kDeviceOk; }},
      {HD_FAULT_NOT_FINITE, [](GuardRig& r) { r.in.source[HD_SOURCE_CLIENT].torque.y() = std::nan(""); },
       [](GuardRig& r) { r.in.source[HD_SOURCE_CLIENT].torque.y() = 0; }},
      {HD_FAULT_NOT_FINITE,
       [](GuardRig& r) {
         r.sample.has_velocity = true;
         r.sample.v.y() = std::nan("");
       },
       [](GuardRig& r) { r.sample.v.setZero(); }},
      {HD_FAULT_NOT_FINITE,
       [](GuardRig& r) {
         r.sample.has_velocity = true;
         r.sample.w.y() = std::nan("");
       },
       [](GuardRig& r) { r.sample.w.setZero(); }},
      {HD_FAULT_NOT_FINITE, [](GuardRig& r) { r.in.velocity.v.x() = std::nan(""); },
       [](GuardRig& r) { r.in.velocity.v.setZero(); }},
      {HD_FAULT_NOT_FINITE, [](GuardRig& r) { r.in.velocity.w.x() = std::nan(""); },
       [](GuardRig& r) { r.in.velocity.w.setZero(); }},
      {HD_FAULT_VELOCITY, [](GuardRig& r) { r.in.velocity.w.x() = 1001; },
       [](GuardRig& r) { r.in.velocity.w.setZero(); }},
      {HD_FAULT_VELOCITY,
       [](GuardRig& r) {
         r.in.velocity.v = {0, 2.01, 0};
       },
       [](GuardRig& r) { r.in.velocity.v.setZero(); }},
      {HD_FAULT_OVERRUN, [](GuardRig& r) { r.in.missed = 50; }, [](GuardRig& r) { r.in.missed = 0; }},
  };
  for (const Cause& cause : causes) {
    SCOPED_TRACE(cause.fault);
    GuardRig rig;
    rig.sample.v.setZero();
    rig.sample.w.setZero();
    rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
    rig.armFully();
    rig.step(50);
    ASSERT_NEAR(rig.out.command.force.x(), 5, 1e-9);

    cause.apply(rig);
    rig.step();
    EXPECT_TRUE(rig.out.command.force.isZero(0));
    EXPECT_FALSE(rig.out.command.enabled);
    EXPECT_EQ(rig.out.fault, cause.fault);
    EXPECT_EQ(rig.out.flags, std::uint32_t{HD_SAMPLE_FAULT});
    EXPECT_EQ(rig.guard.arm(), ErrorCode::kFaultLatched);

    cause.clear(rig);
    rig.step(10);
    EXPECT_EQ(rig.out.fault, cause.fault) << "a fault stays after its cause";
    EXPECT_TRUE(rig.out.command.force.isZero(0));
    EXPECT_EQ(rig.guard.arm(), ErrorCode::kOk);
    rig.step();
    EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_NONE});
    EXPECT_TRUE(rig.out.command.force.isZero(0)) << "armed again means the whole ramp again";
  }
}

TEST(Guard, DeviceIsLostWhenSamplesStop) {
  GuardRig rig;
  rig.armFully();
  rig.sample.fresh = false;
  rig.step(20);
  EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_NONE});
  rig.step();
  EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_DEVICE_LOST});
  EXPECT_EQ(rig.guard.arm(), ErrorCode::kFaultLatched);
  rig.sample.fresh = true;
  rig.step();
  EXPECT_EQ(rig.guard.arm(), ErrorCode::kOk);
}

TEST(Guard, FirstCauseStays) {
  GuardRig rig;
  rig.armFully();
  rig.guard.latch(HD_FAULT_OVERRUN);
  rig.in.stop_line = true;
  rig.step(3);
  EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_OVERRUN});
}

TEST(Guard, ARefusedArmNamesWhatStandsInTheWayNow) {
  GuardRig rig;
  rig.armFully();
  rig.in.missed = 50;
  rig.step();
  ASSERT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_OVERRUN});
  rig.in.missed = 0;
  rig.in.deadman_open = true;
  rig.step();
  EXPECT_EQ(rig.guard.arm(), ErrorCode::kFaultLatched);
  EXPECT_EQ(rig.guard.fault(), std::uint32_t{HD_FAULT_DEADMAN});
}

TEST(Guard, WhatIsNoCauseLatchesNothing) {
  GuardRig rig;
  rig.armFully();
  rig.guard.latch(HD_FAULT_NONE);
  rig.guard.latch(HD_FAULT_COUNT);
  EXPECT_TRUE(rig.guard.armed());
  EXPECT_EQ(rig.guard.fault(), std::uint32_t{HD_FAULT_NONE});
}

TEST(Guard, WhatIsBrokenLatchesADisarmedDeviceToo) {
  const struct {
    std::uint32_t fault;
    void (*apply)(GuardRig&);
  } causes[] = {
      {HD_FAULT_STOP_LINE, [](GuardRig& r) { r.in.stop_line = true; }},
      {HD_FAULT_NOT_FINITE, [](GuardRig& r) { r.sample.p.x() = std::nan(""); }},
      {HD_FAULT_DEVICE_LOST, [](GuardRig& r) { r.in.now_ns += 1'000'000'000; }},
      {HD_FAULT_DEVICE_ERROR, [](GuardRig& r) { r.sample.status = kDeviceError; }},
  };
  for (const auto& cause : causes) {
    GuardRig rig;
    rig.step(3);
    rig.sample.fresh = false;
    cause.apply(rig);
    rig.step();
    EXPECT_EQ(rig.out.fault, cause.fault);
  }
}

TEST(Guard, WithLimitsThatAreNoneItSendsNothing) {
  GuardConfig config = rigConfig();
  config.limits.torque = std::nan("");
  GuardRig rig(config);
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(50);
  EXPECT_TRUE(rig.guard.armed());
  EXPECT_TRUE(rig.out.command.force.isZero(0));
}

TEST(Guard, GripperForceRisesAtTheSlewToItsLimit) {
  GuardRig rig;
  rig.armFully();
  rig.in.gripper_force = 5;
  rig.step();
  EXPECT_NEAR(rig.out.command.gripper_force, 0.5, 1e-9);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_LIMITED);
  rig.step(20);
  EXPECT_NEAR(rig.out.command.gripper_force, 4, 1e-9);
  rig.in.gripper_force = -3;
  rig.step(20);
  EXPECT_NEAR(rig.out.command.gripper_force, -3, 1e-9);
  EXPECT_FALSE(rig.out.flags & HD_SAMPLE_LIMITED);
  rig.in.source[HD_SOURCE_SURFACE].torque = {0, 0.4, 0};
  rig.step(20);
  EXPECT_NEAR(rig.out.command.torque.y(), 0.3, 1e-9);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_LIMITED);
}

/** To either side, by 500 N/s, to the last step. */
TEST(Guard, GripperForceFallsAtTheSlewToo) {
  for (const double side : {1.0, -1.0}) {
    GuardRig rig;
    rig.armFully();
    rig.in.gripper_force = 3 * side;
    rig.step(20);
    rig.in.gripper_force = -3.2 * side;
    for (int i = 1; i <= 12; ++i) {
      rig.step();
      EXPECT_NEAR(rig.out.command.gripper_force, side * (3 - 0.5 * i), 1e-9);
    }
    rig.step();
    EXPECT_NEAR(rig.out.command.gripper_force, -3.2 * side, 1e-9);
  }
}

TEST(Guard, ATickThatTakesNoTimeOrTooLongIsNone) {
  for (const double dt : {0.0, -1e-3, -0.0, 0.101, 1e9, std::nan("")}) {
    GuardRig rig;
    rig.armFully();
    rig.in.dt = dt;
    EXPECT_EQ(rig.step().fault, std::uint32_t{HD_FAULT_NOT_FINITE}) << dt;
  }
  GuardRig rig;
  rig.armFully();
  rig.in.dt = 0.1;
  EXPECT_EQ(rig.step().fault, std::uint32_t{HD_FAULT_NONE});
}

/** No hand: a broken sensor, whatever the limit says. */
TEST(Guard, FasterThanAnythingIsAFaultWhateverTheLimit) {
  GuardConfig config = rigConfig();
  config.limits.velocity = 1e6;
  for (const auto& [v, w, fault] :
       {std::array{99.0, 0.0, 0.0}, {101.0, 0.0, 1.0}, {0.0, 999.0, 0.0}, {0.0, 1001.0, 1.0}}) {
    GuardRig rig(config);
    rig.armFully();
    rig.in.velocity = {{0, v, 0}, {0, 0, w}};
    EXPECT_EQ(rig.step().fault == std::uint32_t{HD_FAULT_VELOCITY}, fault != 0) << v << ' ' << w;
  }
}

TEST(Guard, WithoutALimitToMissedPeriodsNoneMissedIsNoFault) {
  GuardConfig config = rigConfig();
  config.missed_limit = 0;
  GuardRig rig(config);
  rig.armFully();
  EXPECT_EQ(rig.step().fault, std::uint32_t{HD_FAULT_NONE});
  rig.in.missed = 1;
  EXPECT_EQ(rig.step().fault, std::uint32_t{HD_FAULT_OVERRUN});
}

/** The clock is that of the machine, and the device may need a while for its first sample. */
TEST(Guard, ADeviceThatHasSaidNothingYetIsNotLostAtOnce) {
  GuardRig rig;
  rig.in.now_ns = 1'000'000'000'000;
  rig.sample.fresh = false;
  rig.step(20);
  EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_NONE});
  rig.step(2);
  EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_DEVICE_LOST});
}

TEST(Guard, DailyLifeOfADisarmedDeviceIsNoFault) {
  GuardRig rig;
  rig.in.deadman_open = true;
  rig.in.velocity.v = {5, 0, 0};
  rig.in.missed = 1000;
  rig.step(5);
  EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_NONE});
  EXPECT_EQ(rig.guard.arm(), ErrorCode::kFaultLatched);
  EXPECT_EQ(rig.guard.fault(), std::uint32_t{HD_FAULT_DEADMAN}) << "a refused arm names what stands in the way";
}

TEST(Guard, DailyLifeOfADisarmedDeviceHidesNothingThatIsBroken) {
  const auto gone = [](GuardRig& rig) {
    rig.sample.status = kDeviceGone;
    rig.step();
    rig.sample.status = kDeviceOk;
    rig.step();
  };
  GuardRig let_go;
  let_go.in.deadman_open = true;
  let_go.step(5);
  gone(let_go);
  EXPECT_EQ(let_go.out.fault, std::uint32_t{HD_FAULT_DEVICE_ERROR});

  GuardRig fast;
  fast.in.velocity.v = {3.5, 0, 0};
  fast.step(5);
  fast.sample.fresh = false;
  fast.step(25);
  EXPECT_EQ(fast.out.fault, std::uint32_t{HD_FAULT_DEVICE_LOST});

  GuardRig held;
  held.armFully();
  held.in.deadman_open = true;
  gone(held);
  EXPECT_EQ(held.out.fault, std::uint32_t{HD_FAULT_DEADMAN}) << "armed, the hand's own deed is named first";
}

TEST(Guard, LoweredLimitClampsAtOnce) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {3, -4, 0});
  rig.armFully();
  rig.step(50);
  GuardLimits limits = rig.guard.limits();
  limits.force = 1;
  ASSERT_EQ(rig.guard.setLimits(limits), ErrorCode::kOk);
  rig.step();
  EXPECT_LE(rig.out.command.force.norm(), 1.0);
  EXPECT_NEAR(rig.out.command.force.x(), 0.6, 1e-9);
  EXPECT_NEAR(rig.out.command.force.y(), -0.8, 1e-9);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_LIMITED);
  EXPECT_EQ(rig.guard.setLimits({.force = -1}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(rig.guard.setLimits({.force = std::nan("")}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(rig.guard.limits().force, 1);
}

/** The last check: here of a device that says that it can show any damping, and a hand all but at rest in debt. */
TEST(Guard, WhatIsNoNumberInTheEndIsAFaultAndNotSent) {
  GuardConfig config = rigConfig();
  config.max_damping = INFINITY;
  config.limits.force_slew = 1e6;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(5);
  rig.in.velocity.v = {1e-158, 0, 0};
  rig.sample.p.x() += 1e-3;
  rig.step();
  EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_NOT_FINITE});
  EXPECT_TRUE(rig.out.command.force.isZero(0));
  EXPECT_FALSE(rig.out.command.enabled);
}

/** No device makes a kilonewton, and sums beyond a few would not be exact. */
TEST(Guard, NoLimitIsBeyondAKilonewton) {
  GuardConfig config = rigConfig();
  config.limits = {1e6, 1e6, 1e9, 1e9, 1e6, 2, 1e9, 1e9};
  GuardRig rig(config);
  rig.armFully();
  for (const hd_source source : {HD_SOURCE_SURFACE, HD_SOURCE_CLIENT}) {
    rig.in.source[source] = {Vec3(900, 0, 0), Vec3(0, 900, 0)};
  }
  rig.in.gripper_force = -1e5;
  rig.step(5);
  EXPECT_NEAR(rig.out.command.force.x(), 1024, 1e-9);
  EXPECT_NEAR(rig.out.command.torque.y(), 1024, 1e-9);
  EXPECT_NEAR(rig.out.command.gripper_force, -1024, 1e-9);
}

TEST(Guard, SendsForcesOnTheirGridAndNeverMoreThanAsked) {
  for (const Vec3& asked : {Vec3(1.0 / 3, -2.0 / 7, 1e-13), Vec3(-1e-13, 5e-324, -0.0), Vec3(-0x1p-40, 0x1.8p-40, 7),
                            Vec3(1e300, -1e299, 3e298)}) {
    GuardRig rig;
    rig.ask(HD_SOURCE_SURFACE, asked);
    rig.armFully();
    rig.step(100);
    const Vec3 sent = rig.out.command.force;
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(sent[i] * 0x1p40, std::trunc(sent[i] * 0x1p40)) << i;
      EXPECT_LE(std::abs(sent[i]), std::abs(asked[i])) << i;
      if (asked.norm() < 8) {
        EXPECT_EQ(sent[i], std::trunc(asked[i] * 0x1p40) * 0x1p-40) << i;
      }
    }
  }
}

}  // namespace
}  // namespace hapticd
