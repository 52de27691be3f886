// Force feedback by USB PID: the layout by descriptor, forces, and what becomes of them when somebody is late or gone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/conformance/hidpid_stick.h"

namespace hapticd::test {
namespace {

using haptic_emu::PidModel;
using haptic_emu::PidVariant;
constexpr int kConstant = 1, kSpring = 8, kDamper = 9;

TEST(HidPid, ReadsWhereTheStickIs) {
  Stick stick;
  ASSERT_TRUE(stick.opened.ok()) << toString(stick.opened.error());
  stick.model.buttons = 0x05;
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(0.02, -0.04, 0), Vec3(-0.05, 0.05, 0)}) {
    stick.hold(p);
    EXPECT_GT(stick.run(50, {}), 45);
    EXPECT_NEAR((stick.sample.p - p).norm(), 0, 3e-6);
  }
  EXPECT_EQ(stick.sample.buttons, 5u);
  stick.model.buttons = 0x82;
  stick.run(50, {});
  EXPECT_EQ(stick.sample.buttons, 0x82u) << "others were let go";
  EXPECT_LE(std::abs(stick.clock.now() - stick.sample.t_ns), 5 * kMs);
  EXPECT_EQ(stick.sample.status, kDeviceOk);
}

TEST(HidPid, TheForceIsTheOneCommanded) {
  Stick stick;
  stick.hold(Vec3(0.01, -0.01, 0));
  for (const Vec3& force : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 2, 0), Vec3(0, -2, 0), Vec3(1.5, -2.5, 0)}) {
    stick.run(10, push(force));
    // The direction travels in 255 steps of a turn: 0.35 and 0.7 degrees off.
    EXPECT_NEAR((stick.model.force() - force).norm(), 0, 0.002 * force.norm() + 0.001) << force.transpose();
  }
  // It lasts, though each effect ends after 0.1 s.
  stick.run(1000, push(Vec3(0, 1, 0)));
  EXPECT_NEAR(stick.model.force().y(), 1, 0.002);
  EXPECT_LE(stick.model.longestDuration_ms(), 200);
}

TEST(HidPid, SaturationKeepsTheDirectionAndIsTold) {
  Stick stick;
  stick.hold(Vec3::Zero());
  for (const double newtons : {4.1, 6.0, 10.0, 1e5, 1e300}) {
    stick.run(10, push(newtons * Vec3(0.5, -1, 0)));
    EXPECT_NEAR((stick.model.force() - Vec3(2, -4, 0)).norm(), 0, 0.02);
    EXPECT_NE(stick.sample.status & kDeviceSaturated, 0u);
  }
  stick.run(5, {});
  EXPECT_EQ(stick.sample.status, kDeviceOk);
}

TEST(HidPid, AForceThatIsNoNumberIsNone) {
  Stick stick;
  stick.hold(Vec3::Zero());
  for (const double none : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    for (const Vec3& force : {Vec3(none, 2, 0), Vec3(2, none, 0), Vec3(none, none, 0)}) {
      stick.run(20, push(Vec3(1, 2, 0)));
      ASSERT_GT(stick.model.force().y(), 1.9);
      stick.run(3, push(force));
      EXPECT_TRUE(stick.model.force().isZero(0)) << force.transpose();
    }
  }
}

TEST(HidPid, PushesTheOtherWayRoundOrInOneDirectionAsItIsTold) {
  Stick inverted({}, {{"invert", "1"}});
  inverted.hold(Vec3::Zero());
  inverted.run(10, push(Vec3(1, 2, 0)));
  EXPECT_NEAR((inverted.model.force() - Vec3(-1, -2, 0)).norm(), 0, 0.02);
  Stick fixed({}, {{"fixed_direction", "1"}});
  fixed.hold(Vec3::Zero());
  fixed.run(10, push(Vec3(1, 2, 0)));
  EXPECT_NEAR((fixed.model.force() - Vec3(0, 2, 0)).norm(), 0, 0.02) << "its second axis is told X's direction, too";
}

TEST(HidPid, WhatADeadProcessLeftIsTakenAwayWhenItIsOpened) {
  Stick dead({.pool = 6});
  dead.hold(Vec3::Zero());
  dead.run(20, push(Vec3(0, 2, 0)));
  ASSERT_EQ(dead.model.effects(), 6u) << "there is room for no more";
  auto resolved = resolveHidPid({"hidpid", "default", {{"max_force", "4"}}}, {});
  ASSERT_TRUE(resolved.ok());
  resolved->hid = [&dead] { return std::make_unique<haptic_emu::InProcessHid>(dead.model, dead.clock); };
  IoDevice next(std::make_unique<HidPidIo>(std::move(*resolved)), IoOptions{.thread = false}, dead.clock);
  ASSERT_TRUE(next.open().ok());
  EXPECT_EQ(dead.model.effects(), 6u);
  EXPECT_FALSE(dead.model.actuatorsOn());
  EXPECT_EQ(dead.model.running(kConstant), 0);
}

