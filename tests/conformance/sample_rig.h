/** @file
 * The sample driver in the conformance suite.
 */
#pragma once

#include "drivers/link/io_device.h"
#include "drivers/sample/sample_io.h"
#include "tests/conformance/rig.h"
#include "tools/haptic-emu/in_process_usb.h"
#include "tools/haptic-emu/sample/sample_model.h"

namespace hapticd::test {

class SampleRig final : public Rig {
 public:
  SampleRig()
      : device_(std::make_unique<SampleIo>(haptic_emu::openInProcess(model, clock), clock), {.thread = false}, clock) {}

  [[nodiscard]] Device& device() override { return device_; }
  [[nodiscard]] std::int64_t now() const override { return model.now(); }
  void advance(std::int64_t ns) override;
  void makeReady() override;
  void hold(const Vec3& p) override {
    held_ = true;
    at_ = Vec3(p.y(), p.z(), p.x());
  }
  [[nodiscard]] Vec3 truePosition() const override { return toWorld(model.hand.position()); }
  [[nodiscard]] Vec3 trueForce() const override { return toWorld(model.force()); }
  [[nodiscard]] double positionTolerance() const override { return 1e-5; }
  [[nodiscard]] double forceTolerance() const override { return 1e-3; }
  [[nodiscard]] std::int64_t mostDelay_ns() const override { return 3'000'000; }
  void unplug() override { model.faults.add({haptic_emu::FaultKind::kUnplug, 0, INT64_MAX}); }
  void plugIn() override { model.faults.clear(); }
  void trouble(Trouble trouble, bool on) override;
  [[nodiscard]] std::uint64_t complaints() const override;

  haptic_emu::SampleModel model;
  ManualClock clock;

 private:
  static Vec3 toWorld(const Vec3& v_D) { return {v_D.z(), v_D.x(), v_D.y()}; }
  IoDevice device_;
  bool held_ = false;
  Vec3 at_ = Vec3::Zero();
};

}  // namespace hapticd::test
