// What a servo takes in one tick, of devices, the panel and its inlets; and what it tells of how long it took.
#include <gtest/gtest.h>

#include <memory>

#include "rt/cycle/servo.h"

namespace hapticd {
namespace {

/** Reading and writing last; it may have nothing new. */
class SlowDevice final : public Device {
 public:
  explicit SlowDevice(ManualClock& clock) : clock_(clock) {}
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return told; }
  [[nodiscard]] Result<void> open() override { return {}; }
  void close() noexcept override {}
  void read(std::int64_t now_ns, DeviceSample& out) noexcept override {
    clock_.advance(read_ns);
    if (silent) return;
    out.t_ns = now_ns;
    out.fresh = true;
    out.buttons = pressed;
  }
  void write(std::int64_t, const DeviceCommand&) noexcept override { clock_.advance(write_ns); }
  void safe() noexcept override {}

  std::int64_t read_ns = 0, write_ns = 0;
  bool silent = false;
  std::uint32_t pressed = 0;
  DeviceInfo told;

 private:
  ManualClock& clock_;
};

struct ServoCost : testing::Test {
  ServoCost() {
    servo = std::make_unique<Servo>(CycleConfig{}, std::array<Device*, kMaxDevices>{&device}, meshes, clock);
    servo->begin();
  }
  ManualClock clock{123};
  SlowDevice device{clock};
  SafetyLines lines;
  MeshTable meshes;
  std::unique_ptr<Servo> servo;
};

TEST_F(ServoCost, EachStageIsToldByItself) {
  device.read_ns = 100'000;
  device.write_ns = 30'000;
  for (int i = 0; i < 10; ++i) servo->runOnce();
  const ServoHistograms& h = servo->histograms;
  EXPECT_EQ(h.wake.summary().max_ns, 0u);
  EXPECT_EQ(h.read.summary().max_ns, 100'000u);
  EXPECT_EQ(h.render.summary().max_ns, 0u) << "by this clock";
  EXPECT_EQ(h.guard.summary().max_ns, 0u);
  EXPECT_EQ(h.write.summary().max_ns, 30'000u);
  EXPECT_EQ(h.cycle.summary().max_ns, 130'000u);
  device.read_ns = 1'700'000;
  servo->runOnce();
  servo->runOnce();
  EXPECT_EQ(h.wake.summary().max_ns, 730'000u) << "a period less than the cycle before it took";
  for (const Histogram* each : {&h.wake, &h.read, &h.render, &h.guard, &h.write, &h.cycle})
    EXPECT_EQ(each->summary().count, 12u);
}

TEST_F(ServoCost, ADeviceWithNothingNewIsStale) {
  servo->runOnce();
  EXPECT_TRUE(servo->lastInput().device[0].fresh);
  device.silent = true;
  servo->runOnce();
  EXPECT_FALSE(servo->lastInput().device[0].fresh);
  EXPECT_EQ(servo->counters.stale.load(), 1u);
}

/** Where there is room for all of them; else they are left out, and the device keeps its own. */
TEST_F(ServoCost, ThePanelsButtonsStandBehindTheDevicesOwn) {
  servo->lines = &lines;
  for (const std::uint32_t own : {0u, 1u, 8u, 31u, 32u}) {
    for (const std::uint32_t panel : {0u, 1u, 8u, 24u, 31u, 32u}) {
      device.told.buttons = own;
      device.pressed = 0x5a5a5a5au;
      lines.button_count = panel;
      lines.buttons = 0xc3a5c3a5u;
      servo->runOnce();
      for (std::uint32_t i = 0; i < 32; ++i) {
        const bool of_panel = own + panel <= 32 && i >= own && i < own + panel;
        const std::uint32_t expected = of_panel ? 0xc3a5c3a5u >> (i - own) : device.pressed >> i;
        ASSERT_EQ(servo->lastInput().device[0].buttons >> i & 1, expected & 1) << own << "+" << panel << " " << i;
      }
    }
  }
}

/** Each inlet has its part of what a tick may take, whatever the others send. */
TEST_F(ServoCost, EachInletHasItsShareOfATick) {
  Ingest ingest(IngestConfig{});
  Collider collider;
  servo->ingest = &ingest;
  servo->collider = &collider;
  const auto fill = [](auto& inlet, std::uint32_t most, std::uint64_t seq) {
    Command command = makeCommand(CommandKind::kDisarm, DeviceRef{0});
    for (std::uint32_t i = 0; i < 2 * most; ++i) {
      command.seq = seq + i;
      ASSERT_TRUE(inlet.push(command));
    }
  };
  fill(servo->from_control, kControlCommandsPerCycle, 1000);
  fill(ingest.commands, kIngestCommandsPerCycle, 2000);
  fill(collider.answers, kCollideCommandsPerCycle, 3000);
  for (const std::uint32_t tick : {0u, 1u}) {
    servo->runOnce();
    const CycleInput& input = servo->lastInput();
    ASSERT_EQ(input.command_count, kMaxCommandsPerCycle);
    std::uint32_t n = 0;
    for (const auto& [most, seq] : {std::pair{kControlCommandsPerCycle, 1000u},
                                    {kIngestCommandsPerCycle, 2000u},
                                    {kCollideCommandsPerCycle, 3000u}}) {
      for (std::uint32_t i = 0; i < most; ++i) ASSERT_EQ(input.command[n++].seq, seq + tick * most + i);
    }
    EXPECT_EQ(servo->counters.control_applied.load(), (tick + 1) * kControlCommandsPerCycle);
  }
  servo->runOnce();
  EXPECT_EQ(servo->lastInput().command_count, 0u);
}

}  // namespace
}  // namespace hapticd
