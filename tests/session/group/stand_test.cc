// Control's work between two cycles: only while the servo stands still for it, never by a stand that is over.
#include <unistd.h>

#include <atomic>
#include <thread>

#include "daemon/device/device_group.h"
#include "daemon/panel/panel.h"
#include "tests/session/bench.h"
#include "tests/session/still_device.h"

namespace hapticd::test {
namespace {

/** The time of day; the servo can be kept asleep. A look of control's at a servo that is awake lasts until it has
 * slept. */
class SharedClock final : public Clock {
 public:
  [[nodiscard]] std::int64_t now() HD_RT override { return real_.now(); }
  void sleepUntil(std::int64_t t_ns) HD_RT override {
    const auto me = std::this_thread::get_id();
    if (me == servo.load()) {
      slept.fetch_add(1);
      asleep.wait(true);
      real_.sleepUntil(t_ns);
    } else if (me != control_ || in_device.load()) {
      looks += me == control_ ? 1 : 0;
      real_.sleepUntil(t_ns);
    } else {
      asleep.store(false);
      asleep.notify_all();
      for (const int before = slept.load(); slept.load() == before;) std::this_thread::yield();
    }
  }
  std::atomic<std::thread::id> servo{};
  std::atomic<bool> asleep{false}, in_device{false};
  std::atomic<int> slept{0}, looks{0};

 private:
  const std::thread::id control_ = std::this_thread::get_id();
  MonotonicClock real_;
};

/** Stays in read() while its clock says so. */
class DetainedDevice final : public StillDevice {
 public:
  explicit DetainedDevice(SharedClock& clock) : StillDevice("detained", "test://detained"), clock_(clock) {}
  Result<void> open() override { return {}; }
  void giveUp() noexcept override {}
  void close() noexcept override {}
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override {
    clock_.servo.store(std::this_thread::get_id());
    reads.fetch_add(1);
    clock_.in_device.wait(true);
    StillDevice::read(now_ns, sample);
  }
  std::atomic<int> reads{0};

 private:
  SharedClock& clock_;
};

class Stand : public testing::Test {
 protected:
  Stand() : Stand(false) {}
  /** `detained`: in its first cycle. */
  explicit Stand(bool detained) {
    clock.in_device.store(detained);
    auto device = std::make_unique<DetainedDevice>(clock);
    device_ = device.get();
    std::vector<std::unique_ptr<Device>> devices;
    devices.push_back(std::move(device));
    GroupOptions options;
    options.cycle.period_ns = kMs;
    options.allow_no_rt = true;
    options.lines = &lines;
    auto started = DeviceGroup::start(options, std::move(devices), meshes, clock);
    EXPECT_TRUE(started.ok()) << toString(started.error());
    group = std::move(*started);
    while (device_->reads < (detained ? 1 : 2)) std::this_thread::yield();
  }
  ~Stand() override {
    letGo();
    wake();
  }
  void wake() {
    clock.asleep.store(false);
    clock.asleep.notify_all();
  }
  void awaitReads(int more) const {
    for (const int before = device_->reads; device_->reads < before + more;) std::this_thread::yield();
  }
  void detain() {
    clock.in_device.store(true);
    awaitReads(1);
  }
  void letGo() {
    clock.in_device.store(false);
    clock.in_device.notify_all();
  }
  ErrorCode stand(const std::function<void(Servo&)>& work) {
    const auto stood = group->betweenCycles(work);
    return stood ? ErrorCode::kOk : stood.error().code;
  }
  MeshTable meshes;
  SafetyLines lines;
  SharedClock clock;
  DetainedDevice* device_ = nullptr;
  std::unique_ptr<DeviceGroup> group;
};

TEST_F(Stand, TheServoStandsWhileControlWorksAndGoesOnAfterIt) {
  for (int i = 0; i < 3; ++i) {
    int during = -1, after = -2;
    EXPECT_EQ(stand([&](Servo&) {
                during = device_->reads;
                for (const int before = clock.slept; clock.slept < before + 5;) std::this_thread::yield();
                after = device_->reads;
              }),
              ErrorCode::kOk);
    EXPECT_EQ(after, during) << "it looks whether it may go on, and does not";
    awaitReads(2);
  }
}

/** A panel that shows whether amplifiers are on, and nothing else. */
class OneOutput final : public Lines {
 public:
  explicit OneOutput(bool& level) : level_(level) {}
  [[nodiscard]] int wait(std::int64_t, LineEdge*, int) noexcept override { return 0; }
  [[nodiscard]] int get(std::size_t) noexcept override { return 0; }
  [[nodiscard]] bool set(std::size_t, bool active) noexcept override {
    level_ = active;
    return true;
  }

