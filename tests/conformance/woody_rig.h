/** @file
 * WoodenHaptics and Polhem in the conformance suite.
 */
#pragma once

#include "drivers/link/io_device.h"
#include "drivers/woodyhid/woodyhid_io.h"
#include "tests/conformance/rig.h"
#include "tools/haptic-emu/in_process_hid.h"
#include "tools/haptic-emu/woodyhid/woody_hid_model.h"

namespace hapticd::test {

class WoodyRig final : public Rig {
 public:
  explicit WoodyRig(haptic_emu::WoodyKind kind, std::uint8_t report_bytes = 64, const char* query_key = nullptr);

  [[nodiscard]] Device& device() override { return device_; }
  [[nodiscard]] std::int64_t now() const override { return clock.now(); }
  void advance(std::int64_t ns) override;
  void makeReady() override;
  void hold(const Vec3& p) override;
  [[nodiscard]] Vec3 truePosition() const override { return model.hand.position(); }
  [[nodiscard]] Vec3 trueForce() const override { return model.force(); }
  [[nodiscard]] double positionTolerance() const override { return 200e-6; }  // Half a count at each joint.
  [[nodiscard]] double forceTolerance() const override { return 20e-3; }      // A milliampere at each motor.
  [[nodiscard]] std::int64_t mostDelay_ns() const override { return 3'000'000; }
  void unplug() override { model.faults.add({haptic_emu::FaultKind::kUnplug, 0, INT64_MAX}); }
  void plugIn() override { model.faults.clear(); }
  void makeReadyAgain() override { calibrate(); }
  void trouble(Trouble trouble, bool on) override;
  [[nodiscard]] std::uint64_t complaints() const override;

  /** Puts the arm into its pose of calibration and presses the button. */
  void calibrate();
  [[nodiscard]] DeviceLink& link() { return device_.link(); }

  haptic_emu::WoodyHidModel model;
  mutable ManualClock clock;
  WoodySetup setup;

 private:
  IoDevice device_;
  bool held_ = false;
  Vec3 at_ = Vec3::Zero();
};

}  // namespace hapticd::test
