// A device with force feedback that takes a report late, as one that hangs, for which the kernel waits five seconds, or
// not at once.
#include <gtest/gtest.h>

#include "drivers/hidpid/hidpid_io.h"
#include "drivers/link/io_device.h"
#include "tests/conformance/hid_that_hangs.h"
#include "tests/support/stepped/push.h"
#include "tests/support/time.h"
#include "tools/haptic-emu/hidpid/pid_model.h"

namespace hapticd::test {
namespace {

struct HungStick {
  HungStick() {
    auto resolved = resolveHidPid({"hidpid", "default", {{"max_force", "4"}}}, {});
    EXPECT_TRUE(resolved.ok());
    resolved->hid = [this] { return std::make_unique<HidThatHangs>(model, clock, hang); };
    device =
        std::make_unique<IoDevice>(std::make_unique<HidPidIo>(std::move(*resolved)), IoOptions{.thread = false}, clock);
    EXPECT_TRUE(device->open().ok());
    pushOn(20);
  }
  void pushOn(int cycles) { run(cycles, push(Vec3(0, 1, 0))); }
  void run(int cycles, const DeviceCommand& command) {
    for (int i = 0; i < cycles; ++i) {
      device->write(clock.now(), command);
      device->pump(clock.now() + kMs);
      model.advance(clock.now());
    }
  }
  void hangs(std::int64_t takes_ns) { hang = {true, takes_ns, 0, false}; }

  haptic_emu::PidModel model;
  ManualClock clock;
  HidThatHangs::Hang hang;
  std::unique_ptr<IoDevice> device;
};

TEST(HidPidHang, IsGoneAfterOneReportAndClosesWithOne) {
  HungStick stick;
  stick.hangs(5000 * kMs);
  stick.device->write(stick.clock.now(), push(Vec3(0, 2, 0)));
  stick.device->pump(stick.clock.now() + kMs);
  EXPECT_EQ(stick.hang.attempts, 1) << "each more is five seconds";
  DeviceSample sample;
  stick.device->read(stick.clock.now(), sample);
  EXPECT_NE(sample.status & kDeviceGone, 0u);
  HungStick closing;
  closing.hangs(5000 * kMs);
  closing.device->close();
  EXPECT_EQ(closing.hang.attempts, 1);
}

TEST(HidPidHang, IsNotOpenedForMinutes) {
  HungStick stick;
  stick.device->close();
  stick.hangs(5000 * kMs);
  const auto opened = stick.device->open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kDeviceGone);
  EXPECT_EQ(stick.hang.attempts, 1);
  stick.hang = {true, 5000 * kMs, 0, true};
  const auto asked = stick.device->open();
  ASSERT_FALSE(asked.ok()) << "it does not say where it keeps an effect";
  EXPECT_EQ(asked.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(stick.hang.attempts, 1);
}

TEST(HidPidHang, AReportThatIsRefusedAtOnceIsTriedAgain) {
  HungStick stick;
  stick.hangs(0);
  stick.pushOn(90);  // Within which the effect is started again.
  EXPECT_GT(stick.hang.attempts, 0);
  stick.hang.now = false;
  stick.pushOn(90);
  EXPECT_NEAR(stick.model.force().y(), 1, 0.02);
  DeviceSample sample;
  stick.device->read(stick.clock.now(), sample);
  EXPECT_EQ(sample.status & kDeviceGone, 0u);
}

TEST(HidPidRefusal, ZerosThatItRefusesAreNotOff) {
  HungStick stick;
  stick.hangs(0);
  for (int i = 0; i < 90; ++i) {
    if (i == 50) stick.hang.now = false;
    stick.run(1, {});
    ASSERT_TRUE(!stick.device->isOff() || stick.model.force().isZero(0)) << i;
  }
  EXPECT_TRUE(stick.device->isOff());
}

TEST(HidPidRefusal, ThatItsActuatorsAreOnOrOffIsToldAgain) {
  constexpr int kDeviceControl = 12;
  HungStick stick;
  ASSERT_TRUE(stick.model.actuatorsOn());
  stick.model.refused = kDeviceControl;
  stick.run(1, {});
  ASSERT_TRUE(stick.model.actuatorsOn());
  stick.model.refused = 0;
  stick.run(2, {});
  EXPECT_FALSE(stick.model.actuatorsOn());
  stick.model.refused = kDeviceControl;
  stick.pushOn(3);
  stick.model.refused = 0;
  ASSERT_FALSE(stick.model.actuatorsOn());
  stick.pushOn(100);
  EXPECT_NEAR(stick.model.force().y(), 1, 0.02) << "armed, and nothing felt";
  // One that never takes it, whose actuators have no switch, is not gone for that.
  stick.model.refused = kDeviceControl;
  stick.run(2000, {});
  stick.pushOn(2000);
  DeviceSample sample;
  stick.device->read(stick.clock.now(), sample);
  EXPECT_EQ(sample.status & kDeviceGone, 0u);
}

}  // namespace
}  // namespace hapticd::test
