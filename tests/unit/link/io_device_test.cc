// The link between servo and I/O thread, and the life of a device on it, with a scripted device behind.
#include "drivers/link/io_device.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <functional>
#include <thread>
#include <vector>

#include "tests/support/stepped/push.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

/** Answers once a millisecond of its clock; keeps what it was sent. */
struct Script {
  ManualClock clock;
  std::vector<DeviceCommand> sent;
  bool there = true;
  bool refuse = false;  ///< open() fails.
  int opened = 0, closed = 0;
  Calibration calibration = Calibration::kNotNeeded;
  std::function<void()> on_gone = [] {};                ///< Before the servo is told.
  std::vector<int> policy_of_open, policy_of_exchange;  ///< Scheduling of the thread that called.
  std::atomic<int> safed{0};
};

class ScriptedIo final : public DeviceIo {
 public:
  explicit ScriptedIo(Script& script) : script_(script) { info_.uri = "script://"; }
  const DeviceInfo& info() const noexcept override { return info_; }
  Calibration calibration() const noexcept override { return script_.calibration; }
  Result<void> open(const std::atomic<bool>&) override {
    ++script_.opened;
    script_.policy_of_open.push_back(sched_getscheduler(0) & ~SCHED_RESET_ON_FORK);
    if (script_.refuse || !script_.there) return Error{ErrorCode::kDeviceGone, "script", "not there", ""};
    return {};
  }
  std::uint32_t statusWhenGone() const noexcept override {
    script_.on_gone();
    return kDeviceGone;
  }
  void close() noexcept override { ++script_.closed; }
  bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override {
    script_.policy_of_exchange.push_back(sched_getscheduler(0) & ~SCHED_RESET_ON_FORK);
    if (!script_.there) return false;
    script_.clock.sleepUntil(std::min(until_ns, script_.clock.now() + kMs));
    DeviceSample sample;
    sample.t_ns = script_.clock.now();
    sample.p.x() = static_cast<double>(sample.t_ns);
    link.publish(sample);
    link.order(script_.clock.now(), [&](const DeviceCommand& command) { script_.sent.push_back(command); });
    return true;
  }
  void safe() noexcept override { ++script_.safed; }

 private:
  Script& script_;
  DeviceInfo info_;
};

struct Rig {
  Script script;
  IoDevice device{std::make_unique<ScriptedIo>(script), {.thread = false}, script.clock};
  DeviceSample sample;

  DeviceCommand push(double newtons) {
    DeviceCommand command;
    command.enabled = newtons != 0;
    command.force.x() = newtons;
    device.write(script.clock.now(), command);
    return command;
  }
  double run(std::int64_t ns) {
    device.pump(script.clock.now() + ns);
    return script.sent.empty() ? 0 : script.sent.back().force.x();
  }
  void read() { device.read(script.clock.now(), sample); }
};

TEST(IoDevice, SamplesGoUpOnceAndCommandsDown) {
  Rig rig;
  ASSERT_TRUE(rig.device.open().ok());
  rig.read();
  EXPECT_FALSE(rig.sample.fresh);
  rig.push(2);
  EXPECT_EQ(rig.run(kMs), 2);
  rig.read();
  EXPECT_TRUE(rig.sample.fresh);
  EXPECT_EQ(rig.sample.p.x(), 1e6);
  rig.read();
  EXPECT_FALSE(rig.sample.fresh);
  EXPECT_EQ(rig.sample.p.x(), 1e6) << "the rest stays as before";
}

TEST(DeviceLink, AFaultIsSeenThoughAReadingFollowsAtOnce) {
  DeviceLink link(10 * kMs);
  DeviceSample reading, sample;
  reading.p.x() = 0.25;
  link.publish(reading);
  link.publishStatus(kDeviceError);
  link.publish(reading);
  link.read(0, sample);
  EXPECT_TRUE(sample.fresh);
  EXPECT_EQ(sample.p.x(), 0.25);
  EXPECT_EQ(sample.status, kDeviceError);
  link.read(1, sample);
  EXPECT_FALSE(sample.fresh);
  link.publish(reading);
  link.read(2, sample);
  EXPECT_EQ(sample.status, kDeviceOk) << "told once";
  link.publishStatus(kDeviceGone);
  link.read(3, sample);
  EXPECT_FALSE(sample.fresh);
  EXPECT_EQ(sample.status, kDeviceGone);
  link.publish(reading);
  link.read(4, sample);
  EXPECT_EQ(sample.status, kDeviceOk);
}

TEST(IoDevice, ASilentServoLosesItsForceAfterTheStatedTime) {
  Rig rig;
  ASSERT_TRUE(rig.device.open().ok());
  rig.push(2);
  EXPECT_EQ(rig.run(10 * kMs), 2);
  EXPECT_EQ(rig.run(kMs), 0);
  EXPECT_FALSE(rig.script.sent.back().enabled);
  EXPECT_EQ(rig.device.link().counters.stale_commands.load(), 1u);
  rig.push(3);
  EXPECT_EQ(rig.run(kMs), 3);
}