TEST(HidPid, NothingPushesBeforeAndAfterItIsSwitchedOn) {
  Stick stick;
  stick.hold(Vec3::Zero());
  stick.run(100, {});
  EXPECT_FALSE(stick.model.actuatorsOn());
  stick.run(20, push(Vec3(0, 2, 0)));
  EXPECT_TRUE(stick.model.actuatorsOn());
  DeviceCommand off = push(Vec3(0, 2, 0));
  off.enabled = false;
  stick.run(3, off);
  EXPECT_FALSE(stick.model.actuatorsOn());
  EXPECT_EQ(stick.model.running(kConstant), 0);
  stick.run(5, push(Vec3(0, 2, 0)));
  EXPECT_NEAR(stick.model.force().y(), 2, 0.01) << "at once again";
  stick.run(3, off);
  stick.run(20, push(Vec3(0, std::nan(""), 0)));
  EXPECT_TRUE(stick.model.force().isZero(0));
}

TEST(HidPid, SafeAndCloseStopItAtOnce) {
  for (const bool close : {false, true}) {
    Stick stick;
    stick.hold(Vec3::Zero());
    stick.run(20, push(Vec3(0, 2, 0)));
    ASSERT_GT(stick.model.force().y(), 1.9);
    close ? stick.device->close() : stick.device->safe();
    EXPECT_FALSE(stick.model.actuatorsOn());
    EXPECT_EQ(stick.model.running(kConstant), 0);
    stick.advance(50);
    EXPECT_TRUE(stick.model.force().isZero(0));
  }
}

TEST(HidPid, TheForceOfADeadProcessEndsByItself) {
  Stick stick;
  stick.hold(Vec3::Zero());
  stick.run(500, push(Vec3(0, 2, 0)));
  ASSERT_GT(stick.model.force().y(), 1.9);
  stick.die(HidPidIo::kHold_ms + 1);
  EXPECT_EQ(stick.model.running(kConstant) + stick.model.running(kSpring) + stick.model.running(kDamper), 0);
  EXPECT_TRUE(stick.model.force().isZero(0));
}

TEST(HidPid, ALateServoIsFollowedByDamperAndSpringForAShortTime) {
  Stick stick({}, {{"fallback", "0.25"}});
  stick.hold(Vec3(0.01, 0.02, 0));
  stick.run(50, push(Vec3(1, 2, 0)));
  stick.advance(13);  // nobody commands
  EXPECT_EQ(stick.model.running(kConstant), 0);
  EXPECT_EQ(stick.model.running(kSpring), 2);
  EXPECT_EQ(stick.model.running(kDamper), 2);
  EXPECT_LT(stick.model.force().norm(), 0.05);  // held still where it was
  // Moved away it is pulled back, with a quarter of the device's force on each axis and no more.
  stick.model.hand.place(Vec3(-0.05, -0.05, 0));
  const Vec3 pulled = stick.model.force();
  EXPECT_GT(pulled.x(), 0.05);
  EXPECT_GT(pulled.y(), 0.05);
  EXPECT_LE(pulled.cwiseAbs().maxCoeff(), 0.25 * PidModel::kFullForce + 0.02);
  stick.advance(HidPidIo::kFallback_ms + 1);
  EXPECT_TRUE(stick.model.force().isZero(0));
  // Not again and again: once, until somebody commands again.
  stick.advance(500);
  EXPECT_EQ(stick.model.running(kSpring) + stick.model.running(kDamper), 0);
  stick.run(20, push(Vec3(0, 1, 0)));
  EXPECT_NEAR(stick.model.force().y(), 1, 0.01);
  EXPECT_EQ(stick.model.running(kSpring), 0);
}

