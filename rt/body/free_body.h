/** @file
 * An object that moves freely: a rigid body that tools push, with damping, weight, and sleep where it lies still.
 */
#pragma once

#include "rt/body/mobility.h"
#include "rt/body/rigid_body.h"

namespace hapticd {

/** One thread, servo-safe. */
class FreeBody {
 public:
  static constexpr double kRestSpeed = 1e-3;  ///< Slower than this, [m/s] and at kRestLever of turn, ...
  static constexpr double kRestLever = 0.03;  ///< [m]
  static constexpr double kRestTime = 0.25;   ///< ... for so long it falls asleep [s].

  /** `damping`: the share of its motion that it loses [1/s]. */
  FreeBody(const MassProperties& mass, double damping, bool falls) noexcept
      : body(mass), damping_(damping), falls_(falls) {}

  /** Motion after dt under its weight alone. */
  [[nodiscard]] Twist freeTwist(const Vec3& gravity, double dt) const HD_RT {
    const double left = 1 / (1 + damping_ * dt);
    const Twist& V = body.twist();
    return {left * (V.v + dt * weightOf(gravity) / body.mass()), left * V.w};
  }
  [[nodiscard]] Vec3 weightOf(const Vec3& gravity) const HD_RT {
    return falls_ ? Vec3(body.mass() * gravity) : Vec3(Vec3::Zero());
  }
  /** After each tick. True if it has been still for long enough to sleep. */
  bool watchRest(double dt) HD_RT {
    const Twist& V = body.twist();
    rest_s_ = V.v.norm() + kRestLever * V.w.norm() < kRestSpeed ? rest_s_ + dt : 0;
    return rest_s_ >= kRestTime;
  }
  /** Its motion is zero from now on. */
  void sleep() HD_RT {
    asleep_ = true;
    body.setTwist(Twist{});
  }
  void wake() HD_RT {
    asleep_ = false;
    rest_s_ = 0;
  }
  [[nodiscard]] bool asleep() const HD_RT { return asleep_; }

  RigidBody body;
  double reserve = 0;  ///< As the tool's: what earlier ticks lost pays for leaving an overlap [J].

 private:
  double damping_;
  bool falls_;
  double rest_s_ = 0;
  bool asleep_ = false;
};

}  // namespace hapticd
