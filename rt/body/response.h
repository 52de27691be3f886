/** @file
 * The one interface of the contact responses: bodies about to move into each other in, impulses out. Servo-safe, all
 * loops bounded.
 *
 * All three know bodies by their Mobility only, so whatever holds a body implicitly (the coupling to the hand) counts
 * as part of its mass. Both bodies may move; one with zero mobility moves as told.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/body/mobility.h"

namespace hapticd {

inline constexpr std::uint32_t kMaxTouches = 14;  ///< Of one step.

/** One touching or nearly touching pair of points at the beginning of a step, in the world frame. */
struct Touch {
  Vec3 r_a = Vec3::Zero();     ///< From A's centre of mass to its point [m].
  Vec3 r_b = Vec3::Zero();     ///< From B's centre of mass (or origin, if nothing moves it) to its point [m].
  Vec3 n = Vec3::UnitZ();      ///< Unit, from B to A.
  Vec3 moving = Vec3::Zero();  ///< Velocity of an obstacle's point here, which no impulse changes [m/s].
  double gap = 0;              ///< Along n; negative: inside [m].
  double friction = 0;         ///< Coulomb's coefficient.
  double restitution = 0;      ///< Poisson's coefficient, 0 to 1.
  double separate = 0;         ///< Speed of recovery that is asked for where gap < 0 [m/s].
  double give = 0;             ///< Depth per force of a surface that yields, 0: rigid [m/N]. By constraints alone.
  std::uint64_t key = 0;       ///< The same from step to step while the contact rests; 0: unknown.

  /** Least velocity along n after the step: what is apart may close its gap and no more. */
  [[nodiscard]] double target(double dt) const HD_RT { return gap > 0 ? -gap / dt : separate; }
};

struct ResponseProblem {
  Mobility a, b;
  Twist free_a, free_b;            ///< After this step if nothing touched, of the centres of mass.
  std::span<const Touch> touches;  ///< At most kMaxTouches; the rest is ignored.
  double dt = 0;                   ///< [s]
};

struct ResponseResult {
  Twist a, b;                               ///< After the step.
  std::array<Vec3, kMaxTouches> impulse{};  ///< On A at r_a, by touch; B gets the opposite [N s].
  std::uint32_t rounds = 0;                 ///< Impulses, or sweeps, that it took.
  double residual = 0;                      ///< Largest speed by which a touch still misses its target [m/s].
};

/** One thread. Memory is taken when it is made. */
class Response {
 public:
  virtual ~Response() = default;
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  virtual void solve(const ResponseProblem& problem, ResponseResult& result) HD_RT = 0;
  /** Forgets the last step. */
  virtual void reset() HD_RT {}
};

/** Velocity of A's point relative to B's. */
[[nodiscard]] inline Vec3 relativeVelocity(const Twist& a, const Twist& b, const Touch& touch) HD_RT {
  return velocityAt(a, touch.r_a) - velocityAt(b, touch.r_b) - touch.moving;
}

/** Applies an impulse at a touch to both motions. */
inline void applyImpulse(const ResponseProblem& problem, const Touch& touch, const Vec3& j, Twist& a, Twist& b) HD_RT {
  const Twist da = problem.a(j, touch.r_a.cross(j));
  const Twist db = problem.b(j, touch.r_b.cross(j));
  a.v += da.v;
  a.w += da.w;
  b.v -= db.v;
  b.w -= db.w;
}

}  // namespace hapticd
