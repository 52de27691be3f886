// What WoodenHaptics and Polhem do of their own: taking turns, the button of calibration, the watchdog in the device.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "drivers/hid/hidraw_transport.h"
#include "tests/conformance/hid_that_hangs.h"
#include "tests/conformance/woody_rig.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

using haptic_emu::WoodyKind;

int run(WoodyRig& rig, int cycles, const DeviceCommand& command, DeviceSample& sample) {
  int fresh = 0;
  for (int i = 0; i < cycles; ++i) {
    rig.device().read(rig.now(), sample);
    fresh += sample.fresh ? 1 : 0;
    rig.device().write(rig.now(), command);
    rig.advance(kMs);
  }
  return fresh;
}

TEST(WoodyIo, SpeaksWhenSpokenToAndNeverTwice) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.makeReady();
  const std::uint64_t heard = rig.model.heard(), said = rig.model.said();
  rig.advance(1000 * kMs);
  EXPECT_NEAR(static_cast<double>(rig.model.said() - said), 1000, 10);
  EXPECT_LE(rig.model.heard() - heard, rig.model.said() - said + 1);
  EXPECT_LE(rig.model.longestQueue(), 1u);
}

TEST(WoodyIo, TakesTheNewestOfManyReports) {
  WoodyRig rig(WoodyKind::kWooden2015);
  haptic_emu::InProcessHid hid(rig.model, rig.clock);
  ASSERT_TRUE(hid.open().ok());
  // Spoken to three times without being listened to: three reports wait, each with another fourth encoder.
  for (const std::int16_t turn : {100, 200, 300}) {
    rig.model.gimbal[0] = turn;
    ASSERT_EQ(hid.write(std::vector<std::uint8_t>(15)), HidResult::kOk);
    rig.advance(2 * kMs);
  }
  std::array<std::uint8_t, 64> buffer{};
  std::size_t size = 0;
  ASSERT_EQ(readNewest(hid, buffer, size, rig.now()), HidResult::kOk);
  EXPECT_EQ(buffer[6] + 256 * buffer[7], 300);
  EXPECT_EQ(readNewest(hid, buffer, size, rig.now()), HidResult::kNothing);
}

TEST(WoodyIo, TheFirstBoardsTakeFourteenBytes) {
  WoodyRig rig(WoodyKind::kWooden2015, 14);
  rig.makeReady();
  DeviceSample sample;
  EXPECT_GT(run(rig, 100, {}, sample), 90);
}

/** Stops whoever opens it in the middle: when it is open, and its reports are not known yet. */
class HidAmidOpen final : public HidTransport {
 public:
  explicit HidAmidOpen(std::function<void()>& amid, std::vector<std::size_t>& last_words)
      : amid_(amid), last_words_(last_words) {}
  Result<void> open() override { return {}; }
  void close() noexcept override {}
  const std::vector<std::uint8_t>& descriptor() const noexcept override {
    amid_();
    return descriptor_;
  }
  std::int64_t now() const noexcept override { return now_ns_; }
  HidResult read(std::span<std::uint8_t>, std::size_t&, std::int64_t until_ns) noexcept override {
    now_ns_ = until_ns;
    return HidResult::kNothing;
  }
  HidResult write(std::span<const std::uint8_t>) noexcept override { return HidResult::kOk; }
  HidResult setFeature(std::span<const std::uint8_t>) noexcept override { return HidResult::kRefused; }
  HidResult getFeature(std::span<std::uint8_t>, std::size_t&) noexcept override { return HidResult::kRefused; }
  void lastWords(std::span<const std::uint8_t> report) noexcept override { last_words_.push_back(report.size()); }

 private:
  std::function<void()>& amid_;
  std::vector<std::size_t>& last_words_;
  std::vector<std::uint8_t> descriptor_;
  std::int64_t now_ns_ = 0;
};

