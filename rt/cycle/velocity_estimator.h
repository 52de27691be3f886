/** @file
 * Velocity from quantised positions: first-order adaptive windowing (Janabi-Sharifi, Hayward, Chen, IEEE Trans. Control
 * Systems Technology 8(6), 2000, pp. 1003-1009), the end-fit form.
 *
 * The velocity is the slope from the oldest to the newest sample of the longest window, up to kWindow samples, over
 * which that straight line passes every sample between within the position resolution. At rest and in slow motion the
 * window is long and quantisation noise is divided by its length; in a fast change it shrinks to two samples and the
 * estimate follows at once. No tuning beyond the resolution, no phase lag longer than the window.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/math.h"
#include "rt/device.h"

namespace hapticd {

/** One device point. Servo thread. Each axis has its own window. Cost: at most kWindow steps per sample. */
class VelocityEstimator {
 public:
  static constexpr std::uint32_t kWindow = 16;  ///< Samples, the newest included.

  /** Speed that readings in steps may feign of a hand at rest, all axes together, a sample each `dt` [m/s]. */
  [[nodiscard]] static constexpr double noiseAtRest(double step, double dt) HD_RT {
    constexpr double kSqrt3 = 1.7320508075688772;
    return step > 0 ? kSqrt3 * step / ((kWindow - 1) * dt) : 0.0;
  }

  /** Forgets all samples; the next estimate needs two. */
  void reset() HD_RT;
  /** Peak error of a reading [m], [rad]: the device's resolution. Values that are not positive and finite are ignored.
   */
  void setResolution(double position, double rotation) HD_RT;
  /**
   * Takes the sample if it is fresh; the device's own velocity wins where it has one. A reading that is not fresh, not
   * finite or not newer than the last leaves the estimate as it was; a clock that runs backwards starts anew.
   */
  [[nodiscard]] Twist update(const DeviceSample& sample) HD_RT;

 private:
  struct Entry {
    std::int64_t t_ns = 0;
    Vec3 p = Vec3::Zero();
    Quat q = Quat::Identity();
  };

  /** Sample `age` places before the newest. */
  [[nodiscard]] const Entry& back(std::uint32_t age) const HD_RT {
    return ring_[(next_ + kWindow - 1 - age) % kWindow];
  }

  std::array<Entry, kWindow> ring_{};
  std::uint32_t next_ = 0;
  std::uint32_t count_ = 0;
  std::uint32_t unturned_ = 0;  ///< The newest so many samples have one orientation.
  double resolution_ = 1e-5;
  double rotation_resolution_ = 1e-4;
  Twist last_;
};

}  // namespace hapticd
