#include "drivers/pantograph/pantograph_kinematics.h"

#include <cmath>

namespace hapticd::pantograph {

Grip gripAt(const Bars& bars, const Vec2& angles) HD_RT {
  Grip grip;
  const Vec2 u1(std::cos(angles[0]), std::sin(angles[0])), u2(std::cos(angles[1]), std::sin(angles[1]));
  const Vec2 a = bars.l * u1, b = Vec2(bars.d, 0) + bars.l * u2;
  // The grip is L from both elbows, on the operator's side of the line between them.
  const Vec2 half = (b - a) / 2;
  const double h = half.norm();
  constexpr double kStraight = 0.995;  // Elbows so far apart that the two long bars are nearly one.
  if (!(h > 1e-4) || !(h < kStraight * bars.L)) return grip;  // Nor where an angle is not finite.
  Vec2 across(-half.y() / h, half.x() / h);
  if (across.y() < 0) across = -across;
  grip.p = a + half + std::sqrt(bars.L * bars.L - h * h) * across;
  // Both lengths stay: (p - a).(dp - da) = 0 and (p - b).(dp - db) = 0.
  const Vec2 ra = grip.p - a, rb = grip.p - b;
  const double determinant = ra.x() * rb.y() - ra.y() * rb.x();  // 2 h times what is under the root: not zero.
  const double qa = bars.l * (ra.y() * u1.x() - ra.x() * u1.y()), qb = bars.l * (rb.y() * u2.x() - rb.x() * u2.y());
  grip.jacobian << rb.y() * qa / determinant, -ra.y() * qb / determinant,  //
      -rb.x() * qa / determinant, ra.x() * qb / determinant;
  grip.reachable = true;
  return grip;
}

}  // namespace hapticd::pantograph
