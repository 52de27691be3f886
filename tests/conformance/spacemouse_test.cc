// The SpaceMouse before its driver: both layouts, what silence means, the button that holds a whole group.
#include <gtest/gtest.h>

#include "drivers/link/io_device.h"
#include "drivers/spacemouse/spacemouse_io.h"
#include "tests/support/time.h"
#include "tools/haptic-emu/in_process_hid.h"
#include "tools/haptic-emu/spacemouse/spacemouse_model.h"

namespace hapticd::test {
namespace {

struct Desk {
  explicit Desk(bool new_layout, std::vector<std::pair<std::string, std::string>> query = {}) : model(new_layout) {
    auto resolved = resolveSpaceMouse({"spacemouse", "default", std::move(query)}, {});
    EXPECT_TRUE(resolved.ok());
    resolved->hid = [this] { return std::make_unique<haptic_emu::InProcessHid>(model, clock); };
    auto io = std::make_unique<SpaceMouseIo>(std::move(*resolved));
    mouse = io.get();
    device = std::make_unique<IoDevice>(std::move(io), IoOptions{.thread = false}, clock);
    EXPECT_TRUE(device->open().ok());
  }
  /** A servo at 1 kHz; returns how many readings were fresh. */
  int run(int cycles) {
    int fresh = 0;
    for (int i = 0; i < cycles; ++i) {
      device->read(clock.now(), sample);
      fresh += sample.fresh ? 1 : 0;
      device->pump(clock.now() + kMs);
    }
    return fresh;
  }

