#include "rt/guard/passivity.h"

#include <algorithm>

namespace hapticd {

void Passivity::reset() HD_RT {
  energy_.setZero();
  acting_ = false;
}

void Passivity::observe(const Vec3& sent, const Vec3& moved, const Vec3& carried) HD_RT {
  energy_ += carried - sent.cwiseProduct(moved);
}

void Passivity::limitStore(double stored) HD_RT {
  const double cap = kMargin + (stored >= 0 ? std::min(stored, kMaxStored) : kMaxStored);
  const double excess = energy_.sum() - cap;
  if (!(excess > 0)) return;
  // Taken from the axes that hold energy, in proportion: none of them turns negative by it.
  const Vec3 held = energy_.cwiseMax(0.0);
  energy_ -= held * std::min(1.0, excess / held.sum());
}

Vec3 Passivity::control(const Vec3& f, const Vec3& v, const Vec3& carried_power, double dt) HD_RT {
  acting_ = false;
  const Vec3 ahead = energy_ + dt * (carried_power - f.cwiseProduct(v));
  const double debt = -ahead.sum() - kDeadZone;
  if (!(debt > 0) || max_damping_ <= 0) return f;
  // Where: axes in proportion to their own debt, so that the damping moves from axis to axis without a jump.
  Vec3 weight = (-ahead).cwiseMax(0.0);
  const double most = weight.maxCoeff();
  weight /= most;                                                // A negative sum has a negative term.
  const double rate = weight.dot(v.cwiseProduct(v)) * kRepay_s;  // Energy that unit damping repays.
  const double damping = debt < max_damping_ * rate ? debt / rate : max_damping_;
  acting_ = rate > 0;
  return f - damping * weight.cwiseProduct(v);
}

}  // namespace hapticd