TEST(IoDevice, SafeHoldsZeroUntilTheServoHasSwitchedOff) {
  Rig rig;
  ASSERT_TRUE(rig.device.open().ok());
  rig.push(2);
  EXPECT_EQ(rig.run(kMs), 2);
  rig.device.safe();
  EXPECT_EQ(rig.script.safed, 1);
  EXPECT_EQ(rig.run(kMs), 0);
  rig.push(2);
  EXPECT_EQ(rig.run(kMs), 0) << "a servo that still pushes does not undo it";
  rig.push(0);
  EXPECT_EQ(rig.run(kMs), 0);
  rig.push(2);
  EXPECT_EQ(rig.run(kMs), 2);
}

/** Its transfer takes its time; keeps what reached the device, in that order. */
class SlowIo final : public DeviceIo {
 public:
  const DeviceInfo& info() const noexcept override { return info_; }
  Result<void> open(const std::atomic<bool>&) override { return {}; }
  void close() noexcept override {}
  bool exchange(DeviceLink& link, std::int64_t) noexcept override {
    link.order(0, [this](const DeviceCommand& command) {
      if (!command.enabled) return;
      on_its_way_ = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      newtons_ = command.force.x();
    });
    return true;
  }
  void safe() noexcept override { newtons_ = 0; }

  std::atomic<bool> on_its_way_{false};
  std::atomic<double> newtons_{0};

 private:
  DeviceInfo info_;
};