TEST(HidPid, WhoeverCommandsAgainEndsTheFallbackAtOnce) {
  for (const bool enabled : {true, false}) {
    Stick stick({}, {{"fallback", "0.25"}});
    stick.hold(Vec3(0.01, 0.02, 0));
    stick.run(50, push(Vec3(1, 2, 0)));
    stick.advance(13);
    ASSERT_EQ(stick.model.running(kSpring) + stick.model.running(kDamper), 4);
    DeviceCommand command = push(Vec3(0, 1, 0));
    command.enabled = enabled;
    stick.run(3, command);
    EXPECT_EQ(stick.model.running(kSpring) + stick.model.running(kDamper), 0);
    EXPECT_NEAR((stick.model.force() - Vec3(0, enabled ? 1 : 0, 0)).norm(), 0, 0.01);
  }
  // Where nothing pushed nothing is held still.
  Stick idle({}, {{"fallback", "0.25"}});
  idle.run(50, {});
  idle.advance(13);
  EXPECT_EQ(idle.model.running(kSpring) + idle.model.running(kDamper), 0);
  EXPECT_FALSE(idle.model.actuatorsOn());
}

TEST(HidPid, NoFallbackWithoutABoundOnItsForce) {
  Stick stick({.saturation = false});
  ASSERT_TRUE(stick.opened.ok());
  EXPECT_FALSE(stick.io->hasFallback());
  Stick off({}, {{"fallback", "0"}});
  EXPECT_FALSE(off.io->hasFallback());
  EXPECT_EQ(off.model.effects(), 2u);
}

TEST(HidPid, SafetySwitchAndPowerAreFaults) {
  Stick stick;
  stick.hold(Vec3::Zero());
  stick.run(20, push(Vec3(0, 1, 0)));
  EXPECT_EQ(stick.sample.status, kDeviceOk);
  const auto status = [&] { return stick.run(5, push(Vec3(0, 1, 0))), stick.sample.status; };
  stick.model.holdSafetySwitch(false);
  EXPECT_EQ(status(), kDeviceDeadmanOpen);
  stick.model.holdSafetySwitch(true);
  EXPECT_EQ(status(), kDeviceOk);
  stick.model.power(false);
  EXPECT_EQ(status(), kDeviceError);
  stick.model.holdSafetySwitch(false);
  EXPECT_EQ(status(), kDeviceDeadmanOpen) << "it may be what cuts the power";
}

TEST(HidPid, NoFallbackStartsWhoseBoundTheDeviceDidNotTake) {
  constexpr int kSetCondition = 3;
  Stick stick;
  stick.hold(Vec3(0.02, 0.02, 0));
  stick.run(50, push(Vec3(1, 2, 0)));
  stick.model.refused = kSetCondition;  // Where it is now.
  stick.advance(13);                    // nobody commands
  EXPECT_EQ(stick.model.running(kConstant) + stick.model.running(kSpring) + stick.model.running(kDamper), 0);
  EXPECT_TRUE(stick.model.force().isZero(0)) << "a spring about another place would pull";
  stick.device->close();
  ASSERT_TRUE(stick.device->open().ok());
  EXPECT_FALSE(stick.io->hasFallback()) << "its force was never bounded";
}

TEST(HidPid, ADeviceWithoutRoomIsRefusedAndSaysSo) {
  Stick full({.pool = 1});
  ASSERT_FALSE(full.opened.ok());
  EXPECT_EQ(full.opened.error().code, ErrorCode::kQuotaExceeded);
  // Room for the forces alone: no fallback then.
  Stick enough({.pool = 2});
  ASSERT_TRUE(enough.opened.ok());
  EXPECT_FALSE(enough.io->hasFallback());
}

TEST(HidPid, ASlowBlockLoadIsWaitedForButNotForEver) {
  Stick stick;
  stick.device->close();
  stick.model.busy_polls = 59;
  EXPECT_TRUE(stick.device->open().ok());
  stick.device->close();
  stick.model.busy_polls = 60;
  const auto opened = stick.device->open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kTimeout);
}

TEST(HidPid, UnplugIsToldAndReplugPushesNotByItself) {
  Stick stick;
  stick.hold(Vec3::Zero());
  stick.run(20, push(Vec3(0, 1, 0)));
  stick.model.faults.add({haptic_emu::FaultKind::kUnplug, 0, INT64_MAX});
  stick.run(5, push(Vec3(0, 1, 0)));
  EXPECT_EQ(stick.sample.status, kDeviceGone);
  EXPECT_FALSE(stick.sample.fresh);
  stick.run(500, {});
  stick.model.faults.clear();
  stick.run(700, {});
  EXPECT_EQ(stick.sample.status, kDeviceOk);
  EXPECT_FALSE(stick.model.actuatorsOn());
  stick.run(20, push(Vec3(0, 1, 0)));
  EXPECT_NEAR(stick.model.force().y(), 1, 0.01);
}

