/** @file
 * A mass on the device point, pushed by a hand and by the force the guard lets through, held over each tick.
 */
#pragma once

#include "rt/cycle/velocity_estimator.h"
#include "tests/unit/guard/guard_rig.h"

namespace hapticd {

/** What the simulated world wants at place x with velocity v. */
template <class World>
class HandSim {
 public:
  double mass = 0.15;        ///< [kg]
  double friction = 0.1;     ///< Viscous, of the device [N s/m].
  double resolution = 0;     ///< Of the encoder [m].
  Vec3 push = Vec3::Zero();  ///< Of the hand [N].
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
  World world;
  GuardRig rig;
  double delivered = 0;  ///< Work done on the hand by the device [J].

  HandSim(const GuardConfig& config, World w) : world(w), rig(config) {
    rig.armFully();
    velocity_.setResolution(1e-5, 1e-4);
  }

  /** One millisecond. */
  const GuardOutput& tick() {
    Vec3 read = x;
    if (resolution > 0) read = (x / resolution).array().round().matrix() * resolution;
    rig.sample.p = read;
    rig.sample.t_ns = rig.in.now_ns + 1'000'000;
    rig.in.velocity = velocity_.update(rig.sample);
    world(rig.in, read, rig.in.velocity.v);
    const GuardOutput& out = rig.step();
    const Vec3 before = x;
    for (int i = 0; i < 20; ++i) {
      const double h = 1e-3 / 20;
      v += h / mass * (out.command.force + push - friction * v);
      x += h * v;
    }
    delivered += out.command.force.dot(x - before);
    return out;
  }

 private:
  VelocityEstimator velocity_;
};

}  // namespace hapticd