  haptic_emu::SpaceMouseModel model;
  ManualClock clock;
  SpaceMouseIo* mouse = nullptr;
  std::unique_ptr<IoDevice> device;
  DeviceSample sample;
};

class BothLayouts : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(SpaceMouse, BothLayouts, testing::Bool(),
                         [](const auto& each) { return each.param ? "New" : "Old"; });

TEST_P(BothLayouts, TheToolIsWhereTheCapIsPushedTo) {
  Desk desk(GetParam(), {{"dead_zone", "0"}, {"travel", "0.07"}, {"turn", "0.7"}});
  desk.model.push({350, 0, 0, 0, 0, 0});  // to the right
  desk.run(50);
  EXPECT_NEAR((desk.sample.p - Vec3(0, 0.07, 0)).norm(), 0, 1e-12);
  desk.model.push({0, 175, -350, 0, 0, 0});  // half toward the user, all the way up
  desk.run(50);
  EXPECT_NEAR((desk.sample.p - Vec3(0.035, 0, 0.07)).norm(), 0, 1e-12);
  EXPECT_NEAR(desk.sample.q.angularDistance(Quat::Identity()), 0, 1e-9);
  desk.model.push({0, 0, 0, 0, 350, 0});  // about the axis toward the user: right-handed about x
  desk.run(50);
  EXPECT_NEAR((desk.sample.q * Vec3::UnitY() - Vec3(0, std::cos(0.7), std::sin(0.7))).norm(), 0, 1e-12);
  desk.model.push({});
  desk.run(50);
  EXPECT_TRUE(desk.sample.p.isZero(0));
}

TEST_P(BothLayouts, SilenceMeansAsBeforeAndSamplesGoOn) {
  Desk desk(GetParam());
  desk.run(20);
  EXPECT_GE(desk.run(1000), 240);  // nobody touches it
  EXPECT_EQ(desk.sample.status, kDeviceOk);
  desk.model.push({300, 0, 0, 0, 0, 0});
  desk.run(50);
  const Vec3 pushed = desk.sample.p;
  EXPECT_GT(pushed.y(), 0.01);
  desk.model.faults.add({haptic_emu::FaultKind::kSilence, 0, INT64_MAX});
  desk.run(200);
  EXPECT_EQ(desk.sample.p, pushed);
}

TEST_P(BothLayouts, TornReportsChangeNothing) {
  Desk desk(GetParam());
  desk.model.faults.add({haptic_emu::FaultKind::kTruncation, 0, INT64_MAX});
  desk.model.push({300, 300, 300, 300, 300, 300});
  desk.run(100);
  EXPECT_TRUE(desk.sample.p.isZero(0));
  EXPECT_GT(desk.device->link().counters.dropped_bytes.load(), 30u);
}

TEST(SpaceMouse, GoesOnAsFastAsItIsPushedAndStays) {
  Desk desk(true, {{"mode", "rate"}, {"speed", "0.1"}, {"dead_zone", "0"}, {"box", "0.08"}});
  desk.run(20);
  desk.model.push({0, 350, 0, 0, 0, 0});
  desk.run(500);
  EXPECT_NEAR(desk.sample.p.x(), 0.05, 0.003);
  desk.model.push({});
  desk.run(50);
  const Vec3 left = desk.sample.p;
  desk.run(500);
  EXPECT_EQ(desk.sample.p, left);
  desk.model.push({0, 350, 0, 0, 0, 0});
  desk.run(3000);
  EXPECT_EQ(desk.sample.p.x(), 0.08);  // its box
}

TEST(SpaceMouse, ARestlessCapIsStillInItsDeadZone) {
  const auto shift = [](std::int16_t counts) {
    spacemouse::State state;
    state.axis[0] = counts;
    return capDeflection(state, 0.1).shift.y();
  };
  EXPECT_EQ(shift(35), 0);
  EXPECT_EQ(shift(-35), 0);
  EXPECT_NEAR(shift(42), 7.0 / 315, 1e-12);  // from zero on, not with a jump
  EXPECT_NEAR(shift(-350), -1, 1e-12);
  EXPECT_NEAR(shift(500), 1, 1e-12);
}

TEST(SpaceMouse, ItsButtonHoldsTheWholeGroup) {
  Desk desk(false, {{"deadman", "2"}});
  desk.run(20);
  EXPECT_EQ(desk.sample.status, kGroupDeadmanOpen);
  desk.model.press(1);
  desk.run(20);
  EXPECT_EQ(desk.sample.status, kGroupDeadmanOpen) << "the other button";
  desk.model.press(2);
  desk.run(20);
  EXPECT_EQ(desk.sample.status, kDeviceOk);
  EXPECT_EQ(desk.sample.buttons, 2u);
  desk.model.press(0);
  desk.run(10);
  EXPECT_EQ(desk.sample.status, kGroupDeadmanOpen);
  // Pulled out while it was held: not held any more.
  desk.model.press(2);
  desk.run(20);
  ASSERT_EQ(desk.sample.status, kDeviceOk);
  desk.model.faults.add({haptic_emu::FaultKind::kUnplug, 0, INT64_MAX});
  desk.run(10);
  EXPECT_EQ(desk.sample.status, kDeviceGone | kGroupDeadmanOpen);
  desk.model.faults.clear();
  desk.run(1000);
  EXPECT_EQ(desk.sample.status, kGroupDeadmanOpen) << "what was held before the unplug is not held after it";
}

TEST(SpaceMouse, ShowsItsLightWhileItIsOpenAndTellsItsBattery) {
  Desk desk(true);
  EXPECT_TRUE(desk.model.light());
  EXPECT_EQ(desk.device->batteryPercent(), -1);
  desk.model.tellBattery(64);
  desk.run(10);
  EXPECT_EQ(desk.device->batteryPercent(), 64);
  desk.device->close();
  EXPECT_FALSE(desk.model.light());
}

TEST(SpaceMouse, KnowsItsFamilyAndNobodyElse) {
  EXPECT_TRUE(isSpaceMouse({.vendor = 0x046d, .product = 0xc626}));
  EXPECT_TRUE(isSpaceMouse({.vendor = 0x256f, .product = 0xc635}));
  EXPECT_FALSE(isSpaceMouse({.vendor = 0x256f, .product = 0xc650}));  // a CadMouse
  EXPECT_FALSE(isSpaceMouse({.vendor = 0x046d, .product = 0xc077}));  // a mouse
}

}  // namespace
}  // namespace hapticd::test