TEST(WoodyIo, LastWordsAreWholeHoweverEarlyTheyCome) {
  std::function<void()> amid;
  std::vector<std::size_t> last_words;
  auto setup = resolveWoody({"woodyhid", "", {}});
  ASSERT_TRUE(setup.ok());
  setup->hid = [&] { return std::make_unique<HidAmidOpen>(amid, last_words); };
  WoodyIo io(std::move(*setup));
  amid = [&] { io.safe(); };
  EXPECT_FALSE(io.open(std::atomic<bool>{false}).ok());
  EXPECT_EQ(last_words, std::vector<std::size_t>{1 + woodyhid::kReportBytes});
}

TEST(WoodyIo, SomethingElseOnSuchABoardIsNotTaken) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.model.faults.add({haptic_emu::FaultKind::kSilence, 0, INT64_MAX});
  const Result<void> opened = rig.device().open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kTimeout);
  EXPECT_NE(opened.error().remedy.find("serial="), std::string::npos);
}

TEST(WoodyFound, OfBothKindsOfBoardsAndNotTheConsoleBesideThem) {
  HidFound found;
  const auto may_be = [&](std::uint16_t vendor, std::uint16_t product, std::uint16_t usage_page) {
    found.vendor = vendor, found.product = product, found.usage_page = usage_page;
    return mayBeWoody(found);
  };
  EXPECT_TRUE(may_be(0x16c0, 0x0486, 0xffab)) << "Teensy, RawHID";
  EXPECT_FALSE(may_be(0x16c0, 0x0486, 0xffc9)) << "what it prints";
  EXPECT_FALSE(may_be(0x16c0, 0x0483, 0xffab)) << "Teensy, a serial line";
  EXPECT_TRUE(may_be(0x1234, 0x0006, 0xffab)) << "mbed LPC1768";
  EXPECT_FALSE(may_be(0x1234, 0x0486, 0xffab));
  EXPECT_FALSE(may_be(0x16c0, 0x0006, 0xffab));
}

TEST(WoodyIo, NeitherPlaceNorForceBeforeCalibration) {
  WoodyRig rig(WoodyKind::kWooden2015);
  ASSERT_TRUE(rig.device().open().ok());
  EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  DeviceSample sample;
  EXPECT_EQ(run(rig, 100, push(Vec3(0, 0, 3)), sample), 0);
  EXPECT_TRUE(rig.model.force().isZero(0));
  rig.calibrate();
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
  EXPECT_FALSE(rig.model.pressed());
  EXPECT_GT(run(rig, 50, push(Vec3(0, 0, 3)), sample), 40);
  EXPECT_NEAR(rig.model.force().z(), 3, 0.05);
}

TEST(WoodyIo, APressFromBeforeTheStartIsWiped) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.model.pressCalibration();
  ASSERT_TRUE(rig.device().open().ok());
  rig.advance(50 * kMs);
  EXPECT_FALSE(rig.model.pressed());
  EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  rig.calibrate();
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
}

TEST(WoodyIo, CountersThatAreHeardLateAreNotTakenBack) {
  WoodyRig rig(WoodyKind::kWooden2015);
  ASSERT_TRUE(rig.device().open().ok());
  rig.model.behind = true;
  rig.calibrate();
  ASSERT_EQ(rig.device().calibration(), Calibration::kDone);
  EXPECT_FALSE(rig.model.pressed());
  DeviceSample sample;
  EXPECT_GT(run(rig, 50, {}, sample), 40);
  EXPECT_LT((sample.p - rig.truePosition()).norm(), 2e-4);
}

TEST(WoodyIo, CountersThatAreNotHeardAreToldAgain) {
  WoodyRig rig(WoodyKind::kWooden2015);
  ASSERT_TRUE(rig.device().open().ok());
  rig.model.deaf_to_counters = 1;
  rig.calibrate();
  ASSERT_EQ(rig.device().calibration(), Calibration::kDone);
  DeviceSample sample;
  EXPECT_GT(run(rig, 50, {}, sample), 40);
  EXPECT_LT((sample.p - rig.truePosition()).norm(), 2e-4);
}