// An order that the I/O thread had taken before reaches the device before safe()'s zeros, never after them.
TEST(IoDevice, SafeIsTheLastWordEvenOverAnOrderOnItsWay) {
  for (int round = 0; round < 5; ++round) {
    auto io = std::make_unique<SlowIo>();
    SlowIo& slow = *io;
    IoDevice device(std::move(io), {.in_flight_ns = 10'000'000'000});
    ASSERT_TRUE(device.open().ok());
    DeviceCommand push;
    push.enabled = true;
    push.force.x() = 2;
    device.write(0, push);
    while (!slow.on_its_way_) std::this_thread::yield();
    device.safe();
    device.close();
    EXPECT_EQ(slow.newtons_, 0);
  }
}

TEST(IoDevice, IsOffWhenItsThreadHasComeBackFromSendingZeros) {
  DeviceLink link(10 * kMs);
  const auto order = [&](bool off) {
    link.order(0, [&](const DeviceCommand&) { EXPECT_EQ(link.isOff(), off) << "while it is sent"; });
  };
  EXPECT_TRUE(link.isOff()) << "nothing has been sent yet";
  link.write(0, test::push(Vec3(2, 0, 0)));
  EXPECT_TRUE(link.isOff()) << "no thread has taken it";
  order(false);
  link.write(0, {});
  EXPECT_FALSE(link.isOff());
  order(false);
  order(true);
  EXPECT_TRUE(link.isOff());
  // Once it has gone and been let go of nothing is on its way.
  link.write(0, test::push(Vec3(2, 0, 0)));
  order(false);
  EXPECT_FALSE(link.isOff());
  link.lost();
  EXPECT_TRUE(link.isOff());
}

TEST(IoDevice, SafeGivesUpOnATransferThatIsStuck) {
  DeviceLink link(0);
  bool gone_out = true;
  link.order(0, [&](const DeviceCommand&) { gone_out = link.awaitSent(200'000); });
  EXPECT_FALSE(gone_out);
  EXPECT_TRUE(link.awaitSent(0));
}

TEST(IoDevice, UnplugIsToldAndReplugFound) {
  Rig rig;
  ASSERT_TRUE(rig.device.open().ok());
  rig.run(3 * kMs);
  rig.read();
  EXPECT_EQ(rig.sample.status, kDeviceOk);
  rig.script.there = false;
  rig.run(2000 * kMs);
  rig.read();
  EXPECT_FALSE(rig.sample.fresh);
  EXPECT_EQ(rig.sample.status, kDeviceGone);
  EXPECT_EQ(rig.script.opened, 1 + 3) << "every half second";
  EXPECT_EQ(rig.script.closed, 1 + 3);
  rig.script.there = true;
  rig.run(600 * kMs);
  rig.read();
  EXPECT_TRUE(rig.sample.fresh);
  EXPECT_EQ(rig.sample.status, kDeviceOk);
  EXPECT_EQ(rig.device.link().counters.replugs.load(), 1u);
}

// The driver itself forgets its calibration in close(), milliseconds after the servo has been told.
TEST(IoDevice, WhatIsToldToBeGoneIsNotCalibratedAnyMore) {
  Rig rig;
  std::vector<Calibration> when_told;
  rig.script.on_gone = [&] { when_told.push_back(rig.device.calibration()); };
  ASSERT_TRUE(rig.device.open().ok());
  for (const Calibration calibration : {Calibration::kDone, Calibration::kNotNeeded}) {
    rig.script.calibration = calibration;
    rig.script.there = true;
    rig.run(600 * kMs);
    EXPECT_EQ(rig.device.calibration(), calibration) << "as the driver says";
    rig.script.there = false;
    rig.run(kMs);
    rig.read();
    EXPECT_EQ(rig.sample.status, kDeviceGone);
  }
  EXPECT_EQ(when_told, (std::vector{Calibration::kNeeded, Calibration::kNotNeeded}));
}

// Who looks for a device reads sysfs for milliseconds: at priority 85 that would be taken from a servo.
TEST(IoDevice, LooksForAnUnpluggedDeviceWithoutPriority) {
  Rig rig;
  ASSERT_TRUE(rig.device.open().ok());
  bool allowed = false;
  std::thread([&] {
    allowed = becomeRealtime(1).ok();
    rig.run(3 * kMs);
    rig.script.there = false;
    rig.run(1200 * kMs);
    rig.script.there = true;
    rig.run(600 * kMs);
  }).join();
  if (!allowed) GTEST_SKIP() << "no right to real-time scheduling";
  ASSERT_EQ(rig.script.policy_of_open.size(), 1u + 2 + 1);
  for (const int policy : rig.script.policy_of_open) EXPECT_EQ(policy, SCHED_OTHER);
  EXPECT_EQ(rig.script.policy_of_exchange.front(), SCHED_FIFO);
  EXPECT_EQ(rig.script.policy_of_exchange.back(), SCHED_FIFO);
}

TEST(IoDevice, AFailedOpenGivesBackAndOpensLater) {
  Rig rig;
  rig.script.refuse = true;
  const Result<void> refused = rig.device.open();
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kDeviceGone);
  EXPECT_EQ(rig.script.closed, 1);
  rig.script.refuse = false;
  EXPECT_TRUE(rig.device.open().ok());
  rig.device.close();
  rig.device.close();
  EXPECT_EQ(rig.script.closed, 2);
}

/** Opens when it is told to stop, and not before. */
class EndlessIo final : public DeviceIo {
 public:
  const DeviceInfo& info() const noexcept override { return info_; }
  Result<void> open(const std::atomic<bool>& stop) override {
    opening = true;
    while (!stop) std::this_thread::yield();
    return Error{ErrorCode::kCancelled, "endless", "given up", ""};
  }
  void close() noexcept override {}
  bool exchange(DeviceLink&, std::int64_t) noexcept override { return true; }
  void safe() noexcept override {}
  std::atomic<bool> opening{false};

 private:
  DeviceInfo info_;
};

TEST(IoDevice, AnOpeningCanBeGivenUpAlsoBeforeItBegins) {
  for (const bool before : {false, true}) {
    auto io = std::make_unique<EndlessIo>();
    EndlessIo& endless = *io;
    IoDevice device(std::move(io));
    if (before) device.giveUp();
    std::thread other([&] {
      while (!before && !endless.opening) std::this_thread::yield();
      device.giveUp();
    });
    EXPECT_EQ(device.open().error().code, ErrorCode::kCancelled);
    other.join();
  }
}

TEST(IoDevice, WhatWasCommandedBeforeItWasClosedIsOver) {
  Rig rig;
  ASSERT_TRUE(rig.device.open().ok());
  rig.push(2);
  rig.device.close();
  ASSERT_TRUE(rig.device.open().ok());
  EXPECT_EQ(rig.run(kMs), 0);
}

/** A device on a real thread that takes its time as a blocking library does. */
class SpinningIo final : public DeviceIo {
 public:
  const DeviceInfo& info() const noexcept override { return info_; }
  Result<void> open(const std::atomic<bool>&) override { return {}; }
  void close() noexcept override {}
  bool exchange(DeviceLink& link, std::int64_t) noexcept override {
    DeviceSample sample;
    sample.p = Vec3::Constant(static_cast<double>(++count_));
    link.publish(sample);
    link.order(0, [this](const DeviceCommand& command) {
      torn_ = torn_ || command.force.x() != command.force.y() || command.force.y() != command.force.z();
    });
    return true;
  }
  void safe() noexcept override {}
  bool torn_ = false;

 private:
  DeviceInfo info_;
  std::uint64_t count_ = 0;
};

TEST(IoDevice, ServoAndThreadNeverTearEachOthersValues) {
  auto io = std::make_unique<SpinningIo>();
  SpinningIo& spinning = *io;
  IoDevice device(std::move(io));
  ASSERT_TRUE(device.open().ok());
  DeviceSample sample;
  int fresh = 0;
  double last = 0;
  for (int i = 0; fresh < 2000; ++i) {
    device.write(0, test::push(Vec3::Constant(i)));
    device.read(0, sample);
    if (!sample.fresh) continue;
    ++fresh;
    ASSERT_EQ(sample.p.x(), sample.p.z());
    ASSERT_GT(sample.p.x(), last);
    last = sample.p.x();
  }
  device.close();
  EXPECT_FALSE(spinning.torn_);
}

}  // namespace
}  // namespace hapticd
