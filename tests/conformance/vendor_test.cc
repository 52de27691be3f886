// What the drivers over vendors' SDKs do of their own: finding the SDK, calibration, orientation, what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/vendor/sdk/dhd_sdk.h"
#include "drivers/vendor/sdk/hd_sdk.h"
#include "drivers/vendor/sdk/pose_check.h"
#include "drivers/vendor/vendor_parameters.h"
#include "tests/conformance/vendor_rig.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Kind = VendorRig::Kind;

/** A servo at 1 kHz. */
struct Servo {
  explicit Servo(VendorRig& r) : rig(r) {}
  void run(int cycles, const Vec3& force = Vec3::Zero(), const Vec3& torque = Vec3::Zero(), double gripper = 0) {
    for (int i = 0; i < cycles; ++i) {
      rig.device().read(rig.now(), sample);
      DeviceCommand command;
      command.enabled = !force.isZero() || !torque.isZero();
      command.force = force;
      command.torque = torque;
      command.gripper_force = gripper;
      rig.device().write(rig.now(), command);
      rig.advance(kMs);
    }
  }
  VendorRig& rig;
  DeviceSample sample;
};

TEST(VendorSdk, AbsentIsOneErrorThatSaysWhatToInstall) {
  const auto dhd = DhdSdk::load("/nowhere/libdhd.so.3");
  ASSERT_FALSE(dhd.ok());
  EXPECT_EQ(dhd.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(toString(dhd.error()), AllOf(HasSubstr("/nowhere/libdhd.so.3"), HasSubstr("install"), HasSubstr("sdk=")));
  const auto hd = HdSdk::load("libnosuchHD.so");
  ASSERT_FALSE(hd.ok());
  EXPECT_THAT(toString(hd.error()), HasSubstr("OpenHaptics"));
}

TEST(VendorSdk, AMissingFunctionIsNamed) {
  const auto dhd = DhdSdk::load(FAKE_VENDOR_SDK_OLD);
  ASSERT_FALSE(dhd.ok());
  EXPECT_EQ(dhd.error().code, ErrorCode::kVersionMismatch);
  EXPECT_THAT(toString(dhd.error()), HasSubstr("it has no dhdErrorGetLastStr"));
  const auto hd = HdSdk::load(FAKE_VENDOR_SDK_OLD);
  ASSERT_FALSE(hd.ok());
  EXPECT_THAT(toString(hd.error()), HasSubstr("it has no hdUnschedule"));
}

TEST(VendorSdk, AnotherVersionIsRefused) {
  for (const Kind kind : {Kind::kOmega3, Kind::kTouch}) {
    VendorRig rig(kind);
    rig.state.version_major = 2;
    const auto opened = rig.device().open();
    ASSERT_FALSE(opened.ok());
    EXPECT_EQ(opened.error().code, ErrorCode::kVersionMismatch);
    EXPECT_THAT(toString(opened.error()), HasSubstr("hapticd knows 3"));
    EXPECT_EQ(rig.state.opened, 0);
  }
}

TEST(VendorSdk, WhatItsLibrarySaysOfAFailureIsPassedOn) {
  VendorRig omega(Kind::kOmega3);
  omega.unplug();
  EXPECT_THAT(toString(omega.device().open().error()), HasSubstr("no device found"));
  VendorRig touch(Kind::kTouch);
  touch.unplug();
  EXPECT_THAT(toString(touch.device().open().error()), AllOf(HasSubstr("played reason"), HasSubstr("0x302")));
}

TEST(VendorUri, NamesDeviceAndLibrary) {
  EXPECT_EQ(resolveDhd({"dhd", "", {}})->info.uri, "dhd://default");
  EXPECT_EQ(resolveDhd({"dhd", "1", {{"serial", "7"}}})->info.uri, "dhd://1?serial=7");
  EXPECT_EQ(resolveDhd({"dhd", "omega", {}}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(resolveDhd({"dhd", "64", {}}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(resolveHd({"openhaptics", "Default", {}})->info.uri, "openhaptics://default");
  EXPECT_EQ(resolveHd({"openhaptics", "Left", {{"sdk", "/opt/libHD.so"}}})->info.uri,
            "openhaptics://Left?sdk=/opt/libHD.so");
  EXPECT_TRUE(isHardware("dhd") && isHardware("openhaptics")) << "their parameters are the administrator's";
}

TEST(VendorUri, OpensTheDeviceThatIsMeant) {
  EXPECT_TRUE(VendorRig(Kind::kOmega3, "dhd://0").device().open().ok());
  EXPECT_FALSE(VendorRig(Kind::kOmega3, "dhd://1").device().open().ok());
  EXPECT_TRUE(VendorRig(Kind::kOmega3, "dhd://default?serial=1234").device().open().ok());
  EXPECT_FALSE(VendorRig(Kind::kOmega3, "dhd://default?serial=1").device().open().ok());
  EXPECT_TRUE(VendorRig(Kind::kTouch, "openhaptics://Left").device().open().ok());
  EXPECT_FALSE(VendorRig(Kind::kTouch, "openhaptics://Right").device().open().ok());
}

TEST(VendorInfo, TellsWhatTheDeviceIs) {
  VendorRig sigma(Kind::kSigma7);
  sigma.makeReady();
  const DeviceInfo& info = sigma.device().info();
  EXPECT_EQ(info.serial, "1234");
  EXPECT_EQ(info.driver_version, "1, SDK 3.17.0.0");
  EXPECT_EQ(info.buttons, 16u) << "a panel's would stand over its own";
  EXPECT_TRUE(info.sensed_rotation && info.actuated_rotation && info.actuated_gripper && info.right_hand);
  EXPECT_GT(info.max_torque, 0);
  EXPECT_NEAR(info.gripper_max_angle, 0.5236, 1e-4) << "no spring could be put on its gripper at 0";
  VendorRig omega(Kind::kOmega3);
  omega.makeReady();
  EXPECT_FALSE(omega.device().info().sensed_rotation);
  EXPECT_EQ(omega.device().info().max_torque, 0);
  EXPECT_EQ(omega.device().info().gripper_max_angle, 0);
  EXPECT_EQ(omega.device().info().max_force, 12);
  VendorRig touch(Kind::kTouch);
  touch.makeReady();
  EXPECT_EQ(touch.device().info().max_force, 3.3);
  EXPECT_EQ(touch.device().info().max_stiffness, 400);
  EXPECT_EQ(touch.device().info().serial, "T1234");
  EXPECT_TRUE(touch.device().info().workspace_upper.isApprox(Vec3(0.035, 0.08, 0.06)));
}

// A turn about each library's own axes is the same turn about ours.
TEST(VendorPose, OrientationIsTurnedIntoOurFrame) {
  const Eigen::Matrix3d r = (Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized())).toRotationMatrix();
  for (const Kind kind : {Kind::kSigma7, Kind::kTouch}) {
    VendorRig rig(kind);
    rig.makeReady();
    for (int i = 0; i < 9; ++i) rig.state.rotation[i] = r(i / 3, i % 3);
    Servo servo(rig);
    servo.run(5);
    // The axis (x, y, z) of HD is (z, x, y) of ours.
    const Vec3 axis = kind == Kind::kTouch ? Vec3(-0.5, 1, 2) : Vec3(1, 2, -0.5);
    const Quat expected(Eigen::AngleAxisd(0.7, axis.normalized()));
    EXPECT_LT(servo.sample.q.angularDistance(expected), 1e-9);
  }
}

TEST(VendorPose, ButtonsAreThoseThatItCounts) {
  VendorRig rig(Kind::kSigma7);
  rig.makeReady();
  rig.state.buttons = 0x18001;
  Servo servo(rig);
  servo.run(5);
  EXPECT_EQ(servo.sample.buttons, 0x8001u);
}

TEST(VendorPose, WhatIsNoRotationIsNoReading) {
  for (const Kind kind : {Kind::kSigma7, Kind::kTouch}) {
    VendorRig rig(kind);
    rig.makeReady();
    Servo servo(rig);
    servo.run(5);
    ASSERT_TRUE(servo.sample.fresh);
    rig.state.rotation[0] = -1;  // A mirror.
    servo.run(5);
    EXPECT_FALSE(servo.sample.fresh);
    EXPECT_GE(rig.link().counters.rejected.load(), 4u);
    servo.run(30);
    EXPECT_NE(servo.sample.status & kDeviceError, 0u) << "and after a while a device error";
  }
}

TEST(VendorPose, AGripperWithoutAnAngleIsNoReading) {
  VendorRig rig(Kind::kSigma7);
  rig.makeReady();
  rig.state.gripper_rad = 0.3;
  Servo servo(rig);
  servo.run(5);
  ASSERT_EQ(servo.sample.gripper_rad, 0.3);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    rig.state.gripper_rad = bad;
    servo.run(5);
    EXPECT_FALSE(servo.sample.fresh);
    EXPECT_EQ(servo.sample.gripper_rad, 0.3) << "the jaws have not closed";
  }
  servo.run(30);
  EXPECT_NE(servo.sample.status & kDeviceError, 0u) << "and after a while a device error";
}

TEST(VendorPose, AHandThatMovesWhileNothingIsHeardIsBelieved) {
  DeviceInfo info;
  info.max_workspace_lower = Vec3::Constant(-0.2);
  info.max_workspace_upper = Vec3::Constant(0.2);
  PoseCheck check;
  using Verdict = PoseCheck::Verdict;
  ASSERT_EQ(check.judge(Vec3(0, -0.05, 0), 0, info), Verdict::kBelieved);
  // A call of the library that took 0.1 s, and a hand at a metre a second; a place that cannot be comes in between.
  EXPECT_EQ(check.judge(Vec3(0, 0.9, 0), 100 * kMs, info), Verdict::kDropped);
  EXPECT_EQ(check.judge(Vec3(0, 0.05, 0), 101 * kMs, info), Verdict::kBelieved);
  // A jump that stays is found all the same, however long it stays.
  for (int i = 1; i < PoseCheck::kBadInARow; ++i)
    EXPECT_EQ(check.judge(Vec3(0, -0.05, 0), (101 + i) * kMs, info), Verdict::kDropped) << i;
  EXPECT_EQ(check.judge(Vec3(0, -0.05, 0), 121 * kMs, info), Verdict::kBroken);
}

TEST(VendorCalibration, BeforeItThereIsNeitherReadingNorForce) {
  for (const Kind kind : {Kind::kOmega3, Kind::kTouch}) {
    VendorRig rig(kind);
    rig.state.calibrated = false;
    ASSERT_TRUE(rig.device().open().ok());
    Servo servo(rig);
    servo.run(200, Vec3(0, 0, 1));
    EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
    EXPECT_FALSE(servo.sample.fresh);
    EXPECT_TRUE(rig.trueForce().isZero());
    rig.state.calibrated = true;
    servo.run(200);
    EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
    EXPECT_TRUE(servo.sample.fresh);
  }
}

TEST(VendorCalibration, TheInkwellIsUsedAsSoonAsTheStylusIsInIt) {
  VendorRig rig(Kind::kTouch);
  rig.state.calibrated = false;
  ASSERT_TRUE(rig.device().open().ok());
  Servo servo(rig);
  servo.run(200);
  EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  rig.state.buttons = 8;  // As the fake tells "in the inkwell".
  servo.run(200);
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
}

TEST(VendorCalibration, OfSeveralWaysOneIsToldAndNeverAResetOfTheEncoders) {
  const std::pair<int, int> cases[] = {{1, 0}, {2, 2}, {3, 2}, {4, 4}, {5, 4}, {6, 2}, {7, 2}};
  for (const auto& [styles, told] : cases) {
    VendorRig rig(Kind::kTouch);
    rig.state.calibrated = false;
    rig.state.hd_styles = styles;
    rig.state.buttons = 8;  // As the fake tells that it may be calibrated now.
    ASSERT_TRUE(rig.device().open().ok());
    Servo servo(rig);
    servo.run(200);
    EXPECT_EQ(rig.state.hd_calibrated_by, told) << styles;
    EXPECT_EQ(rig.device().calibration(), told == 0 ? Calibration::kNeeded : Calibration::kDone) << styles;
  }
}

TEST(VendorForce, TorqueAndGripperGoWhereThereAreMotorsForThem) {
  VendorRig sigma(Kind::kSigma7);
  sigma.makeReady();
  Servo servo(sigma);
  servo.run(20, Vec3(1, 0, 0), Vec3(0.1, -0.2, 0.3), 5);
  EXPECT_DOUBLE_EQ(sigma.state.torque[1], -0.2);
  EXPECT_DOUBLE_EQ(sigma.state.gripper_force, 5);
  servo.run(20, Vec3(1, 0, 0), Vec3(0, 0, 9), 50);
  EXPECT_DOUBLE_EQ(sigma.state.torque[2], sigma.device().info().max_torque);
  EXPECT_DOUBLE_EQ(sigma.state.gripper_force, sigma.device().info().max_gripper_force);
  VendorRig omega(Kind::kOmega3);
  omega.makeReady();
  Servo(omega).run(20, Vec3(1, 0, 0), Vec3(0, 0, 9), 50);
  EXPECT_EQ(omega.state.torque[2], 0);
  EXPECT_EQ(omega.state.gripper_force, 0);
}

// The SDK tells a left-handed gripper's angle, and is told its force, the other way round.
TEST(VendorForce, APositiveOneOpensTheGripperForEitherHand) {
  for (const bool left : {false, true}) {
    VendorRig rig(Kind::kSigma7);
    rig.state.system_type = left ? 105 : 104;
    rig.state.gripper_rad = left ? -0.3 : 0.3;
    rig.makeReady();
    Servo servo(rig);
    servo.run(20, Vec3(1, 0, 0), Vec3::Zero(), 5);
    EXPECT_EQ(servo.sample.gripper_rad, 0.3) << left;
    EXPECT_EQ(rig.state.gripper_force, left ? -5 : 5);
    EXPECT_EQ(rig.device().info().left_hand, left);
  }
}

TEST(VendorForce, ADeviceThatSwitchesItsForcesOffItselfIsAFault) {
  VendorRig rig(Kind::kOmega3);
  rig.makeReady();
  Servo servo(rig);
  servo.run(200, Vec3(0, 0, 1));
  EXPECT_EQ(servo.sample.status, kDeviceOk);
  rig.state.forces_refused = true;  // Its own button, or its own velocity limit.
  servo.run(200, Vec3(0, 0, 1));
  EXPECT_NE(servo.sample.status & kDeviceDeadmanOpen, 0u);
  rig.state.forces_refused = false;
  servo.run(200, Vec3(0, 0, 1));
  EXPECT_TRUE(rig.trueForce().isZero()) << "until it was switched off here too";
  servo.run(5);
  servo.run(5, Vec3(0, 0, 1));
  EXPECT_EQ(rig.trueForce(), Vec3(0, 0, 1));
}

TEST(VendorForce, ItsOwnSaturationIsTold) {
  VendorRig rig(Kind::kOmega3);
  rig.makeReady();
  rig.state.saturating = true;
  Servo servo(rig);
  servo.run(20, Vec3(0, 0, 1));
  EXPECT_NE(servo.sample.status & kDeviceSaturated, 0u);
}

TEST(VendorForce, ErrorsOfHdsForceAndMotorsAreFaults) {
  VendorRig rig(Kind::kTouch);
  rig.makeReady();
  Servo servo(rig);
  servo.run(20, Vec3(0, 0, 1));
  rig.state.hd_error = 0x200;  // Warm motors.
  rig.advance(kMs);
  rig.device().read(rig.now(), servo.sample);
  EXPECT_NE(servo.sample.status & kDeviceError, 0u);
}

TEST(VendorForce, WhatHdSaysOfAForceWhenItIsSentIsAFaultToo) {
  VendorRig rig(Kind::kTouch);
  rig.makeReady();
  Servo servo(rig);
  servo.run(20, Vec3(0, 0, 1));
  ASSERT_EQ(servo.sample.status, kDeviceOk);
  rig.state.hd_force_error = 0x200;
  bool told = false;
  for (int i = 0; i < 5; ++i) {
    servo.run(1, Vec3(0, 0, 1));
    told = told || (servo.sample.status & kDeviceError) != 0;
  }
  EXPECT_TRUE(told);
  servo.run(20, Vec3(0, 0, 1));
  EXPECT_EQ(servo.sample.status, kDeviceOk) << "told once, as it was";
}

TEST(VendorForce, ADeviceThatTakesNoForceAnyMoreIsGone) {
  VendorRig rig(Kind::kOmega3);
  rig.makeReady();
  Servo servo(rig);
  servo.run(20, Vec3(0, 0, 1));
  rig.state.deaf = true;  // It goes on pushing with what it has, and tells where it is.
  servo.run(30);
  EXPECT_EQ(servo.sample.status & kDeviceGone, 0u) << "nobody asks it for a force";
  rig.state.deaf = false;
  servo.run(20, Vec3(0, 0, 1));
  rig.state.deaf = true;
  servo.run(30, Vec3(0, 0, 1));
  EXPECT_NE(servo.sample.status & kDeviceGone, 0u);
  EXPECT_FALSE(rig.state.force_on);
}

TEST(VendorForce, OneThatCannotBeSwitchedOffIsNotOffAndIsSoonGone) {
  VendorRig rig(Kind::kOmega3);
  rig.makeReady();
  Servo servo(rig);
  servo.run(20, Vec3(0, 0, 1));
  rig.state.deaf = rig.state.stuck_on = true;
  bool gone = false;
  for (int i = 0; i < 30 && !gone; ++i) {
    ASSERT_FALSE(rig.device().isOff()) << i;
    servo.run(1);
    rig.device().read(rig.now(), servo.sample);
    gone = (servo.sample.status & kDeviceGone) != 0;
  }
  EXPECT_TRUE(gone);
}

TEST(VendorLife, TheSdkCarriesTheArmOnlyIfAskedTo) {
  VendorRig plain(Kind::kOmega3);
  plain.makeReady();
  EXPECT_EQ(plain.state.gravity_on, 0);
  VendorRig carried(Kind::kOmega3, "dhd://default?gravity=1");
  carried.makeReady();
  EXPECT_EQ(carried.state.gravity_on, 1);
  carried.device().close();
  EXPECT_EQ(carried.state.gravity_on, 0);
}

TEST(VendorLife, EveryWayOutClosesTheLibrary) {
  for (const Kind kind : {Kind::kOmega3, Kind::kTouch}) {
    VendorRig rig(kind);
    rig.makeReady();
    Servo(rig).run(20, Vec3(0, 0, 1));
    rig.device().close();
    rig.device().close();
    EXPECT_EQ(rig.state.opened, 1);
    EXPECT_EQ(rig.state.closed, 1);
    EXPECT_EQ(rig.state.closed_pushing, 0) << "zeros are told before it is let go";
    EXPECT_FALSE(rig.state.force_on);
    EXPECT_TRUE(rig.trueForce().isZero());
  }
}

TEST(VendorLife, HdIsAskedAndToldWithinFramesAlone) {
  VendorRig rig(Kind::kTouch);
  rig.makeReady();
  Servo(rig).run(300, Vec3(0, 0, 1));
  rig.device().close();
  EXPECT_EQ(rig.state.frames_outside, 0);
}

TEST(VendorLife, AnotherKindOfDeviceInItsPlaceIsNotTakenForIt) {
  VendorRig rig(Kind::kOmega3);
  rig.makeReady();
  rig.unplug();
  Servo servo(rig);
  servo.run(50);
  rig.state.system_type = 104;
  rig.plugIn();
  servo.run(1500);
  EXPECT_NE(servo.sample.status & kDeviceGone, 0u);
  rig.state.system_type = 33;
  servo.run(1500);
  EXPECT_EQ(servo.sample.status, kDeviceOk);
}

}  // namespace
}  // namespace hapticd::test
