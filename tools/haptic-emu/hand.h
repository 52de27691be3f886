/** @file
 * The arm of a played device with a hand on it: a point that forces move.
 */
#pragma once

#include <cstdint>

#include "drivers/sim/body.h"

namespace haptic_emu {

using hapticd::Vec3;

/** Mass of arm and hand together, and the grip's spring toward where the hand wants to be. SI. */
struct HandParameters {
  double mass = 0.35, viscous = 0.5;
  double stiffness = 400, damping = 12;
  Vec3 at = Vec3::Zero();
};

/** Point, force, hand; in steps of 62.5 us. */
class Hand {
 public:
  static constexpr std::int64_t kStep_ns = 62'500;

  explicit Hand(const HandParameters& p)
      : body_({p.mass, p.viscous, 0, p.stiffness, p.damping}, {}, static_cast<double>(kStep_ns) * 1e-9), goal_(p.at) {
    body_.place(p.at, Vec3::Zero());
  }

  /** Where the hand wants to be, from now on. */
  void want(const Vec3& p) { goal_ = p; }
  /** There, at rest, at once. */
  void place(const Vec3& p) {
    goal_ = p;
    body_.place(p, Vec3::Zero());
  }
  /** One step under the device's force. */
  void step(const Vec3& force) { body_.step(force, goal_, Vec3::Zero()); }
  [[nodiscard]] const Vec3& position() const { return body_.position(); }

 private:
  hapticd::PointBody body_;
  Vec3 goal_;
};

}  // namespace haptic_emu
