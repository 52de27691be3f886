/** @file
 * The force that acts now when commands take a while to act.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/math.h"

namespace hapticd {

/** The forces of the last ticks. Servo thread only. */
class PastForces {
 public:
  static constexpr double kMaxDelay = 16;  ///< [ticks]

  void reset() HD_RT { ring_.fill(Vec3::Zero()); }
  /** The force sent last. */
  void push(const Vec3& force) HD_RT {
    newest_ = (newest_ + 1) % kSize;
    ring_[newest_] = force;
  }
  /**
   * Mean of what acted over the tick that ended now when each force acts `delay` ticks after it was sent, in
   * [0, kMaxDelay]: with half a tick, half of the last and half of the one before.
   */
  [[nodiscard]] Vec3 acted(double delay) const HD_RT {
    const auto whole = static_cast<std::uint32_t>(delay);
    const double part = delay - whole;
    return (1 - part) * back(whole) + part * back(whole + 1);
  }

 private:
  static constexpr std::uint32_t kSize = static_cast<std::uint32_t>(kMaxDelay) + 2;

  [[nodiscard]] const Vec3& back(std::uint32_t ticks) const HD_RT { return ring_[(newest_ + kSize - ticks) % kSize]; }

  std::array<Vec3, kSize> ring_{};
  std::uint32_t newest_ = 0;
};

}  // namespace hapticd
