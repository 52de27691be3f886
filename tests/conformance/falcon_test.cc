// What the Falcon does of its own: its firmware, homing, lights, and who else holds it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/conformance/falcon_rig.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

using haptic_emu::FaultKind;
using ::testing::HasSubstr;

constexpr std::uint8_t kHome = 1, kGreen = 2, kBlue = 4, kRed = 8;

void run(FalconRig& rig, int cycles, const DeviceCommand& command, DeviceSample& sample) {
  for (int i = 0; i < cycles; ++i) {
    rig.device().read(rig.now(), sample);
    rig.device().write(rig.now(), command);
    rig.advance(kMs);
  }
}

/** A device of its own over the rig's played Falcon, with other firmware. */
std::unique_ptr<IoDevice> deviceWith(FalconRig& rig, std::vector<std::uint8_t> firmware) {
  FalconSetup setup = rig.setup;
  setup.read_firmware = [firmware] { return Result<std::vector<std::uint8_t>>(firmware); };
  return std::make_unique<IoDevice>(std::make_unique<FalconIo>(setup, rig.clock), IoOptions{.thread = false},
                                    rig.clock);
}

TEST(FalconFirmware, IsLoadedByteByByteIntoAColdDevice) {
  FalconRig rig;
  EXPECT_FALSE(rig.model.running());
  ASSERT_TRUE(rig.device().open().ok());
  EXPECT_TRUE(rig.model.running());
  EXPECT_EQ(rig.model.firmware(), *rig.setup.read_firmware());
  EXPECT_LT(rig.now(), 3000 * kMs) << "of the device's time";
}

TEST(FalconFirmware, OneThatRunsIsLeftAsItIsAndStaysHomed) {
  FalconRig rig;
  rig.model.warmUp();
  auto device = deviceWith(rig, {});
  ASSERT_TRUE(device->open().ok());
  EXPECT_TRUE(rig.model.homed());
  device->pump(rig.clock.now() + 20 * kMs);
  EXPECT_EQ(device->calibration(), Calibration::kDone);
}

TEST(FalconFirmware, WithoutItTheErrorSaysWhereToGetIt) {
  FalconRig rig;
  const auto opened = deviceWith(rig, {})->open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(toString(opened.error()), HasSubstr("not ours to ship"));
  EXPECT_THAT(toString(opened.error()), HasSubstr("firmware=/path"));
}

TEST(FalconFirmware, AFileThatCannotBeReadIsToldToADeviceThatNeedsIt) {
  const std::string loop = testing::TempDir() + "falcon_firmware_loop.bin";
  (void)::unlink(loop.c_str());
  ASSERT_EQ(::symlink(loop.c_str(), loop.c_str()), 0);
  FalconRig rig;
  FalconSetup setup = rig.setup;
  setup.read_firmware = [&] { return readFalconFirmware(loop); };
  const auto open = [&] {
    return IoDevice(std::make_unique<FalconIo>(setup, rig.clock), IoOptions{.thread = false}, rig.clock).open();
  };
  const auto refused = open();
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(toString(refused.error()), HasSubstr(loop));
  EXPECT_THAT(toString(refused.error()), HasSubstr("symbolic links"));
  rig.makeReady();
  rig.device().close();
  EXPECT_TRUE(open().ok());
  (void)::unlink(loop.c_str());
}

/** Its serial chip says meanwhile that there is nothing. */
TEST(FalconFirmware, IsLoadedIntoOneThatTakesItsTime) {
  FalconRig rig;
  rig.model.loader_thinks_ns = 100 * kMs;
  const auto opened = rig.device().open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  EXPECT_EQ(rig.model.uploads(), 1);
  EXPECT_EQ(rig.model.firmware(), *rig.setup.read_firmware());
}