TEST(WoodyIo, OneThatIsUnpluggedBeforeItHasHeardThemIsNotCalibrated) {
  WoodyRig rig(WoodyKind::kWooden2015);
  ASSERT_TRUE(rig.device().open().ok());
  rig.model.deaf_to_counters = 1000;
  rig.calibrate();
  ASSERT_EQ(rig.device().calibration(), Calibration::kRunning);
  rig.unplug();
  rig.advance(20 * kMs);
  rig.plugIn();
  DeviceSample sample;
  run(rig, 1000, {}, sample);
  EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  EXPECT_FALSE(sample.fresh);
}

TEST(WoodyIo, AHandThatMovesWhileNothingIsHeardIsBelieved) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.makeReady();
  rig.hold(Vec3(0, -0.08, 0));
  rig.trouble(Trouble::kSilence, true);
  rig.hold(Vec3(0, 0.08, 0));  // for 200 ms
  rig.trouble(Trouble::kSilence, false);
  DeviceSample sample;
  EXPECT_GT(run(rig, 50, {}, sample), 30);
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
  EXPECT_LT((sample.p - rig.truePosition()).norm(), 2e-4);
}

TEST(WoodyIo, APressWhileTheMotorsAreOnMovesNothing) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.makeReady();
  rig.hold(Vec3(0.02, 0.01, 0));
  DeviceSample sample;
  run(rig, 20, push(Vec3(0, 1, 0)), sample);
  rig.model.pressCalibration();
  run(rig, 50, push(Vec3(0, 1, 0)), sample);
  EXPECT_LT((sample.p - Vec3(0.02, 0.01, 0)).norm(), 2e-4);
  EXPECT_NEAR(rig.model.force().y(), 1, 0.03);
  run(rig, 50, {}, sample);  // off: the press is wiped, the place stays
  EXPECT_FALSE(rig.model.pressed());
  EXPECT_LT((sample.p - Vec3(0.02, 0.01, 0)).norm(), 3e-4);
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
}

TEST(WoodyIo, NorIsThePlaceLostIfTheHandMovesWhileThatPressIsWiped) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.makeReady();
  rig.model.behind = true;
  rig.hold(Vec3(0, -0.08, 0));
  DeviceSample sample;
  run(rig, 20, push(Vec3(0, 1, 0)), sample);
  rig.model.pressCalibration();
  run(rig, 20, push(Vec3(0, 1, 0)), sample);
  rig.device().write(rig.now(), {});
  rig.hold(Vec3(0, 0.08, 0));  // at 0.8 m/s, and the motors are off
  run(rig, 50, {}, sample);
  EXPECT_FALSE(rig.model.pressed());
  EXPECT_LT((sample.p - rig.truePosition()).norm(), 2e-4);
}

TEST(WoodyIo, CountersOfAnEarlierSessionServeIfTheUserSaysSo) {
  WoodyRig rig(WoodyKind::kWooden2015, 64, "calibrated");
  ASSERT_TRUE(rig.device().open().ok());
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
  // But not for ever: unplugged it loses its power, and counts from wherever it gets it back.
  DeviceSample sample;
  run(rig, 50, {}, sample);
  rig.unplug();
  run(rig, 100, {}, sample);
  rig.hold(Vec3(0.03, 0.02, 0));
  rig.plugIn();
  EXPECT_EQ(run(rig, 1000, push(Vec3(0, 0, 2)), sample), 0) << "a reading by counters that mean nothing";
  EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  EXPECT_TRUE(rig.model.force().isZero(0));
  rig.calibrate();
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
}

