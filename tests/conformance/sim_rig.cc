#include "tests/conformance/sim_rig.h"

#include <gtest/gtest.h>

#include "drivers/sim/sim_device.h"

namespace hapticd::test {
namespace {

/** A stiff hand holds: the simulator has no way to nail the grip down. */
class SimRig final : public Rig {
 public:
  SimRig() : device_(*resolveSim(*parseDeviceUri("sim://default?hand_stiffness=10000&hand_damping=120&motion=live"))) {}

  Device& device() override { return device_; }
  std::int64_t now() const override { return now_ns_; }
  void advance(std::int64_t ns) override {
    now_ns_ += ns;
    // The simulator's world stands on what the servo asks of it, so ask in steps that it does not skip.
    for (; asked_ns_ < now_ns_; asked_ns_ = std::min(now_ns_, asked_ns_ + 10'000'000)) {
      device_.setIntent({goal_, Quat::Identity(), 0});
      DeviceSample ignored;
      device_.read(asked_ns_, ignored);
    }
  }
  void makeReady() override { ASSERT_TRUE(device_.open().ok()); }
  void hold(const Vec3& p) override { goal_ = p; }
  Vec3 truePosition() const override { return device_.body().position(); }
  Vec3 trueForce() const override { return device_.acting().force; }
  double positionTolerance() const override { return 1.1e-5; }
  double forceTolerance() const override { return 1e-9; }
  std::int64_t mostDelay_ns() const override { return 1'000'000; }

 private:
  SimDevice device_;
  std::int64_t now_ns_ = 0, asked_ns_ = 0;
  Vec3 goal_ = Vec3::Zero();
};

}  // namespace

std::unique_ptr<Rig> makeSimRig() { return std::make_unique<SimRig>(); }

}  // namespace hapticd::test
