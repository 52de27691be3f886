#include "rt/guard/guard.h"

#include <gtest/gtest.h>

#include "tests/unit/rt/guard_rig.h"

namespace hapticd {
namespace {

TEST(Guard, StartsDisarmed) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  for (int i = 0; i < 100; ++i) {
    rig.step();
    EXPECT_TRUE(rig.out.command.force.isZero(0));
    EXPECT_FALSE(rig.out.command.enabled);
    EXPECT_EQ(rig.out.flags, 0u);
  }
  EXPECT_EQ(rig.out.by_source[HD_SOURCE_SURFACE].x(), rig.out.by_source[HD_SOURCE_GUARD].x() * -1);
}

TEST(Guard, RampWaitsForSmallForceThenTakesTwoSeconds) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  rig.step();
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step(1000);
  EXPECT_TRUE(rig.out.command.force.isZero(0)) << "three newtons are not small";
  EXPECT_TRUE(rig.out.command.enabled);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_RAMPING);

  rig.ask(HD_SOURCE_SURFACE, {0.1, 0, 0});
  rig.step(3);
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  rig.step(100);
  EXPECT_TRUE(rig.out.command.force.isZero(0)) << "three small ticks are one too few";

  rig.ask(HD_SOURCE_SURFACE, {0, 0, 0});
  rig.step(4);
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  for (int i = 1; i <= 2000; ++i) {
    rig.step();
    ASSERT_NEAR(rig.out.command.force.x(), 3.0 * i / 2000, 1e-9) << "tick " << i;
  }
  EXPECT_FALSE(rig.out.flags & HD_SAMPLE_RAMPING);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_ARMED);
}

TEST(Guard, GravityCompensationDoesNotHoldTheRampBack) {
  GuardRig rig;
  rig.ask(HD_SOURCE_GRAVITY, {0, 0, 2});
  rig.step();
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step(2010);
  EXPECT_NEAR(rig.out.command.force.z(), 2, 1e-9);
}

TEST(Guard, DisarmLowersAtTheSlewLimitThenOff) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(50);
  ASSERT_NEAR(rig.out.command.force.x(), 5, 1e-9);
  rig.guard.disarm();
  for (int i = 1; i < 10; ++i) {
    rig.step();
    ASSERT_NEAR(rig.out.command.force.x(), 5 - 0.5 * i, 1e-9);
    ASSERT_TRUE(rig.out.command.enabled);
  }
  rig.step(2);  // The slew limit is kept to the safe side of rounding: a few 1e-12 N may be left for one more tick.
  EXPECT_TRUE(rig.out.command.force.isZero(0));
  EXPECT_FALSE(rig.out.command.enabled);
  EXPECT_FALSE(rig.guard.armed());
}

TEST(Guard, DisarmEndsInOneSecondEvenWithoutSlew) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(50);
  GuardLimits limits = rig.guard.limits();
  limits.force_slew = 0;
  ASSERT_EQ(rig.guard.setLimits(limits), ErrorCode::kOk);
  rig.guard.disarm();
  rig.step(990);
  EXPECT_NEAR(rig.out.command.force.x(), 5, 1e-9);
  rig.step(11);
  EXPECT_TRUE(rig.out.command.force.isZero(0));
  EXPECT_FALSE(rig.guard.armed());
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

TEST(Guard, ArmedInTheVeryTickOfAFaultItStillStartsFromZero) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(50);
  rig.guard.latch(HD_FAULT_STOP_LINE);
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step();
  EXPECT_TRUE(rig.out.command.force.isZero(0));
}

TEST(Guard, FirstCauseStays) {
  GuardRig rig;
  rig.armFully();
  rig.guard.latch(HD_FAULT_OVERRUN);
  rig.in.stop_line = true;
  rig.step(3);
  EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_OVERRUN});
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

TEST(Guard, PowerLimitTakesOnlyWhatDeliversPower) {
  GuardRig rig;
  rig.config.passivity = false;
  rig.config.limits.power = 0.5;
  GuardRig r(rig.config);
  r.ask(HD_SOURCE_GRAVITY, {4, 3, 0});
  r.armFully();
  r.step(100);
  r.in.velocity.v = {0.5, 0, 0};
  r.step(100);
  EXPECT_NEAR(r.out.command.force.x(), 1, 1e-9) << "0.5 W at 0.5 m/s";
  EXPECT_NEAR(r.out.command.force.y(), 3, 1e-9) << "across the motion no power flows";
  EXPECT_TRUE(r.out.flags & HD_SAMPLE_LIMITED);
  r.in.velocity.v = {-0.5, 0, 0};
  r.step(100);
  EXPECT_NEAR(r.out.command.force.x(), 4, 1e-9) << "braking is not delivering";
  EXPECT_FALSE(r.out.flags & HD_SAMPLE_LIMITED);
}

TEST(Guard, ActiveSourcesHaveTheirOwnBudget) {
  GuardConfig config = rigConfig();
  config.passivity = false;
  config.limits.active_power = 0.25;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_CLIENT, {2, 0, 0});
  rig.armFully();
  rig.in.velocity.v = {0.5, 0, 0};
  rig.step(100);
  EXPECT_NEAR(rig.out.command.force.x(), 0.5, 1e-9);

  for (const hd_source source : {HD_SOURCE_TEXTURE, HD_SOURCE_TRANSIENT}) {
    GuardRig surface(config);
    surface.ask(source, {2, 0, 0});
    surface.armFully();
    surface.in.velocity.v = {0.5, 0, 0};
    surface.step(100);
    EXPECT_NEAR(surface.out.command.force.x(), 0.5, 1e-9) << "source " << source;
    EXPECT_EQ(surface.out.by_source[source].x(), 2) << "it is told who asked";
  }

  GuardRig passive(config);
  passive.ask(HD_SOURCE_SURFACE, {2, 0, 0});
  passive.armFully();
  passive.in.velocity.v = {0.5, 0, 0};
  passive.step(100);
  EXPECT_NEAR(passive.out.command.force.x(), 2, 1e-9) << "a wall that pushes back gives back what it got";

  GuardRig moving(config);
  moving.ask(HD_SOURCE_SURFACE, {2, 0, 0});
  moving.armFully();
  moving.in.velocity.v = {0.5, 0, 0};
  moving.in.carried = {1, 0, 0};  // The wall itself moves at 0.5 m/s.
  moving.step(2000);
  EXPECT_NEAR(moving.out.command.force.x(), 0.5, 1e-9);
}

}  // namespace
}  // namespace hapticd
