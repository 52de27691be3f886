/** @file
 * Velocity from quantised positions: first-order adaptive windowing (Janabi-Sharifi, Hayward, Chen, IEEE Trans. Control
 * Systems Technology 8(6), 2000, pp. 1003-1009): the longest window, up to kWindow samples, over which a straight line
 * stays within the position resolution of every sample between.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/math.h"
#include "rt/device.h"

namespace hapticd {

class VelocityEstimator {
 public:
  static constexpr std::uint32_t kWindow = 16;

  void reset() HD_RT { count_ = 0; }
  void setResolution(double position, double rotation) HD_RT {
    resolution_ = position;
    rotation_resolution_ = rotation;
  }
  /** Takes the sample if it is fresh; the device's own velocity wins where it has one. */
  [[nodiscard]] Twist update(const DeviceSample& sample) HD_RT;

 private:
  struct Entry {
    std::int64_t t_ns;
    Vec3 p;
    Quat q;
  };
  std::array<Entry, kWindow> ring_{};
  std::uint32_t next_ = 0;
  std::uint32_t count_ = 0;
  double resolution_ = 1e-5;
  double rotation_resolution_ = 1e-4;
  Twist last_;
};

}  // namespace hapticd
