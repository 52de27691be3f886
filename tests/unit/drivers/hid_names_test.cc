// By which URIs the HID devices of a machine go.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/hid/enumerate.h"
#include "drivers/hidpid/hidpid_parameters.h"
#include "drivers/spacemouse/spacemouse_parameters.h"

namespace hapticd {
namespace {

using ::testing::HasSubstr;

/** Two with a serial number, one without. */
std::vector<HidFound> three() {
  std::vector<HidFound> all(3);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].path = "/dev/hidraw" + std::to_string(i);
    all[i].vendor = 0x046d;
    all[i].product = 0xc626;
  }
  all[0].serial = "A1";
  all[1].serial = "B2";
  return all;
}

std::string joystick(const std::string& authority, const std::string& path, const std::vector<HidFound>& plugged) {
  DeviceUri uri{"hidpid", authority, {{"max_force", "3"}}};
  if (!path.empty()) uri.query.emplace_back("path", path);
  const auto setup = resolveHidPid(uri, plugged);
  return setup ? setup->info.uri + " " + setup->info.serial : toString(setup.error());
}

std::string mouse(const std::string& authority, const std::string& path, const std::vector<HidFound>& plugged) {
  DeviceUri uri{"spacemouse", authority, {{"mode", "rate"}}};
  if (!path.empty()) uri.query.emplace_back("path", path);
  const auto setup = resolveSpaceMouse(uri, plugged);
  return setup ? setup->info.uri + " " + setup->info.serial : toString(setup.error());
}

TEST(HidNames, AllNamesOfADeviceAreOneUri) {
  for (const char* name : {"", "default", "A1"}) {
    EXPECT_EQ(joystick(name, "", three()), "hidpid://A1?max_force=3 A1") << name;
    EXPECT_EQ(mouse(name, "", three()), "spacemouse://A1?mode=rate A1") << name;
  }
  EXPECT_EQ(joystick("B2", "", three()), "hidpid://B2?max_force=3 B2");
  EXPECT_EQ(mouse("B2", "", three()), "spacemouse://B2?mode=rate B2");
}

TEST(HidNames, OneWithoutASerialNumberGoesByItsNode) {
  EXPECT_EQ(joystick("default", "/dev/hidraw2", three()), "hidpid://default?max_force=3&path=/dev/hidraw2 ");
  EXPECT_EQ(mouse("default", "/dev/hidraw2", three()), "spacemouse://default?mode=rate&path=/dev/hidraw2 ");
}

TEST(HidNames, OneThatIsNotThereKeepsTheNameItWasGiven) {
  for (const char* name : {"default", "C3"}) {
    EXPECT_EQ(joystick(name, "", {}), std::string("hidpid://") + name + "?max_force=3 ");
    EXPECT_EQ(mouse(name, "", {}), std::string("spacemouse://") + name + "?mode=rate ");
  }
}

TEST(HidNames, WhoIsNotThereIsToldWhoIs) {
  const auto none = choose(three(), {{}, "", "C3", "a joystick"});
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(toString(none.error()), HasSubstr("a joystick of serial number C3 is not plugged in"));
  EXPECT_THAT(toString(none.error()), HasSubstr("there are /dev/hidraw0 (A1), /dev/hidraw1 (B2), /dev/hidraw2 ()"));
}

/** What is taken for `was` where another of its kind, with a serial number, and `now` are plugged in. */
Result<HidFound> again(const HidFound& was, const HidFound& now) {
  return choose({three()[0], now}, {{}, "", "", "a joystick", was});
}

TEST(HidNames, ADeviceThatWasPulledIsFoundAgainInAnySocketByItsSerialNumber) {
  const HidFound was = three()[1];
  HidFound now = was;
  now.path = "/dev/hidraw9";
  now.socket = "/sys/1-7:1.0";
  EXPECT_EQ(again(was, now)->path, "/dev/hidraw9");
  const auto none = again(was, three()[2]);
  ASSERT_FALSE(none.ok()) << "another is not it";
  EXPECT_THAT(toString(none.error()), HasSubstr("another stands in the place of a joystick"));
  EXPECT_THAT(toString(none.error()), HasSubstr("of serial number B2"));
}

TEST(HidNames, OneWithoutASerialNumberIsFoundAgainOnlyWhereItWasAndIfItLooksTheSame) {
  HidFound was;
  was.path = "/dev/hidraw5";
  was.vendor = 0x1209;
  was.product = 0xffb0;
  was.manufacturer = "Makers";
  was.name = "Wheel";
  was.socket = "/sys/1-2:1.0";
  HidFound now = was;
  now.path = "/dev/hidraw6";  // The kernel counts on.
  now.instance = "0003:1209:FFB0.0008";
  EXPECT_EQ(again(was, now)->path, "/dev/hidraw6");
  const auto other = [&](auto&& change) {
    HidFound one = now;
    change(one);
    const auto found = again(was, one);
    return !found.ok() && toString(found.error()).find("into the socket where it was") != std::string::npos;
  };
  EXPECT_TRUE(other([](HidFound& one) { one.vendor = 0x1210; }));
  EXPECT_TRUE(other([](HidFound& one) { one.product = 0xffb1; }));
  EXPECT_TRUE(other([](HidFound& one) { one.manufacturer = "Others"; }));
  EXPECT_TRUE(other([](HidFound& one) { one.name = "Large wheel"; }));
  EXPECT_TRUE(other([](HidFound& one) { one.serial = "C3"; }));
  EXPECT_TRUE(other([](HidFound& one) { one.socket = "/sys/1-3:1.0"; }));
}

TEST(HidNames, OneThatWasNamedByItsNodeIsFoundInItsSocketUnderAnother) {
  for (const char* const serial : {"", "0001"}) {  // Which boards of one maker often share.
    HidFound left;
    left.path = "/dev/hidraw0";
    left.name = "Stick";
    left.serial = serial;
    left.socket = "/sys/1-2.1:1.0";
    HidFound right = left;
    right.path = "/dev/hidraw1";
    right.socket = "/sys/1-2.2:1.0";
    const HidWanted wanted{{}, right.path, "", "a joystick", right};
    EXPECT_EQ(choose({left, right}, wanted)->socket, right.socket);
    // Their hub was pulled, and they came back in another order.
    HidFound first = right, second = left;
    std::swap(first.path, second.path);
    EXPECT_EQ(choose({second}, wanted).ok(), *serial != 0) << "the other alone: a serial number goes for it";
    for (const auto& all : {std::vector{first, second}, {second, first}}) {
      const auto found = choose(all, wanted);
      ASSERT_TRUE(found.ok()) << toString(found.error());
      EXPECT_EQ(found->socket, right.socket) << serial;
    }
    HidFound elsewhere = right;
    elsewhere.path = "/dev/hidraw7";
    elsewhere.socket = "/sys/1-3:1.0";
    EXPECT_FALSE(choose({elsewhere}, wanted).ok()) << "neither its node nor its socket";
    // Where all have one, as by radio, the node tells them apart, and nothing else does.
    left.socket = right.socket = "/sys/devices/virtual/misc/uhid";
    const HidWanted by_radio{{}, right.path, "", "a joystick", right};
    EXPECT_EQ(choose({left, right}, by_radio)->path, right.path);
    EXPECT_FALSE(choose({left}, by_radio).ok());
  }
}

}  // namespace
}  // namespace hapticd
