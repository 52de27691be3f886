// The real hidapi and libudev over umockdev's kernel, with played devices behind: how they are found, opened and spoken
// to.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/hid/enumerate.h"
#include "drivers/hid/hidraw_transport.h"
#include "drivers/registry.h"
#include "rt/base/clock.h"
#include "tests/support/time.h"
#include "tests/umockdev/hidraw_testbed.h"
#include "tools/haptic-emu/hidpid/pid_model.h"
#include "tools/haptic-emu/spacemouse/spacemouse_model.h"
#include "tools/haptic-emu/woodyhid/woody_hid_model.h"

namespace hapticd::test {
namespace {

const HidIdentity kMouse{0x256f, 0xc631, "3Dconnexion", "SpaceMouse Pro Wireless", "EMU7"};

/** Reads until `done`, for at most five seconds. */
template <class Done>
bool served(Device& device, DeviceSample& sample, Done done, const DeviceCommand& command = {}) {
  MonotonicClock clock;
  for (int i = 0; i < 5000; ++i) {
    device.read(clock.now(), sample);
    device.write(clock.now(), command);
    if (done()) return true;
    clock.sleepUntil(clock.now() + kMs);
  }
  return false;
}

void expectCapIsHeard(Device& device, HidrawTestbed& bed, haptic_emu::SpaceMouseModel& model) {
  const auto opened = device.open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  {
    const auto held = bed.hold();
    model.push({350, 0, 0, 0, 0, 0});
  }
  DeviceSample sample;
  EXPECT_TRUE(served(device, sample, [&] { return sample.p.y() > 0.01; })) << sample.p.transpose();
  device.close();
}

TEST(Umockdev, ASpaceMouseIsFoundByUdevAndItsCapMovesTheTool) {
  haptic_emu::SpaceMouseModel model(true);
  HidrawTestbed bed(model, kMouse);
  const auto found = findHid();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].path, HidrawTestbed::kNode);
  EXPECT_EQ(found[0].name, "SpaceMouse Pro Wireless");
  EXPECT_EQ(found[0].serial, "EMU7");
  EXPECT_EQ(found[0].descriptor, model.descriptor());
  EXPECT_EQ(found[0].instance, "0003:256F:C631.0007");
  EXPECT_EQ(found[0].socket, "/sys/devices/pci0000:00/0000:00:14.0/usb1/1-2/1-2:1.0");

  auto device = makeDevice("spacemouse://EMU7");
  ASSERT_TRUE(device.ok()) << toString(device.error());
  EXPECT_EQ((*device)->info().serial, "EMU7");
  expectCapIsHeard(**device, bed, model);
}

TEST(Umockdev, OfTheInterfacesOfAReceiverTheOneWithTheCapIsTaken) {
  const auto application = [](std::uint8_t usage) {  // Of the generic desktop page, with a byte to tell.
    return haptic_emu::HidModel::Bytes{0x05, 0x01, 0x09, usage, 0xa1, 0x01, 0x09, 0x30, 0x15, 0x00,
                                       0x25, 0x7f, 0x75, 0x08,  0x95, 0x01, 0x81, 0x02, 0xc0};
  };
  haptic_emu::SpaceMouseModel model(true);
  HidrawTestbed bed(model, {0x256f, 0xc652, "3Dconnexion", "Universal Receiver", ""},
                    {application(6), application(2), application(0)});
  ASSERT_EQ(findHid().size(), 4u);
  std::vector<std::string> listed;
  for (const DeviceFound& found : findDevices()) {
    if (found.info.driver == "spacemouse") listed.push_back(found.info.uri);
  }
  EXPECT_THAT(listed, ::testing::ElementsAre("spacemouse://default"));
  const auto device = makeDevice("spacemouse://default");
  ASSERT_TRUE(device.ok()) << toString(device.error());
  expectCapIsHeard(**device, bed, model);
}

TEST(Umockdev, AWoodenHapticsArmIsHeardAndSpokenTo) {
  haptic_emu::WoodyHidModel model(haptic_emu::WoodyKind::kWooden2015);
  HidrawTestbed bed(model, {0x16c0, 0x0486, "Teensyduino", "WoodenHaptics", "W1"});
  auto device = makeDevice("woodyhid://woodenhaptics_v2015");
  ASSERT_TRUE(device.ok()) << toString(device.error());
  const auto opened = (*device)->open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  DeviceSample sample;
  EXPECT_TRUE(served(**device, sample, [&] {
    const auto held = bed.hold();
    return model.heard() > 20 && model.said() > 20;
  }));
  (*device)->close();
}