/** Opened anew, as when it was closed: a device object of its own. Whether it counts as calibrated. */
bool calibratedAnew(WoodyRig& rig) {
  WoodyIo again(rig.setup);
  EXPECT_TRUE(again.open(std::atomic<bool>{false}).ok());
  return again.calibration() == Calibration::kDone;
}

TEST(WoodyIo, TheUsersWordHoldsUntilTheDeviceIsUnpluggedWhoeverOpensIt) {
  WoodyRig rig(WoodyKind::kWooden2015, 64, "calibrated");
  DeviceSample sample;
  ASSERT_TRUE(rig.device().open().ok());
  run(rig, 50, {}, sample);
  rig.device().close();
  EXPECT_TRUE(calibratedAnew(rig)) << "it had its power all the while";
  rig.unplug();
  run(rig, 10, {}, sample);  // While nobody has it open.
  rig.plugIn();
  EXPECT_FALSE(calibratedAnew(rig));
  EXPECT_FALSE(calibratedAnew(rig)) << "and not the second time";
  ASSERT_TRUE(rig.device().open().ok());
  EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  rig.calibrate();
  rig.device().close();
  EXPECT_TRUE(calibratedAnew(rig)) << "its counters were set since";
  ASSERT_TRUE(rig.device().open().ok());
  rig.unplug();
  run(rig, 10, {}, sample);
  rig.device().close();
  rig.plugIn();
  EXPECT_FALSE(calibratedAnew(rig));
}

TEST(WoodyIo, NorDoesItHoldOnceItWasSeenThatCountsWereLost) {
  WoodyRig rig(WoodyKind::kWooden2015, 64, "calibrated");
  rig.makeReady();
  DeviceSample sample;
  run(rig, 50, {}, sample);
  rig.trouble(Trouble::kEncoderJump, true);
  run(rig, 50, {}, sample);
  ASSERT_EQ(rig.device().calibration(), Calibration::kNeeded);
  rig.trouble(Trouble::kEncoderJump, false);
  rig.device().close();
  EXPECT_FALSE(calibratedAnew(rig));
}

TEST(WoodyIo, NorOnceItHasHungOrWasClosedBeforeItHeardNewCounters) {
  DeviceSample sample;
  {
    WoodyRig rig(WoodyKind::kWooden2015, 64, "calibrated");
    ASSERT_TRUE(rig.device().open().ok());
    run(rig, 50, {}, sample);
    rig.model.refuses = 1'000'000;
    run(rig, 300, {}, sample);
    ASSERT_NE(sample.status & kDeviceGone, 0u);
    rig.model.refuses = 0;
    EXPECT_EQ(run(rig, 1000, {}, sample), 0) << "it was never unplugged, and may have begun anew";
    EXPECT_EQ(rig.link().counters.replugs.load(), 1u);
    EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  }
  WoodyRig rig(WoodyKind::kWooden2015, 64, "calibrated");
  ASSERT_TRUE(rig.device().open().ok());
  run(rig, 50, {}, sample);
  rig.model.deaf_to_counters = 1'000'000;
  rig.model.pressCalibration();
  run(rig, 20, {}, sample);
  ASSERT_EQ(rig.device().calibration(), Calibration::kRunning);
  rig.device().close();
  EXPECT_FALSE(calibratedAnew(rig)) << "which of the two it counts by nobody knows";
}

TEST(WoodyCounters, OneThatWasSeenBeforeHasLostThemAndAnotherHasNot) {
  WoodyCounters counters;
  const auto first = counters.of({"16c0:0486 A", "1"});
  EXPECT_FALSE(first->lost.load());
  EXPECT_EQ(counters.of({"16c0:0486 A", "1"}), first);
  EXPECT_TRUE(counters.of({"16c0:0486 A", "2"})->lost.load());
  EXPECT_FALSE(counters.of({"16c0:0486 B", "3"})->lost.load());
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(counters.of({"16c0:0486 A", std::to_string(4 + i)})->lost.load());
  EXPECT_TRUE(counters.of({"16c0:0486 A", ""})->lost.load()) << "nobody knows since when";
  EXPECT_FALSE(counters.of({"16c0:0486 B", "3"})->lost.load());
  EXPECT_FALSE(counters.of({"16c0:0486 C", ""})->lost.load());
  EXPECT_TRUE(counters.of({"16c0:0486 C", ""})->lost.load()) << "it may have been unplugged in between";
}