TEST(FalconFirmware, AWrongEchoIsLoadedAgain) {
  FalconRig rig;
  // Wrong for a while in the middle of the first load.
  rig.model.faults.add({FaultKind::kWrongEcho, 300 * kMs, 500 * kMs});
  const auto opened = rig.device().open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  EXPECT_GT(rig.model.uploads(), 1);
  EXPECT_EQ(rig.model.firmware(), *rig.setup.read_firmware());
}

TEST(FalconFirmware, OneThatIsAlwaysWrongIsGivenUpInTime) {
  FalconRig rig;
  rig.model.faults.add({FaultKind::kWrongEcho, 0, INT64_MAX});
  const auto opened = rig.device().open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(toString(opened.error()), HasSubstr("echo of firmware byte 0 of 3000"));
  EXPECT_LT(rig.clock.now(), 11'000 * kMs);
}

TEST(FalconFirmware, ADeadDeviceIsGivenUpInTime) {
  FalconRig rig;
  rig.model.faults.add({FaultKind::kSilence, 0, INT64_MAX});
  const auto opened = rig.device().open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(toString(opened.error()), HasSubstr("power supply"));
  EXPECT_LT(rig.clock.now(), 11'000 * kMs);
}

TEST(FalconFirmware, UnpluggedMeanwhile) {
  FalconRig rig;
  rig.model.faults.add({FaultKind::kUnplug, 400 * kMs, INT64_MAX});
  const auto opened = rig.device().open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kDeviceGone);
}

TEST(FalconHoming, NoForceNorReadingBeforeAndLightsTell) {
  FalconRig rig;
  ASSERT_TRUE(rig.device().open().ok());
  EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  DeviceSample sample;
  run(rig, 100, push({1, 2, 3}), sample);
  EXPECT_FALSE(sample.fresh);
  EXPECT_EQ(rig.model.mostUnhomed(), 0);
  EXPECT_EQ(rig.model.lights(), kHome | kRed);
  rig.home();
  EXPECT_EQ(rig.device().calibration(), Calibration::kDone);
  run(rig, 5, {}, sample);
  EXPECT_EQ(rig.model.lights(), kBlue);
  run(rig, 5, push({0, 0, 1}), sample);
  EXPECT_EQ(rig.model.lights(), kGreen);
  EXPECT_TRUE(sample.fresh);
  EXPECT_EQ(rig.model.mostUnhomed(), 0);
}

TEST(FalconHoming, LostHomingIsAFaultAndPushesNotUntilHomedAgain) {
  FalconRig rig;
  rig.makeReady();
  DeviceSample sample;
  run(rig, 20, push({0, 0, 1}), sample);
  EXPECT_NE(rig.trueForce().norm(), 0);
  rig.model.loseHoming();
  run(rig, 5, push({0, 0, 1}), sample);
  EXPECT_NE(sample.status & kDeviceError, 0u);
  EXPECT_EQ(rig.trueForce().norm(), 0);
  EXPECT_EQ(rig.device().calibration(), Calibration::kNeeded);
  rig.home();
  run(rig, 5, push({0, 0, 1}), sample);
  EXPECT_EQ(sample.status, kDeviceOk);
}

TEST(FalconButtons, AreFour) {
  FalconRig rig;
  rig.makeReady();
  DeviceSample sample;
  for (const std::uint8_t buttons : {1, 2, 4, 8, 15, 0}) {
    rig.model.buttons = buttons;
    run(rig, 5, {}, sample);
    EXPECT_EQ(sample.buttons, buttons);
  }
}

// A slipped encoder: what it says stays wrong, so it is a fault once, and then the truth.
TEST(FalconEncoder, AJumpThatStaysIsAFault) {
  FalconRig rig;
  rig.makeReady();
  DeviceSample sample;
  run(rig, 20, {}, sample);
  rig.trouble(Trouble::kEncoderJump, true);
  run(rig, 50, push({0, 0, 1}), sample);
  EXPECT_NE(sample.status & kDeviceError, 0u);
  EXPECT_EQ(rig.trueForce().norm(), 0);
}

// From end to end is less than an arm would have had time for in the ten milliseconds that make a fault.
TEST(FalconEncoder, AJumpWithinTheWorkspaceIsAFaultToo) {
  FalconRig rig;
  rig.makeReady();
  DeviceSample sample;
  rig.hold(Vec3(-0.035, 0, 0));
  run(rig, 100, {}, sample);
  ASSERT_NEAR(sample.p.x(), -0.035, 1e-3);
  rig.hold(Vec3(0.04, 0, 0));
  rig.model.hand.place({0, 0, 0.165});
  for (int i = 0; i < 30 && (sample.status & kDeviceError) == 0; ++i) {
    EXPECT_NEAR(sample.p.x(), -0.035, 1e-3) << "believed after " << i << " ms";
    run(rig, 1, push({0, 0, 1}), sample);
  }
  EXPECT_NE(sample.status & kDeviceError, 0u);
}

TEST(FalconEncoder, AHandThatMovesWhileNothingIsHeardIsBelieved) {
  FalconRig rig;
  rig.makeReady();
  DeviceSample sample;
  run(rig, 20, {}, sample);
  rig.trouble(Trouble::kSilence, true);
  rig.hold(Vec3(0.03, 0, 0));
  run(rig, 100, {}, sample);
  rig.trouble(Trouble::kSilence, false);
  for (int i = 0; i < 30; ++i) {
    run(rig, 1, {}, sample);
    EXPECT_EQ(sample.status & kDeviceError, 0u);
  }
  EXPECT_NEAR(sample.p.x(), 0.03, 1e-3);
}

TEST(FalconOwner, TheSecondIsToldAndTheFirstGoesOn) {
  FalconRig rig;
  rig.makeReady();
  const auto second = deviceWith(rig, {})->open();
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kDeviceBusy);
  DeviceSample sample;
  run(rig, 5, {}, sample);
  EXPECT_TRUE(sample.fresh);
}

