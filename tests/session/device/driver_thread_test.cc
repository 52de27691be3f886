// A device with a thread of its own that has no right to its priority.
#include <gmock/gmock.h>

#include "drivers/link/io_device.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

class IdleIo final : public DeviceIo {
 public:
  IdleIo() { info_.uri = "idle://", info_.driver = "idle"; }
  const DeviceInfo& info() const noexcept override { return info_; }
  Result<void> open(const std::atomic<bool>&) override { return {}; }
  void close() noexcept override {}
  bool exchange(DeviceLink&, std::int64_t until_ns) noexcept override {
    MonotonicClock().sleepUntil(until_ns);
    return true;
  }
  void safe() noexcept override {}

 private:
  DeviceInfo info_;
};

TEST(DriverThread, WithoutItsPriorityIsTold) {
  constexpr int kNobodyHas = 1000;
  Bench bench;
  const auto said = [&](bool thread) {
    bench.core.devices().setFactory([=](std::string_view) -> Result<std::unique_ptr<Device>> {
      return std::unique_ptr<Device>(
          std::make_unique<IoDevice>(std::make_unique<IdleIo>(), IoOptions{.priority = kNobodyHas, .thread = thread}));
    });
    testing::internal::CaptureStderr();
    const auto opened = bench.core.openDevice("idle://", bench.administration);
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_TRUE(opened.ok());
    if (opened) {
      EXPECT_TRUE(bench.core.devices().close(**opened).ok());
    }
    return text;
  };
  EXPECT_THAT(said(true),
              testing::HasSubstr("device idle: the thread that speaks with it may be late: SCHED_FIFO priority 1000"));
  EXPECT_THAT(said(false), testing::Not(testing::HasSubstr("may be late")));
}

}  // namespace
}  // namespace hapticd::test
