/** @file
 * A device driven at a servo's pace without a servo: read, force law, write, once per period.
 */
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string_view>
#include <utility>

#include "drivers/registry.h"
#include "tests/support/stepped/push.h"

namespace hapticd::test {

/** Opens a device by URI and steps it. Fails the running test if it cannot be made. */
class SteppedDevice {
 public:
  explicit SteppedDevice(std::string_view uri, std::int64_t period_ns = 1'000'000) : period_ns_(period_ns) {
    Result<std::unique_ptr<Device>> made = makeDevice(uri);
    if (!made) {
      ADD_FAILURE() << toString(made.error());
      std::abort();
    }
    device_ = std::move(*made);
    EXPECT_TRUE(device_->open().ok());
  }
  ~SteppedDevice() { device_->close(); }

  /** One period: reads, asks `law(sample)` for a force [N], writes it. */
  template <class Law>
  const DeviceSample& step(Law&& law) {
    device_->read(now_ns_, sample_);
    device_->write(now_ns_, push(law(std::as_const(sample_))));
    now_ns_ += period_ns_;
    return sample_;
  }
  template <class Law>
  const DeviceSample& run(int periods, Law&& law) {
    for (int i = 0; i < periods; ++i) step(law);
    return sample_;
  }
  /** Without force. */
  const DeviceSample& run(int periods) {
    return run(periods, [](const DeviceSample&) { return Vec3(Vec3::Zero()); });
  }

  [[nodiscard]] Device& device() { return *device_; }
  [[nodiscard]] const DeviceSample& sample() const { return sample_; }
  [[nodiscard]] std::int64_t now() const { return now_ns_; }
  void setNow(std::int64_t now_ns) { now_ns_ = now_ns; }

 private:
  std::unique_ptr<Device> device_;
  std::int64_t period_ns_;
  std::int64_t now_ns_ = 1'000'000'000;
  DeviceSample sample_;
};

/** A half-space that pushes back: force = stiffness times depth, along the outward normal. */
struct SpringWall {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  double stiffness = 1000;

  [[nodiscard]] double depth(const Vec3& p) const { return (point - p).dot(normal); }
  [[nodiscard]] Vec3 operator()(const DeviceSample& sample) const {
    const double d = depth(sample.p);
    return d > 0 ? Vec3(normal * (stiffness * d)) : Vec3(Vec3::Zero());
  }
};

}  // namespace hapticd::test
