/** @file
 * The Falcon in the conformance suite.
 */
#pragma once

#include "drivers/falcon/falcon_io.h"
#include "drivers/link/io_device.h"
#include "tests/conformance/rig.h"
#include "tools/haptic-emu/falcon/falcon_model.h"
#include "tools/haptic-emu/in_process_usb.h"

namespace hapticd::test {

class FalconRig final : public Rig {
 public:
  FalconRig();

  [[nodiscard]] Device& device() override { return device_; }
  [[nodiscard]] std::int64_t now() const override { return model.now(); }
  void advance(std::int64_t ns) override;
  void makeReady() override;
  void hold(const Vec3& p) override;
  [[nodiscard]] Vec3 truePosition() const override { return toWorld(model.hand.position() - Vec3(0, 0, 0.125)); }
  [[nodiscard]] Vec3 trueForce() const override { return toWorld(model.force()); }
  [[nodiscard]] double positionTolerance() const override { return 60e-6; }  // A count, and half of one more.
  [[nodiscard]] double forceTolerance() const override { return 5e-3; }      // Half a count at each motor.
  [[nodiscard]] std::int64_t mostDelay_ns() const override { return 4'000'000; }
  void unplug() override;
  void plugIn() override { model.faults.clear(); }
  void makeReadyAgain() override;
  void trouble(Trouble trouble, bool on) override;
  [[nodiscard]] std::uint64_t complaints() const override;

  /** Pulls the grip out and pushes it in, as homing asks. */
  void home();

  haptic_emu::FalconModel model;
  ManualClock clock;
  FalconSetup setup;

 private:
  static Vec3 toWorld(const Vec3& v_F) { return {v_F.z(), v_F.x(), v_F.y()}; }
  IoDevice device_;
  bool held_ = false;
  Vec3 at_ = Vec3::Zero();
};

}  // namespace hapticd::test