TEST(WoodyCounters, OneBesideItsLikeIsAnotherAndOneInItsPlaceMayBeIt) {
  HidFound board;
  board.vendor = 0x16c0;
  board.product = 0x0486;
  const auto plugged = [&](const std::string& one, const std::vector<std::string>& all) {
    std::vector<HidFound> found;
    for (const std::string& instance : all) found.emplace_back(board).instance = instance;
    board.instance = one;
    return pluggedAmong(found, board);
  };
  WoodyCounters counters;
  EXPECT_FALSE(counters.of(plugged("7", {"7", "8"}))->lost.load());
  EXPECT_FALSE(counters.of(plugged("8", {"7", "8"}))->lost.load()) << "two boards, each with the user's word";
  EXPECT_TRUE(counters.of(plugged("9", {"7", "9"}))->lost.load()) << "the second, plugged in again";
  EXPECT_TRUE(counters.of(plugged("10", {"10"}))->lost.load());
  EXPECT_FALSE(counters.of(plugged("7", {"7", "8"}))->lost.load());
  EXPECT_TRUE(counters.of(plugged("", {"7", ""}))->lost.load());
}

TEST(WoodyCounters, OneThatComesAndGoesForEverTakesNoMoreAndMoreMemory) {
  WoodyCounters counters;
  std::vector<std::weak_ptr<WoodyPlugged>> all;
  for (int i = 0; i < 1000; ++i) all.push_back(counters.of({"16c0:0486 A", std::to_string(i)}));
  EXPECT_LE(std::count_if(all.begin(), all.end(), [](const auto& one) { return !one.expired(); }), 20);
  EXPECT_FALSE(all.back().expired()) << "of it the last word counts";
}

TEST(WoodyIo, OneThatHangsHoldsItsClosingUpOnceAndOneThatRefusesIsToldThrice) {
  for (const auto& [takes_ns, attempts] : {std::pair{5000 * kMs, 1}, {std::int64_t{0}, WoodyIo::kZeros}}) {
    WoodyRig rig(WoodyKind::kWooden2015);
    HidThatHangs::Hang hang{false, takes_ns, 0, false};
    rig.setup.hid = [&] { return std::make_unique<HidThatHangs>(rig.model, rig.clock, hang); };
    WoodyIo io(rig.setup);
    ASSERT_TRUE(io.open(std::atomic<bool>{false}).ok());
    hang.now = true;
    io.close();
    EXPECT_EQ(hang.attempts, attempts) << takes_ns;
    io.close();
  }
}

TEST(WoodyIo, AReportThatItRefusesIsALostCommandAndNoUnplug) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.model.refuses = 1;
  rig.makeReady();
  rig.hold(Vec3::Zero());
  DeviceSample sample;
  run(rig, 20, push(Vec3(0, 1, 0)), sample);
  const std::uint64_t lost = rig.link().counters.lost.load();
  rig.model.refuses = 1;
  for (int i = 0; i < 100; ++i) {
    run(rig, 1, push(Vec3(0, 1, 0)), sample);
    ASSERT_EQ(sample.status & kDeviceGone, 0u) << i;
  }
  EXPECT_EQ(rig.link().counters.replugs.load(), 0u);
  // The command, and the answer that did not come for it.
  EXPECT_EQ(rig.link().counters.lost.load() - lost, 2u);
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
  EXPECT_NEAR(rig.model.force().y(), 1, 0.03);
}