// An exchange a millisecond: the answer of one is there before the next is asked for.
TEST(FalconRate, OneExchangeInOneTickOfTheLatencyTimer) {
  FalconRig rig;
  rig.makeReady();
  const std::uint64_t before = rig.model.orders();
  rig.advance(1000 * kMs);
  EXPECT_NEAR(static_cast<double>(rig.model.orders() - before), 1000, 60);
}

TEST(FalconSetup, UriNamesWhatIsPluggedAndWhatIsNotYet) {
  UsbFound one, two;
  one.path = "1-1";
  two.path = "1-2";
  two.serial = "FTX1";
  const auto uriOf = [&](std::string_view text) { return resolveFalcon(*parseDeviceUri(text), {one, two})->info.uri; };
  EXPECT_EQ(uriOf("falcon://default"), "falcon://1-1");
  EXPECT_EQ(uriOf("falcon://1-2"), "falcon://FTX1");
  EXPECT_EQ(uriOf("falcon://FTX1?counts_per_nm=9000&centre_z=0.125"), "falcon://FTX1?counts_per_nm=9000");
  EXPECT_EQ(uriOf("falcon://later"), "falcon://later");
  const auto wrong = resolveFalcon(*parseDeviceUri("falcon://default?firmwear=x"), {});
  ASSERT_FALSE(wrong.ok());
  EXPECT_THAT(toString(wrong.error()), HasSubstr("did you mean \"firmware\"?"));
}

UsbFound falconAt(const char* path, const char* serial) {
  UsbFound one;
  one.path = path;
  one.serial = serial;
  return one;
}

TEST(FalconSetup, TwoOfOneSerialNumberGoByTheirSockets) {
  const std::vector<UsbFound> all = {falconAt("1-1", "FTX0"), falconAt("1-2", "FTX0"), falconAt("1-3", "FTX1")};
  const auto uriOf = [&](const char* name) { return resolveFalcon({"falcon", name, {}}, all)->info.uri; };
  EXPECT_EQ(uriOf("1-1"), "falcon://1-1");
  EXPECT_EQ(uriOf("1-2"), "falcon://1-2");
  EXPECT_EQ(uriOf("1-3"), "falcon://FTX1");
  EXPECT_EQ(uriOf("FTX0"), "falcon://1-1");
}

