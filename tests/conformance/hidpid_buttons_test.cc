// Buttons of a joystick or wheel with force feedback: they are told, and start nothing.
#include "tests/conformance/hidpid_stick.h"

namespace hapticd::test {
namespace {

TEST(HidPid, NoButtonStartsAnythingInTheDevice) {
  Stick stick;
  stick.hold(Vec3(0.02, 0.03, 0));
  for (int button = 0; button < 8; ++button) {
    stick.model.buttons = static_cast<std::uint8_t>(1 << button);
    for (int i = 0; i < 20; ++i) {
      stick.run(1, push(Vec3::Zero()));
      ASSERT_TRUE(stick.model.force().isZero(0)) << "button " << button + 1;
    }
  }
}

TEST(HidPid, WhatWasHeldWhenItWasUnpluggedIsNotHeldForEver) {
  Stick stick({.buttons_apart = true});
  ASSERT_TRUE(stick.opened.ok()) << toString(stick.opened.error());
  stick.hold(Vec3(0.01, 0, 0));
  stick.model.buttons = 2;
  stick.run(20, {});
  ASSERT_EQ(stick.sample.buttons, 2u);
  ASSERT_NEAR((stick.sample.p - Vec3(0.01, 0, 0)).norm(), 0, 3e-6);
  stick.model.faults.add({haptic_emu::FaultKind::kUnplug, 0, INT64_MAX});
  stick.run(500, {});
  stick.model.buttons = 0;
  stick.model.faults.clear();
  stick.run(700, {});
  ASSERT_EQ(stick.sample.status, kDeviceOk);
  EXPECT_EQ(stick.sample.buttons, 0u);
}

}  // namespace
}  // namespace hapticd::test
