// The link between two processes, with both ends here: what a torn, dead or lying other side can do.
#include "drivers/vendor/shared_link.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "tests/support/time.h"

namespace hapticd {
namespace {

struct Ends {
  Ends() { memory.generation = 1; }
  DeviceCommand ordered(std::int64_t now_ns) {
    DeviceCommand out;
    device.order(now_ns, [&](const DeviceCommand& command) { out = command; });
    return out;
  }
  void push(std::int64_t now_ns, double newtons) {
    DeviceCommand command;
    command.enabled = newtons != 0;
    command.force.x() = newtons;
    command.torque.y() = 2 * newtons;
    command.gripper_force = 3 * newtons;
    servo.write(now_ns, command);
  }
  SharedLinkMemory memory{};
  SharedServoEnd servo{memory};
  SharedDeviceEnd device{memory, 1, 10 * kMs};
  DeviceSample sample;
};

TEST(SharedLink, IsOffWhenAReadingAnswersZeros) {
  Ends ends;
  EXPECT_TRUE(ends.servo.isOff());
  const auto reading = [&](std::int64_t now_ns) {
    ends.device.publish(DeviceSample{});
    ends.servo.read(now_ns, ends.sample);
    return ends.servo.isOff();
  };
  ends.push(1, 2);
  (void)ends.ordered(2);
  ends.push(3, 0);
  ends.push(4, 0);
  EXPECT_FALSE(ends.servo.isOff());
  EXPECT_FALSE(reading(5)) << "the helper has not taken the order";
  ends.device.order(5, [](const DeviceCommand&) { return false; });
  EXPECT_FALSE(reading(5)) << "nor has the device, of which the helper wants nothing else";
  (void)ends.ordered(6);
  EXPECT_FALSE(ends.servo.isOff());
  EXPECT_TRUE(reading(7));
  ends.push(8, 2);
  EXPECT_FALSE(ends.servo.isOff()) << "the helper may have it at any time";
}

TEST(SharedLink, SamplesGoUpOnceAndOrdersDown) {
  Ends ends;
  ends.servo.read(0, ends.sample);
  EXPECT_FALSE(ends.sample.fresh);
  DeviceSample reading;
  reading.t_ns = 5;
  reading.p = Vec3(1, 2, 3);
  reading.q = Quat(Eigen::AngleAxisd(1, Vec3::UnitY()));
  reading.gripper_rad = 0.25;
  reading.buttons = 6;
  reading.status = kDeviceSaturated;
  ends.device.publish(reading);
  ends.servo.read(10, ends.sample);
  EXPECT_TRUE(ends.sample.fresh);
  EXPECT_EQ(ends.sample.t_ns, 5);
  EXPECT_EQ(ends.sample.p, reading.p);
  EXPECT_LT(ends.sample.q.angularDistance(reading.q), 1e-12);
  EXPECT_EQ(ends.sample.gripper_rad, 0.25);
  EXPECT_EQ(ends.sample.buttons, 6u);
  EXPECT_EQ(ends.sample.status, kDeviceSaturated);
  ends.servo.read(11, ends.sample);
  EXPECT_FALSE(ends.sample.fresh);
  ends.push(20, 2);
  const DeviceCommand command = ends.ordered(21);
  EXPECT_TRUE(command.enabled);
  EXPECT_EQ(command.force, Vec3(2, 0, 0));
  EXPECT_EQ(command.torque, Vec3(0, 4, 0));
  EXPECT_EQ(command.gripper_force, 6);
}

TEST(SharedLink, ASilentServoLosesItsForceAndSafeHoldsZero) {
  Ends ends;
  ends.push(0, 2);
  EXPECT_TRUE(ends.ordered(10 * kMs).enabled);
  EXPECT_FALSE(ends.ordered(10 * kMs + 1).enabled);
  ends.push(20 * kMs, 2);
  ends.servo.safe();
  EXPECT_FALSE(ends.ordered(20 * kMs).enabled);
  ends.push(21 * kMs, 2);
  EXPECT_FALSE(ends.ordered(21 * kMs).enabled) << "a servo that still pushes does not undo it";
  ends.push(22 * kMs, 0);
  ends.push(23 * kMs, 2);
  EXPECT_TRUE(ends.ordered(23 * kMs).enabled);
}

TEST(SharedLink, AnOrderFromTheFutureIsNone) {
  Ends ends;
  ends.push(100 * kMs, 2);
  EXPECT_FALSE(ends.ordered(50 * kMs).enabled);
}

// A helper that hung, was given up and comes back to life.
TEST(SharedLink, AnOlderHelperNeitherSpeaksNorPushes) {
  Ends ends;
  ends.memory.generation = 2;
  ends.device.publish({});
  ends.servo.read(0, ends.sample);
  EXPECT_FALSE(ends.sample.fresh);
  ends.push(0, 2);
  EXPECT_FALSE(ends.ordered(0).enabled);
}

TEST(SharedLink, AReadingThatNoDeviceGivesIsADeviceErrorAndNotFresh) {
  for (int kind = 0; kind < 4; ++kind) {
    Ends ends;
    DeviceSample bad;
    if (kind == 0) bad.p.y() = std::numeric_limits<double>::quiet_NaN();
    if (kind == 1) bad.q.coeffs().setZero();
    if (kind == 2) bad.gripper_rad = std::numeric_limits<double>::infinity();
    if (kind == 3) bad.q.w() = std::numeric_limits<double>::quiet_NaN();
    ends.device.publish(bad);
    ends.servo.read(0, ends.sample);
    EXPECT_FALSE(ends.sample.fresh) << kind;
    EXPECT_NE(ends.sample.status & kDeviceError, 0u) << kind;
    EXPECT_TRUE(ends.sample.p.allFinite());
  }
}

TEST(SharedLink, AHelperIsNoDeadManSwitchOfItsGroupAndTimeIsNotAheadOfTheServo) {
  Ends ends;
  DeviceSample sample;
  sample.status = kGroupDeadmanOpen | 1u << 20;
  sample.t_ns = 1000;
  ends.device.publish(sample);
  ends.servo.read(10, ends.sample);
  EXPECT_EQ(ends.sample.status, kDeviceOk);
  EXPECT_EQ(ends.sample.t_ns, 10);
  sample.t_ns = std::numeric_limits<std::int64_t>::min();
  ends.device.publish(sample);
  ends.servo.read(10, ends.sample);
  EXPECT_EQ(ends.sample.t_ns, 0) << "nor so far back that a difference overflows";
  ends.device.publishStatus(kDeviceOk);
  ends.servo.read(11, ends.sample);
  EXPECT_FALSE(ends.sample.fresh);
  EXPECT_NE(ends.sample.status & kDeviceError, 0u);
}

// Whoever dies in the middle of a write leaves silence, and who comes after it can write again.
TEST(SharedLink, AFaultIsSeenThoughReadingsFollowAtOnce) {
  Ends ends;
  ends.device.publishStatus(kDeviceError);
  for (int i = 0; i < 10; ++i) ends.device.publish(DeviceSample{});
  ends.servo.read(10, ends.sample);
  EXPECT_TRUE(ends.sample.fresh);
  EXPECT_EQ(ends.sample.status, kDeviceError);
  for (int i = 0; i < 20; ++i) ends.device.publish(DeviceSample{});
  ends.servo.read(11, ends.sample);
  EXPECT_EQ(ends.sample.status, kDeviceOk);
}

TEST(SharedLink, ADeadWriterIsSilenceAndTheNextIsHeard) {
  SharedBox<SharedOrder> box;
  SharedOrder order{};
  std::uint32_t seen = 0;
  order.t_ns = 1;
  box.put(order);
  auto* const version = reinterpret_cast<std::atomic<std::uint32_t>*>(&box);
  version->store(3);
  EXPECT_EQ(box.take(order, seen), Taken::kBusy);
  order.t_ns = 2;
  box.put(order);
  ASSERT_EQ(box.take(order, seen), Taken::kNew);
  EXPECT_EQ(order.t_ns, 2);
  EXPECT_EQ(box.take(order, seen), Taken::kSame);
}

// The order that is being written may come after one that was off, which the device then never saw.
TEST(SharedLink, AnOrderThatIsBeingWrittenIsZerosAndNotTheOneBefore) {
  Ends ends;
  ends.push(1, 2);
  ASSERT_TRUE(ends.ordered(2).enabled);
  auto* const version = reinterpret_cast<std::atomic<std::uint32_t>*>(&ends.memory.down);
  const std::uint32_t whole = version->load();
  version->store(whole + 1);
  EXPECT_FALSE(ends.ordered(3).enabled);
  EXPECT_EQ(ends.device.counters.stale_commands, 1u);
  version->store(whole);
  EXPECT_TRUE(ends.ordered(4).enabled);
}

TEST(SharedLink, NoReaderEverSeesATornValue) {
  SharedBox<SharedSample> box;
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    SharedSample sample{};
    for (std::int64_t i = 1; !stop; ++i) {
      sample.t_ns = sample.answers_ns = i;
      for (double& x : sample.p) x = static_cast<double>(i);
      for (double& x : sample.q) x = static_cast<double>(i);
      box.put(sample);
    }
  });
  SharedSample sample{};
  std::uint32_t seen = 0;
  std::int64_t last = 0;
  for (int taken = 0; taken < 1000;) {
    if (box.take(sample, seen) != Taken::kNew) continue;
    ++taken;
    ASSERT_EQ(sample.t_ns, sample.answers_ns);
    ASSERT_EQ(static_cast<double>(sample.t_ns), sample.p[2]);
    ASSERT_EQ(sample.p[0], sample.q[3]);
    ASSERT_GT(sample.t_ns, last);
    last = sample.t_ns;
  }
  stop = true;
  writer.join();
}

}  // namespace
}  // namespace hapticd