TEST(FalconSetup, TheSameIsFoundAgainWhateverElseIsPluggedInByThen) {
  FalconName later("default");
  EXPECT_FALSE(later.choose({}).ok());
  EXPECT_EQ(later.choose({falconAt("1-3", "FTX1")})->path, "1-3");
  EXPECT_FALSE(later.choose({falconAt("1-1", "FTX0")}).ok()) << "any would have done the first time only";
  EXPECT_EQ(later.choose({falconAt("1-1", "FTX0"), falconAt("1-7", "FTX1")})->path, "1-7");
  FalconName twin("FTX1");
  EXPECT_EQ(twin.choose({falconAt("1-3", "FTX1")})->path, "1-3");
  EXPECT_EQ(twin.text(), "FTX1");
  EXPECT_EQ(twin.choose({falconAt("1-1", "FTX1"), falconAt("1-3", "FTX1")})->path, "1-3");
  EXPECT_EQ(twin.choose({falconAt("1-7", "FTX1")})->path, "1-7");
  EXPECT_EQ(twin.choose({falconAt("1-3", "FTX1"), falconAt("1-7", "FTX1")})->path, "1-7") << "where it was last";
}

TEST(FalconSetup, WhichOfThoseOfANameWasHeldNobodyKnowsOnceItsDaemonIsDead) {
  const std::vector<UsbFound> all = {falconAt("1-1", "FTX1"), falconAt("1-2", "FTX0"), falconAt("1-3", "FTX1"),
                                     falconAt("1-4", "")};
  const auto meant = [&](const char* name) {
    std::string paths;
    for (const UsbFound& one : falconsMeant(name, all)) paths += one.path + " ";
    return paths;
  };
  EXPECT_EQ(meant("FTX1"), "1-1 1-3 ") << "opened before its twin was plugged in";
  EXPECT_EQ(meant("1-3"), "1-3 ");
  EXPECT_EQ(meant("FTX0"), "1-2 ");
  EXPECT_EQ(meant("1-4"), "1-4 ");
  EXPECT_EQ(meant("default"), "1-1 1-2 1-3 1-4 ") << "opened before anything was plugged in";
  EXPECT_EQ(meant("FTX2"), "");
}

TEST(FalconSetup, TheLargestForceAndItsStepAreThoseOfTheScale) {
  const auto legs = falcon::legsAt(falcon::kMiddle);
  ASSERT_TRUE(legs);
  const Mat3 dt1_dp = falcon::jacobian(*legs);
  const double lever_m = falcon::torquesFor(dt1_dp, Vec3(0, 0, 1))->cwiseAbs().maxCoeff();  // Toward the operator.
  for (const double counts_per_nm : {1000.0, 5000.0, 10'000.0, 20'000.0, 40'000.0}) {
    FalconParameters parameters;
    parameters.counts_per_nm = counts_per_nm;
    const DeviceInfo info = falconInfo(parameters);
    const double most = falcon::kMostCounts / counts_per_nm / lever_m;
    EXPECT_LE(info.max_force, 8) << counts_per_nm;
    EXPECT_LT(info.max_force, most) << counts_per_nm;
    EXPECT_GT(info.max_force, std::min(7.9, 0.4 * most)) << counts_per_nm;
    // A count makes as much more along x as the motors make there than the force that is told.
    EXPECT_NEAR(info.force_resolution, most / falcon::kMostCounts * (8 / 16.0), 0.2 * info.force_resolution)
        << counts_per_nm;
  }
}

TEST(FalconSetup, AFileThatIsNoFirmwareIsRefused) {
  EXPECT_TRUE(readFalconFirmware("/nowhere/falcon.bin")->empty());
  const auto wrong = readFalconFirmware("/etc/hostname");
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace hapticd::test
