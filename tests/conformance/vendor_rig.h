/** @file
 * Devices behind vendors' SDKs in the conformance suite: the driver that hapticd-vendor runs, over a played SDK.
 */
#pragma once

#include "drivers/link/io_device.h"
#include "tests/conformance/rig.h"
#include "tests/fakes/vendor_sdk/fake_sdk.h"

namespace hapticd::test {

class VendorRig final : public Rig {
 public:
  enum class Kind : std::uint8_t { kOmega3, kSigma7, kTouch };
  /** `uri` in place of the default device of that kind; "sdk=" is put to it. */
  explicit VendorRig(Kind kind, const char* uri = nullptr);

  [[nodiscard]] Device& device() override { return *device_; }
  [[nodiscard]] std::int64_t now() const override { return clock.now(); }
  void advance(std::int64_t ns) override;
  void makeReady() override;
  void hold(const Vec3& p) override { at_ = p; }
  [[nodiscard]] Vec3 truePosition() const override;
  [[nodiscard]] Vec3 trueForce() const override;
  [[nodiscard]] double positionTolerance() const override { return 1e-9; }
  [[nodiscard]] double forceTolerance() const override { return 1e-9; }
  [[nodiscard]] std::int64_t mostDelay_ns() const override { return 3'000'000; }
  void unplug() override { state.unplugged = true; }
  void plugIn() override { state.unplugged = false; }
  void trouble(Trouble trouble, bool on) override;
  [[nodiscard]] std::uint64_t complaints() const override;
  [[nodiscard]] DeviceLink& link() const { return device_->link(); }

  fake_sdk::State& state;
  mutable ManualClock clock;

 private:
  [[nodiscard]] bool hd() const { return kind_ == Kind::kTouch; }
  void place(const Vec3& p);

  Kind kind_;
  Vec3 at_ = Vec3::Zero();
  void (*tick_)() = nullptr;
  std::int64_t next_tick_ns_ = 0;
  std::unique_ptr<IoDevice> device_;
};

}  // namespace hapticd::test