/** It tells of buttons only when one changes. */
TEST(HidPid, TornReportsMoveNothing) {
  Stick stick;
  stick.hold(Vec3(0.01, 0.02, 0));
  stick.run(20, {});
  stick.model.faults.add({haptic_emu::FaultKind::kTruncation, 0, INT64_MAX});
  stick.hold(Vec3(-0.03, 0, 0));
  stick.run(100, {});
  EXPECT_NEAR((stick.sample.p - Vec3(0.01, 0.02, 0)).norm(), 0, 3e-6);
}

TEST(HidPid, ThePlayedDeviceTakesNoReportThatIsCutShort) {
  haptic_emu::PidModel model;
  const std::vector<std::uint8_t> create{5, 8, 0, 0};
  ASSERT_TRUE(model.setFeature(create));
  model.busy_polls = 0;
  int block = 0;
  for (int i = 0; i < 3; ++i) block = (*model.getFeature(6))[1];
  ASSERT_GT(block, 0);
  std::vector<std::uint8_t> condition(14);
  condition[0] = 3;
  condition[1] = static_cast<std::uint8_t>(block);
  for (std::size_t bytes = 1; bytes < condition.size() + 2; ++bytes) {
    std::vector<std::uint8_t> report = condition;
    report.resize(bytes);
    EXPECT_EQ(model.out(report), bytes == 15) << bytes;
  }
}

TEST(HidPid, AForceIsOnlyToldWhenItChanges) {
  Stick stick;
  stick.hold(Vec3::Zero());
  stick.run(100, push(Vec3(0, 1, 0)));
  const std::uint64_t before = stick.model.constants();
  stick.run(100, push(Vec3(0, 1, 0)));
  EXPECT_EQ(stick.model.constants(), before);
  for (int i = 0; i < 100; ++i) stick.run(1, push(Vec3(0, 0.01 * i, 0)));
  EXPECT_GE(stick.model.constants(), before + 98);  // as fast as the servo
}

TEST(HidPid, AForceThatWasNotTakenIsToldAgain) {
  constexpr int kSetConstant = 5;
  Stick stick;
  stick.hold(Vec3::Zero());
  stick.run(20, push(Vec3(0, 2, 0)));
  ASSERT_GT(stick.model.force().y(), 1.9);
  // The hand leaves a wall: zero, once and for all. The report is lost.
  stick.model.refused = kSetConstant;
  stick.run(3, push(Vec3::Zero()));
  stick.model.refused = 0;
  stick.run(5, push(Vec3::Zero()));
  EXPECT_TRUE(stick.model.force().isZero(0));
  // And one that is told after a refusal is told even where it is what the device had before.
  stick.run(5, push(Vec3(0, 2, 0)));
  stick.model.refused = kSetConstant;
  stick.run(1, push(Vec3(0, 3, 0)));
  stick.model.refused = 0;
  const std::uint64_t before = stick.model.constants();
  stick.run(5, push(Vec3(0, 2, 0)));
  EXPECT_EQ(stick.model.constants(), before + 1);
}

TEST(HidPid, ADeviceWhoseEffectsCannotBeBoundedIsRefused) {
  constexpr int kSetEffect = 1;
  Stick stick;
  stick.device->close();
  stick.model.refused = kSetEffect;
  const Result<void> opened = stick.device->open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
}

TEST(HidPid, OneWhoseActuatorsHaveNoSwitchIsStoppedAllTheSame) {
  for (const bool close : {false, true}) {
    Stick stick({.switches = false});
    ASSERT_TRUE(stick.opened.ok()) << toString(stick.opened.error());
    stick.hold(Vec3::Zero());
    stick.run(20, push(Vec3(0, 2, 0)));
    ASSERT_GT(stick.model.force().y(), 1.9);
    close ? stick.device->close() : stick.device->safe();
    EXPECT_EQ(stick.model.running(kConstant), 0) << "at once, not when its time is over";
    EXPECT_TRUE(stick.model.force().isZero(0));
  }
}

struct Maker {
  const char* name;
  PidVariant variant;
};
void PrintTo(const Maker& maker, std::ostream* out) { *out << maker.name; }  // Else its bytes, pointers among them.
class Makers : public testing::TestWithParam<Maker> {};
INSTANTIATE_TEST_SUITE_P(
    HidPid, Makers,
    testing::Values(Maker{"no_start_delay", {.start_delay = false}}, Maker{"no_block_offset", {.block_offset = false}},
                    Maker{"no_negative_coefficient", {.negative_coefficient = false}},
                    Maker{"no_dead_band", {.dead_band = false}}, Maker{"control_in_bits", {.control_in_bits = true}},
                    Maker{"no_conditions", {.conditions = false}}, Maker{"wheel", {.axes = 1}},
                    Maker{"hundredths", {.time_exponent = -2}}, Maker{"ten_thousandths", {.time_exponent = -4}}),
    [](const auto& each) { return each.param.name; });