TEST(Umockdev, AJoystickIsSetUpByFeatureReportsAndPushes) {
  haptic_emu::PidModel model;
  HidrawTestbed bed(model, {0x1209, 0xffb0, "OpenFFBoard", "Joystick", "P1"});
  model.hand.want({0.01, 0.01, 0});  // It is read when it has moved.
  const auto other = makeDevice("hidpid://P2?max_force=4");
  ASSERT_TRUE(other.ok());
  EXPECT_THAT((*other)->open().error().remedy, ::testing::StrEq("there are /dev/hidraw7 (P1)"));
  auto device = makeDevice("hidpid://P1?max_force=4");
  ASSERT_TRUE(device.ok()) << toString(device.error());
  const auto opened = (*device)->open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  {
    const auto held = bed.hold();
    EXPECT_GT(model.effects(), 0u) << "their places are told by feature reports";
  }
  DeviceSample sample;
  ASSERT_TRUE(served(**device, sample, [&] { return sample.fresh; }));
  DeviceCommand push;
  push.enabled = true;
  push.force.y() = 2;
  EXPECT_TRUE(served(
      **device, sample,
      [&] {
        const auto held = bed.hold();
        return model.force().norm() > 1.9;
      },
      push));
  (*device)->close();
  const auto held = bed.hold();
  EXPECT_FALSE(model.actuatorsOn());
  EXPECT_EQ(model.force().norm(), 0);
}

TEST(Umockdev, OneDeviceIsListedOnceByWhateverNameItIsOpen) {
  // hidapi lists a joystick once as a joystick and once as its pointer.
  haptic_emu::PidModel model;
  HidrawTestbed bed(model, {0x1209, 0xffb0, "OpenFFBoard", "Joystick", "P1"});
  std::vector<std::string> listed;
  for (const DeviceFound& found : findDevices()) {
    if (found.info.driver == "hidpid") listed.push_back(found.info.uri);
  }
  EXPECT_THAT(listed, ::testing::ElementsAre("hidpid://P1"));
  for (const char* name : {"hidpid://default", "hidpid://P1", "P1"}) {
    const auto device = makeDevice(name);
    ASSERT_TRUE(device.ok()) << toString(device.error());
    EXPECT_EQ((*device)->info().uri, "hidpid://P1") << name;
  }
}

TEST(Umockdev, AJoystickSaysHowManyButtonsAndAxesItHas) {
  for (const int axes : {1, 2}) {
    haptic_emu::PidVariant variant;
    variant.axes = axes;
    haptic_emu::PidModel model(variant);
    HidrawTestbed bed(model, {0x1209, 0xffb0, "OpenFFBoard", "Joystick", "P1"});
    const auto device = makeDevice("hidpid://default?travel=0.04");
    ASSERT_TRUE(device.ok()) << toString(device.error());
    const DeviceInfo& info = (*device)->info();
    EXPECT_EQ(info.buttons, 8u);
    EXPECT_EQ(info.workspace_upper, Vec3(axes == 2 ? 0.04 : 0, 0.04, 0)) << "a wheel moves along y alone";
    EXPECT_EQ(info.workspace_lower, Vec3(-info.workspace_upper));
  }
}

TEST(Umockdev, TheSecondOnANodeIsToldThatItIsTaken) {
  haptic_emu::SpaceMouseModel model(true);
  HidrawTestbed bed(model, kMouse);
  const auto first = makeDevice("spacemouse://default"), second = makeDevice("spacemouse://default");
  ASSERT_TRUE(first.ok() && second.ok());
  ASSERT_TRUE((*first)->open().ok());
  const auto refused = (*second)->open();
  EXPECT_EQ(refused.error().code, ErrorCode::kDeviceBusy) << toString(refused.error());
  (*first)->close();
  EXPECT_TRUE((*second)->open().ok()) << "close gives it back";
  (*second)->close();
}

TEST(Umockdev, WhatStandsInThePlaceOfADeviceThatWasPulledIsNotTaken) {
  haptic_emu::PidModel model;
  const HidIdentity stick{0x1209, 0xffb0, "OpenFFBoard", "Joystick", ""};
  HidIdentity wheel = stick;
  wheel.name = "Wheel";
  HidrawTransport hid({{}, "", "", "a joystick"});
  for (const auto& [stands, taken] : {std::pair{stick, true}, {wheel, false}, {stick, true}}) {
    HidrawTestbed bed(model, stands);
    const auto opened = hid.open();
    EXPECT_EQ(opened.ok(), taken) << stands.name;
    EXPECT_THAT(opened ? "" : toString(opened.error()),
                ::testing::HasSubstr(taken ? "" : "another stands in the place"));
    hid.close();
  }
  std::unique_ptr<Device> device;
  {
    HidrawTestbed bed(model, stick);
    auto made = makeDevice("hidpid://default");
    ASSERT_TRUE(made.ok());
    device = std::move(*made);
  }
  HidrawTestbed bed(model, wheel);
  EXPECT_FALSE(device->open().ok()) << "it was told with the buttons and axes of another";
  device->close();
}

TEST(Umockdev, NothingIsFoundWhereNothingIs) {
  UMockdevTestbed* bed = umockdev_testbed_new();
  EXPECT_TRUE(findHid().empty());
  const auto device = makeDevice("woodyhid://woodenhaptics_v2015");
  ASSERT_TRUE(device.ok()) << "it may be plugged in later";
  EXPECT_FALSE((*device)->open().ok());
  g_object_unref(bed);
}

}  // namespace
}  // namespace hapticd::test
