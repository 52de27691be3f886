/** @file
 * What follows an impact: a short decaying oscillation, scaled by the speed of the impact (Kuchenbecker, Fiene,
 * Niemeyer, "Improving contact realism through event-based haptic feedback", IEEE TVCG 12(2), 2006).
 */
#pragma once

#include "rt/base/math.h"
#include "rt/command.h"

namespace hapticd {

/** The transient of one device point. Servo thread only. */
class Transient {
 public:
  static constexpr double kLeastSpeed = 5e-3;  ///< Slower is no impact [m/s].
  static constexpr double kMostForce = 10;     ///< Amplitude of the hardest blow [N].
  static constexpr double kSilence = 1e-4;     ///< Amplitude at which it ends [N].

  /**
   * An impact on that surface at `speed` [m/s], felt along `direction` (unit, out of the surface): at tick n, of which
   * the first is this one, gain * speed * r^n sin(n theta). While a stronger one still sounds, nothing changes.
   */
  void strike(const SurfaceParameters& surface, double speed, const Vec3& direction) HD_RT;

  /** This tick's force on the hand [N]. */
  [[nodiscard]] Vec3 step() HD_RT;

  void reset() HD_RT { *this = Transient{}; }

 private:
  double amplitude_ = 0;  ///< Of the envelope: gain * speed * r^n [N].
  double r_ = 0;
  double turn_ = 0, decay_ = 0;
  double now_ = 0, before_ = 0;  ///< The next two terms of the recurrence, backwards [N].
  Vec3 direction_ = Vec3::Zero();
};

}  // namespace hapticd