TEST(WoodyIo, OneThatRefusesAllIsGone) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.makeReady();
  DeviceSample sample;
  rig.model.refuses = 1'000'000;
  run(rig, 150, {}, sample);
  EXPECT_EQ(sample.status & kDeviceGone, 0u);
  run(rig, 100, {}, sample);
  EXPECT_NE(sample.status & kDeviceGone, 0u);
}

TEST(WoodyIo, ZerosThatItRefusesAreNotOff) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.makeReady();
  rig.hold(Vec3::Zero());
  DeviceSample sample;
  run(rig, 20, push(Vec3(0, 1, 0)), sample);
  rig.model.refuses = 3;
  for (int i = 0; i < 100; ++i) {
    run(rig, 1, {}, sample);
    ASSERT_TRUE(!rig.device().isOff() || rig.model.force().isZero(0)) << i;
  }
  EXPECT_TRUE(rig.device().isOff());
  run(rig, 20, push(Vec3(0, 1, 0)), sample);
  ASSERT_GT(rig.model.force().y(), 0.9);
  rig.model.refuses = 2;
  rig.device().close();
  EXPECT_TRUE(rig.model.force().isZero(0));
}

TEST(WoodyIo, TheDevicesOwnWatchdogOutlivesThisProcess) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.makeReady();
  rig.hold(Vec3::Zero());
  DeviceSample sample;
  run(rig, 20, push(Vec3(0, 0, 2)), sample);
  ASSERT_NEAR(rig.model.force().z(), 2, 0.05);
  // SIGKILL: nobody writes any more, the motors keep what they were told ...
  rig.clock.advance(499 * kMs);
  rig.model.advance(rig.clock.now());
  EXPECT_TRUE(rig.model.amplifiersOn());
  // ... for half a second.
  rig.clock.advance(2 * kMs);
  rig.model.advance(rig.clock.now());
  EXPECT_FALSE(rig.model.amplifiersOn());
  EXPECT_TRUE(rig.model.force().isZero(0));
}

TEST(WoodyIo, CarriesItsLinksByWhatTheyWeigh) {
  WoodyRig rig(WoodyKind::kWooden2015);
  rig.makeReady();
  rig.hold(Vec3::Zero());
  DeviceSample sample;
  run(rig, 20, {}, sample);
  // Up, and less than all it weighs.
  EXPECT_GT(sample.gravity.z(), 0.2);
  EXPECT_LT(sample.gravity.norm(), 9.81 * 0.28 + 1e-9);
  EXPECT_NEAR(sample.gravity.y(), 0, 0.02);
}

TEST(WoodyIo, TheStylusButtonAndTheGimbalAreRead) {
  WoodyRig rig(WoodyKind::kPolhem3);
  rig.makeReady();
  rig.hold(Vec3::Zero());
  DeviceSample sample;
  run(rig, 20, {}, sample);
  EXPECT_EQ(sample.buttons, 0u);
  const Quat before = sample.q;
  rig.model.button = true;
  rig.model.gimbal[2] = static_cast<std::int16_t>(rig.model.gimbal[2] + 256);
  run(rig, 20, {}, sample);
  EXPECT_EQ(sample.buttons, 1u);
  EXPECT_NEAR(before.angularDistance(sample.q), 3.14159265358979 / 2, 1e-3);
  EXPECT_LT((sample.p).norm(), 2e-4);
}

TEST(WoodyIo, AnUnknownModelIsRefusedWithTheKnownOnes) {
  const auto setup = resolveWoody({"woodyhid", "polhem_v2", {}});
  ASSERT_FALSE(setup.ok());
  EXPECT_EQ(setup.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(setup.error().remedy.find("polhem_v3"), std::string::npos);
  EXPECT_EQ(resolveWoody({"woodyhid", "", {}})->info.uri, "woodyhid://woodenhaptics_v2015");
}

}  // namespace
}  // namespace hapticd::test
