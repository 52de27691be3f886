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
  const auto turned = [&](const Vec3& axis) {
    desk.run(50);
    return desk.sample.q.angularDistance(Quat(Eigen::AngleAxisd(0.7, axis)));
  };
  desk.model.push({0, 0, 0, 350, 0, 0});
  EXPECT_LT(turned(Vec3::UnitY()), 1e-9) << "about the axis to the right";
  desk.model.push({0, 0, 0, 0, 0, 350});
  EXPECT_LT(turned(-Vec3::UnitZ()), 1e-9) << "about the axis that points down";
  desk.model.push({});
  desk.run(50);
  EXPECT_TRUE(desk.sample.p.isZero(0));
}

TEST_P(BothLayouts, SilenceMeansAsBeforeAndSamplesGoOn) {
  Desk desk(GetParam());
  desk.run(20);
  const int fresh = desk.run(1000);  // nobody touches it
  EXPECT_GE(fresh, 240);
  EXPECT_LE(fresh, 251) << "every 4 ms";
  EXPECT_LE(std::abs(desk.clock.now() - desk.sample.t_ns), 5 * kMs);
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
  const LinkCounters& counters = desk.device->link().counters;
  EXPECT_GT(counters.dropped_bytes.load(), 30u);
  const std::uint64_t dropped = counters.dropped_bytes.load(), taken = counters.exchanges.load();
  desk.model.faults.clear();
  desk.run(100);
  EXPECT_EQ(counters.dropped_bytes.load(), dropped);
  EXPECT_GT(counters.exchanges.load(), taken) << "whole ones are counted apart";
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
  desk.model.push({-350, -350, 350, 0, 0, 0});
  desk.run(3000);
  EXPECT_EQ(desk.sample.p, Vec3(-0.08, -0.08, -0.08)) << "on every side";
  desk.model.push({});
  desk.device->close();
  ASSERT_TRUE(desk.device->open().ok());
  desk.run(20);
  EXPECT_TRUE(desk.sample.p.isZero(0)) << "opened anew it begins in the middle";
}

TEST(SpaceMouse, TurnsOnAsFastAsItIsTwistedAndNotThroughAPause) {
  SpaceMouseParameters parameters;
  parameters.mode = "rate";
  parameters.turn_speed = 0.5;
  CapPose pose(parameters);
  for (int i = 0; i < 100; ++i) pose.step({Vec3::Zero(), Vec3(0, 0.5, 0)}, 0.01);
  EXPECT_LT(pose.pose().q.angularDistance(Quat(Eigen::AngleAxisd(0.25, Vec3::UnitY()))), 1e-9);
  pose.step({Vec3::Zero(), Vec3(1, 0, 0)}, 0.1);
  EXPECT_LT(pose.pose().q.angularDistance(Quat(Eigen::AngleAxisd(0.05, Vec3::UnitX())) *
                                          Quat(Eigen::AngleAxisd(0.25, Vec3::UnitY()))),
            1e-9)
      << "about axes that stand";

  Desk desk(true, {{"mode", "rate"}, {"speed", "0.1"}, {"dead_zone", "0"}});
  desk.model.push({0, 350, 0, 0, 0, 0});
  desk.run(100);
  const double before = desk.sample.p.x();
  desk.clock.advance(10'000 * kMs);
  desk.run(10);
  EXPECT_GT(desk.sample.p.x(), before);
  EXPECT_LT(desk.sample.p.x(), before + 0.1 * 0.07) << "50 ms of the pause, and what came after it";
}

TEST(SpaceMouse, ReportsAreTakenWholeAndWithinWhatACapCanSay) {
  using spacemouse::Report;
  using Bytes = std::vector<std::uint8_t>;
  spacemouse::State state;
  const auto take = [&](const Bytes& report) { return spacemouse::take(report, state); };
  EXPECT_EQ(take({1, 0x5e, 1, 0xa2, 0xfe, 3, 0}), Report::kTranslation);
  EXPECT_EQ(state.axis, (std::array<std::int16_t, 6>{350, -350, 3, 0, 0, 0}));
  EXPECT_EQ(take({2, 4, 0, 0xfb, 0xff, 0x20, 3}), Report::kRotation);
  EXPECT_EQ(state.axis, (std::array<std::int16_t, 6>{350, -350, 3, 4, -5, 800})) << "800 is the most";
  EXPECT_EQ(take({1, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 0xe0, 0xfc}), Report::kBoth);
  EXPECT_EQ(state.axis, (std::array<std::int16_t, 6>{1, 2, 3, 4, 5, -800}));
  EXPECT_EQ(take({1, 7, 0, 8, 0, 9, 0, 14, 0, 15, 0, 6}), Report::kTranslation) << "its rotation is cut off";
  EXPECT_EQ(state.axis, (std::array<std::int16_t, 6>{7, 8, 9, 4, 5, -800}));
  EXPECT_EQ(take({3, 1, 2, 4, 0x88, 0xff}), Report::kButtons);
  EXPECT_EQ(state.buttons, 0x88040201u);
  EXPECT_EQ(take({3, 0x10}), Report::kButtons);
  EXPECT_EQ(state.buttons, 0x10u);
  EXPECT_EQ(take({0x17, 100}), Report::kBattery);

  const spacemouse::State was = state;
  for (const Bytes& none : {Bytes{},
                            {1},
                            {1, 1, 0, 2, 0, 3},
                            {2, 1, 0, 2, 0, 3},
                            {3},
                            {0x17},
                            {0x17, 101},
                            {4, 1},
                            {1, 0x21, 3, 0, 0, 0, 0},
                            {1, 0, 0, 0, 0, 0xdf, 0xfc},
                            {2, 0, 0, 0x21, 3, 0, 0},
                            {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x21, 3}}) {
    EXPECT_EQ(take(none), Report::kNone) << testing::PrintToString(none);
    EXPECT_EQ(state.axis, was.axis) << testing::PrintToString(none);
    EXPECT_EQ(state.buttons, was.buttons);
    EXPECT_EQ(state.battery_percent, 100);
  }
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
  EXPECT_NEAR(shift(-500), -1, 1e-12);
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
  desk.model.push({300, 0, 0, 0, 0, 0});
  desk.run(50);
  EXPECT_EQ(desk.device->batteryPercent(), -1) << "not told yet";
  desk.model.tellBattery(64);
  desk.run(10);
  EXPECT_EQ(desk.device->batteryPercent(), 64);
  desk.device->close();
  EXPECT_FALSE(desk.model.light());
}

TEST(SpaceMouse, KnowsItsFamilyAndNobodyElse) {
  const auto all = [](std::uint16_t vendor) {
    std::vector<int> products;
    for (int product = 0; product < 0x10000; ++product) {
      if (isSpaceMouse({.vendor = vendor, .product = static_cast<std::uint16_t>(product)})) products.push_back(product);
    }
    return products;
  };
  // As spacenavd lists them. Its own list of those without a cap: CadMice, keypads, keyboards.
  EXPECT_EQ(all(0x046d),
            (std::vector<int>{0xc603, 0xc605, 0xc606, 0xc621, 0xc623, 0xc625, 0xc626, 0xc627, 0xc628, 0xc629, 0xc62b}));
  EXPECT_EQ(all(0x256f),
            (std::vector<int>{0xc62e, 0xc62f, 0xc631, 0xc632, 0xc633, 0xc635, 0xc636, 0xc638, 0xc63a, 0xc652}));
  EXPECT_TRUE(all(0x256e).empty());
}

}  // namespace
}  // namespace hapticd::test
