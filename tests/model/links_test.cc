/** @file
 * What lies between the servo and a device's own thread or process, under every reordering: what a device is told last
 * is the word of whoever made it safe.
 */
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>

#include "drivers/link/device_link.h"
#include "drivers/link/lent.h"
#include "drivers/vendor/shared_link.h"
#include "tests/model/weak_memory.h"
#include "tests/support/seeds.h"

namespace hapticd::model {
namespace {

constexpr std::int64_t kStale_ns = 1000;

DeviceCommand on(double force) {
  DeviceCommand command;
  command.enabled = true;
  command.force = {force, 0, 0};
  return command;
}

// The last resort (a signal handler, the watchdog): safe(), then awaitSent(), then its own zeros.
TEST(WeakLinks, NothingIsOnItsWayOnceADeviceIsSafe) {
  int late = 0, in_time = 0;
  const Found found = exploreAll([&](Threads& threads) {
    DeviceLink link(kStale_ns);
    link.write(0, on(1));
    bool safe = false, sent = false;
    Mark sending;
    threads.add([&] {
      for (int turn = 0; turn < 2; ++turn) {
        link.order(0, [&](const DeviceCommand& command) {
          threads.expect(!safe || !command.enabled, "an order was sent after zeros");
          ++(safe ? late : in_time);
          sent = true;
          sending = threads.mark();
        });
      }
    });
    threads.add([&] {
      link.safe();
      safe = link.awaitSent(0);
      threads.expect(!safe || !sent || threads.knowsMoreThan(sending), "zeros were sent amid an order");
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_TRUE(found.all) << found.runs;
  EXPECT_GT(late, 0);
  EXPECT_GT(in_time, 0);
}

// The owner loses the device, and frees what others reach it through: a handler of a signal may be at it.
TEST(WeakLinks, WhatIsTakenBackIsUsedNoMore) {
  int uses = 0, waits = 0;
  const Found found = exploreSome(2'000, seedOf(1), [&](Threads& threads) {
    std::atomic<int> device{0};
    Lent<std::atomic<int>*, nullptr> lent;
    bool freed = false;
    int at_it = 0;
    std::array<Mark, 2> used;
    threads.add([&] {
      lent.lend(&device);
      (void)device.load(std::memory_order_relaxed);
      waits += at_it;
      threads.expect(lent.takeBack() == &device, "what was lent comes back");
      freed = true;
      for (const Mark& mark : used) threads.expect(threads.knows(mark), "freed before it was used");
    });
    for (std::size_t i = 0; i < used.size(); ++i) {
      threads.add([&, i] {
        lent.use([&](std::atomic<int>* lent_device) {
          ++uses;
          ++at_it;
          lent_device->fetch_add(1, std::memory_order_relaxed);
          threads.expect(!freed, "used after it was freed");
          used[i] = threads.mark();
          --at_it;
        });
      });
    }
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_GT(uses, 0);
  EXPECT_GT(waits, 0) << "some run must be at it when it is taken back";
}

// Who closes a device, or lets its machine sleep, waits for it to be off.
TEST(WeakLinks, ADeviceThatIsOnIsNeverCalledOff) {
  int told_off = 0;
  const Found found = exploreSome(50'000, seedOf(1), [&](Threads& threads) {
    DeviceLink link(kStale_ns);
    bool is_on = false;
    threads.add([&] {
      link.write(0, on(1));
      link.write(0, {});
    });
    threads.add([&] {
      for (int turn = 0; turn < 3; ++turn)
        link.order(0, [&](const DeviceCommand& command) { is_on = command.enabled; });
    });
    threads.add([&] {
      const bool off = link.isOff();
      threads.expect(!off || !is_on, "called off, and on");
      told_off += off ? 1 : 0;
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_GT(told_off, 0);
}

// An order that is off ends the state of being safe. What was ordered before it is never sent any more.
TEST(WeakLinks, NoOrderFromBeforeFollowsWhenTheServoAgrees) {
  const Found found = exploreAll([&](Threads& threads) {
    DeviceLink link(kStale_ns);
    link.write(0, on(1));
    link.safe();
    bool again = false;
    threads.add([&] {
      link.write(0, {});
      again = true;
      link.write(0, on(2));
    });
    threads.add([&] {
      for (int turn = 0; turn < 2; ++turn) {
        link.order(0, [&](const DeviceCommand& command) {
          threads.expect(!command.enabled || (again && command.force.x() == 2), "an order from before it was safe");
        });
      }
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_TRUE(found.all) << found.runs;
}

// The same two between processes, where the helper may have died in the middle of its last sample.
TEST(WeakLinks, AHelpersSampleIsWholeAndItsOrderOneThatStillHolds) {
  int taken = 0;
  const Found found = exploreSome(10'000, seedOf(1), [&](Threads& threads) {
    SharedLinkMemory memory{};
    memory.generation = 1;
    SharedServoEnd servo(memory);
    SharedDeviceEnd device(memory, 1, kStale_ns);
    servo.write(1, on(1));
    servo.safe();
    bool again = false;
    threads.add([&] {
      servo.write(2, {});
      again = true;
      servo.write(3, on(2));
      DeviceSample sample;
      for (int turn = 0; turn < 3; ++turn) {
        servo.read(3, sample);
        if (!sample.fresh) continue;
        ++taken;
        threads.expect(sample.p.x() == sample.gripper_rad && sample.p.z() == sample.gripper_rad &&
                           sample.buttons == static_cast<std::uint32_t>(sample.gripper_rad),
                       "torn");
      }
    });
    threads.add([&] {
      for (int turn = 1; turn <= 2; ++turn) {
        device.order(3, [&](const DeviceCommand& command) {
          threads.expect(!command.enabled || (again && command.force.x() == 2), "an order from before it was safe");
        });
        DeviceSample sample;
        sample.p.setConstant(turn);
        sample.gripper_rad = turn;
        sample.buttons = static_cast<std::uint32_t>(turn);
        device.publish(sample);
      }
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_GT(taken, 0);
}

}  // namespace
}  // namespace hapticd::model
