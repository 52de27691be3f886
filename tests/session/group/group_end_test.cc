// A group that ends makes its devices safe before it closes them, whichever way it ends.
#include "daemon/device/device_group.h"
#include "tests/session/bench.h"
#include "tests/session/still_device.h"

namespace hapticd::test {
namespace {

/** Writes down how it is let go. */
class Parting final : public StillDevice {
 public:
  explicit Parting(std::string& said) : StillDevice("leaving", "test://leaving"), said_(said) {}
  Result<void> open() override { return {}; }
  void giveUp() noexcept override {}
  void safe() noexcept override { said_ += "safe "; }
  void close() noexcept override { said_ += "closed "; }

 private:
  std::string& said_;
};

class GroupEnd : public testing::Test {
 protected:
  Result<std::unique_ptr<DeviceGroup>> start(std::size_t count) {
    std::vector<std::unique_ptr<Device>> devices;
    for (std::size_t i = 0; i < count; ++i) devices.push_back(std::make_unique<Parting>(said));
    GroupOptions options;
    options.threads = false;
    return DeviceGroup::start(options, std::move(devices), meshes, clock);
  }
  std::string said;
  MeshTable meshes;
  ManualClock clock;
};

TEST_F(GroupEnd, WithItsDevices) {
  {
    const auto group = start(2);
    ASSERT_TRUE(group.ok());
    EXPECT_EQ((*group)->servo().cycle().config().device_count, 2u);
  }
  EXPECT_EQ(said, "safe closed safe closed ");
}

TEST_F(GroupEnd, WithoutThoseThatAreTaken) {
  DeviceGroup::Leaving taken;
  {
    auto group = start(2);
    ASSERT_TRUE(group.ok());
    taken = (*group)->takeDevices();
    EXPECT_EQ((*group)->deviceCount(), 0u);
  }
  EXPECT_EQ(taken.devices.size(), 2u);
  EXPECT_EQ(taken.last_resort.size(), 2u);
  EXPECT_EQ(said, "") << "whoever has taken them does that";
  taken.last_resort.clear();
}

TEST_F(GroupEnd, OfNoneOrTooManyThereIsNone) {
  EXPECT_EQ(start(0).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(start(kMaxDevices + 1).error().code, ErrorCode::kInvalidArgument);
  EXPECT_TRUE(start(kMaxDevices).ok());
}

}  // namespace
}  // namespace hapticd::test
