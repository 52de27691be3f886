/** @file
 * The velocity that a buzzing wall must be damped by: young where motion is fast, quiet where it is near a step.
 *
 * An estimate that averages (rt/cycle/velocity_estimator.h) comes too late for a buzz, and the displacement of one tick
 * comes in whole encoder steps: at 4 kHz a step of 10 um is 40 mm/s, and damping by it is a blow that is late.
 * So the window is the shortest over which the hand has moved by kSteps steps, and never longer than kLongest_s.
 *
 * Damping that is computed now acts later by the delay of the loop and by half a tick, from a displacement whose middle
 * is half a tick old. The velocity is therefore extrapolated over delay + 1 ticks with the last change, which counts
 * only as far as steps cannot explain it: three readings can be wrong by two steps together.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "rt/base/math.h"

namespace hapticd {

/** One hand. Servo thread. */
class BuzzVelocity {
 public:
  static constexpr double kSteps = 2.5;        ///< [encoder steps]
  static constexpr double kLongest_s = 1e-3;   ///< Longest window.
  static constexpr double kMostLead = 4;       ///< [ticks]
  static constexpr std::uint32_t kWindow = 4;  ///< Most ticks in a window.

  void reset() HD_RT {
    moved_.fill(Vec3::Zero());
    velocity_.setZero();
  }
  /** Encoder step [m]; what is not positive and finite is taken for none. */
  void setResolution(double step) HD_RT { step_ = std::isfinite(step) && step > 0 ? step : 0.0; }

  /** Takes the displacement of the tick that has ended, `dt` long; `delay` is that of the loop beyond one tick [ticks].
   */
  void update(const Vec3& moved, double dt, double delay) HD_RT {
    const Vec3 change = moved - moved_[0];
    std::copy_backward(moved_.begin(), moved_.end() - 1, moved_.end());
    moved_[0] = moved;
    const auto longest = std::clamp(static_cast<std::uint32_t>(kLongest_s / dt + 0.5), 1u, kWindow);
    Vec3 sum = moved;
    std::uint32_t ticks = 1;
    for (; ticks < longest && !(sum.norm() >= kSteps * step_); ++ticks) sum += moved_[ticks];
    const double size = change.norm();
    const double sure = size > 2 * step_ ? 1 - 2 * step_ / size : 0.0;
    velocity_ = (sum / ticks + std::min(kMostLead, delay + 1) * sure * change) / dt;
  }

  /** Now, as far as it can be told [m/s]. */
  [[nodiscard]] const Vec3& velocity() const HD_RT { return velocity_; }

 private:
  double step_ = 0;
  std::array<Vec3, kWindow> moved_{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< The newest first [m].
  Vec3 velocity_ = Vec3::Zero();
};

}  // namespace hapticd
