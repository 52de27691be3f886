#include "rt/guard/passivity.h"

#include <algorithm>

namespace hapticd {

void Passivity::reset() HD_RT {
  energy_.setZero();
  leak_ = 0;
}

void Passivity::observe(const Vec3& sent, const Vec3& moved, const Vec3& carried) HD_RT {
  energy_ += carried - sent.cwiseProduct(moved);
}

void Passivity::follow(double leaked) HD_RT { leak_ = std::clamp(leak_ + leaked, -kMargin, kMaxStored); }

void Passivity::limitStore(double stored) HD_RT {
  const double cap = kMargin + (stored >= 0 ? std::min(stored, kMaxStored) : kMaxStored);
  const double excess = energy_.sum() - cap;
  if (!(excess > 0)) return;
  // The excess is taken from the axes that hold energy, in proportion, so that none turns negative.
  const Vec3 held = energy_.cwiseMax(0.0);
  energy_ -= excess / held.sum() * held;
}

double Passivity::dampingFor(double debt, double rate, double repay_s, double most) HD_RT {
  if (!(debt > 0) || !(rate > 0)) return 0;
  return debt < most * rate * repay_s ? debt / (rate * repay_s) : most;
}

Vec3 Passivity::control(const Vec3& f, const Vec3& v, const Vec3& v_buzz, const Vec3& carried_power, double dt) HD_RT {
  Vec3 out = f;
  double used = 0;
  const double size = f.norm();
  if (size > 0) {
    const double speed = f.dot(v_buzz) / size;
    used = dampingFor(leak_ - kLeakZone, speed * speed, kRepayLeak_s, max_damping_);
    out -= std::min(1.0, used * speed / size) * f;
  }

  const Vec3 ahead = energy_ + dt * (carried_power - f.cwiseProduct(v));
  // Each axis is damped in proportion to its own debt, so that damping passes from axis to axis without a jump.
  Vec3 weight = (-ahead).cwiseMax(0.0);
  const double largest = weight.maxCoeff();
  if (largest > 0) {
    weight /= largest;
    const double rate = weight.dot(v.cwiseProduct(v));
    const double damping = dampingFor(-ahead.sum() - kDeadZone, rate, kRepay_s, max_damping_ - used);
    out -= damping * weight.cwiseProduct(v);
    used += damping;
  }
  acting_ = used > 0;
  return out;
}

}  // namespace hapticd