TEST_P(Makers, IsDrivenByItsOwnDescriptor) {
  const PidVariant& variant = GetParam().variant;
  Stick stick(variant);
  ASSERT_TRUE(stick.opened.ok()) << toString(stick.opened.error());
  stick.hold(Vec3::Zero());
  stick.run(30, push(Vec3(0, -3, 0)));
  EXPECT_NEAR((stick.model.force() - Vec3(0, -3, 0)).norm(), 0, 0.01);
  EXPECT_EQ(stick.io->hasFallback(), variant.conditions);
  EXPECT_EQ(stick.model.longestDuration_ms(), variant.conditions ? HidPidIo::kFallback_ms : HidPidIo::kHold_ms);
  stick.die(HidPidIo::kHold_ms + 1);
  EXPECT_TRUE(stick.model.force().isZero(0));
  stick.run(3, {});
  EXPECT_FALSE(stick.model.actuatorsOn());

  const auto layout = pid::layoutOf(*HidReports::parse(haptic_emu::pidDescriptor(variant)));
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout.value().quirks.no_start_delay, !variant.start_delay);
  EXPECT_EQ(layout.value().quirks.control_in_bits, variant.control_in_bits);
  EXPECT_EQ(layout.value().quirks.no_block_offset, !variant.block_offset || !variant.conditions);
  EXPECT_EQ(layout.value().quirks.no_negative_coefficient, !variant.negative_coefficient || !variant.conditions);
  EXPECT_EQ(layout.value().quirks.no_dead_band, !variant.dead_band || !variant.conditions);
  EXPECT_EQ(layout.value().quirks.no_saturation, !variant.conditions);
  EXPECT_EQ(layout.value().axes, static_cast<std::size_t>(variant.axes));
}

TEST(HidPid, OneThatCannotCountATenthOfASecondIsRefused) {
  for (const int exponent : {0, -6}) {
    Stick stick({.time_exponent = exponent});
    ASSERT_FALSE(stick.opened.ok());
    EXPECT_NE(stick.opened.error().what.find("durations of 0.1 and 0.2 s"), std::string::npos);
  }
}

TEST(HidPid, WhatItNeedsAndADeviceHasNotIsNamed) {
  const struct {
    std::uint8_t usage;  // Of a report, which is taken for another.
    const char* name;
  } needed[] = {{0x21, "Set Effect"},
                {0x73, "Set Constant Force"},
                {0x77, "Effect Operation"},
                {0xab, "Create New Effect"},
                {0x89, "Block Load"}};
  for (const auto& [usage, name] : needed) {
    std::vector<std::uint8_t> bytes = haptic_emu::pidDescriptor({});
    // A collection of that usage, which takes two bytes from 0x80 on.
    const std::vector<std::uint8_t> report =
        usage < 0x80 ? std::vector<std::uint8_t>{0x09, usage, 0xa1} : std::vector<std::uint8_t>{0x0a, usage, 0, 0xa1};
    const auto at = std::search(bytes.begin(), bytes.end(), report.begin(), report.end());
    ASSERT_NE(at, bytes.end()) << name;
    at[1] = 0x01;
    const auto reports = HidReports::parse(bytes);
    ASSERT_TRUE(reports.ok());
    EXPECT_EQ(pid::hasForceFeedback(*reports), usage != 0x21 && usage != 0x73);
    const auto layout = pid::layoutOf(*reports);
    ASSERT_FALSE(layout.ok()) << name;
    EXPECT_NE(layout.error().what.find(std::string("lacks ") + name), std::string::npos) << layout.error().what;
  }
}

TEST(HidPid, AJoystickWithoutForceFeedbackIsNone) {
  const auto reports =
      HidReports::parse(std::vector<std::uint8_t>{0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x15, 0x00, 0x25, 0x7f, 0x75,
                                                  0x08, 0x95, 0x01, 0x09, 0x30, 0x81, 0x02, 0xc0});
  ASSERT_TRUE(reports.ok());
  EXPECT_FALSE(pid::hasForceFeedback(*reports));
  const auto layout = pid::layoutOf(*reports);
  ASSERT_FALSE(layout.ok());
  EXPECT_EQ(layout.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(layout.error().what.find("Set Effect"), std::string::npos);
}

}  // namespace
}  // namespace hapticd::test
