#include "rt/render/surface/transient.h"

#include <algorithm>

namespace hapticd {

void Transient::strike(const SurfaceParameters& surface, double speed, const Vec3& direction) HD_RT {
  if (!(speed >= kLeastSpeed)) return;
  const double amplitude = std::min(surface.transient_gain * speed, kMostForce);
  if (amplitude <= std::max(amplitude_, kSilence)) return;
  amplitude_ = amplitude;
  r_ = std::sqrt(surface.transient_decay);
  turn_ = surface.transient_turn;
  decay_ = surface.transient_decay;
  now_ = amplitude * surface.transient_first;
  before_ = 0;
  direction_ = direction;
}

Vec3 Transient::step() HD_RT {
  if (amplitude_ <= kSilence) {
    amplitude_ = 0;
    return Vec3::Zero();
  }
  const double force = now_;
  now_ = turn_ * force - decay_ * before_;
  before_ = force;
  amplitude_ *= r_;
  return force * direction_;
}

}  // namespace hapticd
