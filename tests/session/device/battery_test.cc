// The battery of a device without a cable, as clients see it.
#include "daemon/resource/resource_tree.h"
#include "drivers/link/io_device.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

class Wireless final : public DeviceIo {
 public:
  explicit Wireless(const int& percent) : percent_(percent) {
    info_.uri = "wireless://1";
    info_.driver = "wireless";
  }
  const DeviceInfo& info() const noexcept override { return info_; }
  int batteryPercent() const noexcept override { return percent_; }
  Result<void> open(const std::atomic<bool>&) override { return {}; }
  void close() noexcept override {}
  bool exchange(DeviceLink&, std::int64_t) noexcept override { return true; }
  void safe() noexcept override {}

 private:
  const int& percent_;
  DeviceInfo info_;
};

TEST(Battery, IsAPropertyOfDevicesThatTellIt) {
  int percent = -1;
  Bench bench;
  bench.core.devices().setFactory([&](std::string_view) -> Result<std::unique_ptr<Device>> {
    return std::unique_ptr<Device>(
        std::make_unique<IoDevice>(std::make_unique<Wireless>(percent), IoOptions{.thread = false}));
  });
  ASSERT_TRUE(bench.core.openDevice("wireless://1").ok());
  const auto battery = [&](const OpenDevice& device) {
    return *ResourceTree(bench.core).get("/devices/" + device.name + "/battery", bench.core.client(bench.connection));
  };
  const std::string with_cable = battery(bench.device(0));
  EXPECT_NE(with_cable.find("null"), std::string::npos) << with_cable;
  EXPECT_EQ(battery(bench.device(1)), with_cable) << "not told yet";
  percent = 64;
  EXPECT_NE(battery(bench.device(1)).find("64"), std::string::npos) << battery(bench.device(1));
}

}  // namespace
}  // namespace hapticd::test