 private:
  bool& level_;
};

/** Of two servos the test is the one that is armed; a panel looks while the other stands. */
TEST_F(Stand, TakesNoOtherServosAmplifierOffUnlessItsOwnIsOn) {
  SafetyLines::Sign* const armed = lines.take();
  ASSERT_NE(armed, nullptr);
  armed->enabled = true;
  LineConfig line;
  line.role = "enable";
  bool level = false;
  std::int64_t now = kMs;
  Panel panel({line}, std::make_unique<OneOutput>(level), lines, now);
  const auto look = [&] {
    for (const int before = clock.slept; clock.slept < before + 3;) std::this_thread::yield();
    armed->cycles.fetch_add(1);
    panel.step(now += Panel::kLook_ns, nullptr, 0);
    return level;
  };
  EXPECT_TRUE(look());
  ASSERT_EQ(stand([&](Servo&) {
              for (int i = 0; i < 4; ++i) EXPECT_TRUE(look()) << i;
              lines.servos[0].enabled = true;
              look();
              EXPECT_FALSE(look()) << "it stands still with a force";
              lines.servos[0].enabled = false;
            }),
            ErrorCode::kOk);
}

TEST_F(Stand, TheLastOneIsNotTakenForThis) {
  ASSERT_EQ(stand([](Servo&) {}), ErrorCode::kOk);
  detain();
  bool worked = false;
  EXPECT_EQ(stand([&](Servo&) { worked = true; }), ErrorCode::kTimeout);
  EXPECT_FALSE(worked) << "the servo is in its device, not at a stand";
  letGo();
  awaitReads(2);
  EXPECT_EQ(stand([&](Servo&) { worked = true; }), ErrorCode::kOk);
  EXPECT_TRUE(worked);
}

/** Else whoever asks again and again kept control from everybody's stop. */
TEST_F(Stand, AServoThatDoesNotComeBackIsNotWaitedForAgain) {
  detain();
  EXPECT_EQ(stand([](Servo&) {}), ErrorCode::kTimeout);
  EXPECT_GT(clock.looks, 0);
  const std::int64_t until_ns = clock.now() + 1200 * kMs;
  while (clock.now() < until_ns) ::usleep(1000);
  clock.looks = 0;
  EXPECT_EQ(stand([](Servo&) { FAIL(); }), ErrorCode::kTimeout);
  EXPECT_EQ(clock.looks, 0);
  letGo();
  awaitReads(2);
  EXPECT_EQ(stand([](Servo&) {}), ErrorCode::kOk);
}

TEST_F(Stand, OneThatHasBeenGoneForLongIsNotWaitedForAtAll) {
  detain();
  const std::int64_t until_ns = clock.now() + 1200 * kMs;
  while (clock.now() < until_ns) ::usleep(1000);
  EXPECT_EQ(stand([](Servo&) { FAIL(); }), ErrorCode::kTimeout);
  EXPECT_EQ(clock.looks, 0);
}

class StandInTheFirstCycle : public Stand {
 protected:
  StandInTheFirstCycle() : Stand(true) {}
};

TEST_F(StandInTheFirstCycle, AServoThatDoesNotComeBackIsWaitedForOnce) {
  EXPECT_EQ(stand([](Servo&) { FAIL(); }), ErrorCode::kTimeout);
  EXPECT_GT(clock.looks, 0);
  clock.looks = 0;
  EXPECT_EQ(stand([](Servo&) { FAIL(); }), ErrorCode::kTimeout);
  EXPECT_EQ(clock.looks, 0);
  letGo();
  awaitReads(2);
  EXPECT_EQ(stand([](Servo&) {}), ErrorCode::kOk);
}

/** It wakes from the last stand when the next has been asked for. */
TEST_F(Stand, AServoThatLeavesLateStandsAnewForTheNext) {
  ASSERT_EQ(stand([&](Servo&) {
              clock.asleep.store(true);
              for (const int before = clock.slept; clock.slept == before;) std::this_thread::yield();
            }),
            ErrorCode::kOk);
  bool worked = false;
  EXPECT_EQ(stand([&](Servo&) { worked = true; }), ErrorCode::kOk);
  EXPECT_TRUE(worked);
  wake();
  awaitReads(2);
}

}  // namespace
}  // namespace hapticd::test
