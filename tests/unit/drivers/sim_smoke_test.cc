#include <gtest/gtest.h>

#include "drivers/registry.h"

namespace hapticd {
namespace {

TEST(SimDevice, TheHandFollowsItsCircle) {
  Result<std::unique_ptr<Device>> made =
      makeDevice("sim://default?motion=circle&radius=0.03&period=2&centre=0,0,0.02&hand_stiffness=400");
  ASSERT_TRUE(made.ok()) << toString(made.error());
  Device& device = **made;
  ASSERT_TRUE(device.open().ok());
  DeviceSample sample;
  double farthest = 0;
  for (int tick = 1000; tick < 5000; ++tick) {
    const std::int64_t now = tick * std::int64_t{1'000'000};
    device.read(now, sample);
    EXPECT_TRUE(sample.fresh);
    EXPECT_EQ(sample.t_ns, now);
    const double angle = 2 * EIGEN_PI * (tick - 1000) * 1e-3 / 2;
    const Vec3 goal(0.03 * std::cos(angle), 0.03 * std::sin(angle), 0.02);
    farthest = std::max(farthest, (sample.p - goal).norm());
    device.write(now, DeviceCommand{});
  }
  EXPECT_GT(farthest, 1e-5) << "a hand with mass lags";
  EXPECT_LT(farthest, 3e-3);
}

}  // namespace
}  // namespace hapticd
