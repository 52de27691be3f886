// What is round in the scene against a tool's surface, which a ball may meet between two of the tool's points.
#include <algorithm>
#include <array>
#include <cmath>

#include "rt/collide/feature.h"
#include "rt/collide/line_search.h"
#include "rt/collide/purse.h"
#include "rt/collide/round.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kBalls = 9;            ///< Of a capsule, from end to end of what the tool may touch.
constexpr std::uint32_t kPlaces = kBalls + 3;  ///< Numbers of places on an axis.

/** Part of B's axis that A may touch. */
struct Axis {
  double first, last;  ///< [m]
  [[nodiscard]] double at(double ball) const HD_RT { return first + ball / (kBalls - 1) * (last - first); }
};

/** Of what is about that place within so far. */
Axis nearPart(const Vec3& middle_W, double reach, const RoundBody& b) HD_RT {
  const double half = halfAxis(b.shape);
  const double middle = (b.X_WO.inverse() * middle_W).z();
  return {std::clamp(middle - reach, -half, half), std::clamp(middle + reach, -half, half)};
}

}  // namespace

/**
 * Of a capsule the nearest ball, and both ends of what touches, which hold the rotation of what lies along it; balls
 * between and beyond, for it may have turned before the next answer.
 */
bool SceneContacts::tryRound(std::uint32_t k, const CollideRequest::Held& held, double margin, Purse& purse) HD_RT {
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  if (!hasMantle(obstacle.shape) || held.shape.kind == ShapeKind::kSphere) return false;
  const RoundBody a{held.shape, held.X_WO}, b{obstacle.shape, obstacle.X_WO};
  const bool mesh = held.shape.kind == ShapeKind::kMesh, round = isRound(obstacle.shape);
  const Axis axis = nearPart(a.X_WO * points_.middle(), points_.reach(), b);
  BallTouch touch;
  const auto meets = [&](const Vec3& center) HD_RT {
    NearestQuery query;
    if (mesh) query.reach = b.shape.size.x() + std::max(kReach, margin);
    query.limit = purse.left();
    const bool found = !purse.empty() && meetBall(a, b, center, query, touch) == NearestResult::kFound;
    purse.report.work += query.work;
    return found;
  };
  const auto gapAt = [&](double ball)
                         HD_RT { return meets(b.X_WO * Vec3(0, 0, axis.at(ball))) ? touch.gap : INFINITY; };
  // Where a disc and the tool are not nearest to each other, what tells them apart is no plane of either.
  const auto isThere = [&](const Vec3& p_B, double gap) HD_RT {
    NearestQuery query;
    query.x = a.X_WO.inverse() * p_B;
    query.reach = b.shape.size.x() + std::max(kReach, margin);
    query.limit = purse.left();
    Nearest nearest;
    const NearestResult result = nearestOnShape(a.shape, query, nearest);
    purse.report.work += query.work;
    if (result != NearestResult::kFound) return false;
    const double least = ContactModel::kLeastReach + std::max(0.0, gap);
    return nearest.isInside(query.x) || nearest.squared_distance <= least * least;
  };
  const auto keepAt = [&](const Vec3& p_A, const Vec3& n, double gap, std::uint32_t feature) HD_RT {
    if (!(gap <= margin) || !isFinite(n) || !isFinite(p_A)) return;
    if (!round && !isThere(p_A - gap * n, gap)) return;
    Contact contact;
    contact.n_W = n;
    contact.p_WA = p_A;
    contact.p_WB = p_A - gap * n;
    contact.depth = -gap;
    contact.feature_a = kFirstBall + feature;
    keep(contact, held, k);
    purse.report.touching += gap <= 0 ? 1 : 0;
  };
  const auto add = [&](double ball, std::uint32_t feature) HD_RT {
    Vec3 center = b.X_WO * Vec3(0, 0, axis.at(ball));
    if (!meets(center)) return;
    if (axis.first < axis.last) {
      // Beyond an edge of the tool the ball beside it touches that edge.
      center = onAxis(b, touch.p_A);
      if (!meets(center)) return;
    }
    keepAt(touch.p_A, touch.n, touch.gap, feature);
    const double radius = b.shape.size.x();
    if (!mesh || !round || !(touch.gap > -radius)) return;
    Walls walls;
    const Pose X_AW = a.X_WO.inverse();
    const Vec3 first = X_AW.q * -touch.n;
    const std::uint32_t count = furtherWalls(a.shape, X_AW * center, first, 1, radius + margin, purse, walls);
    for (std::uint32_t n = 0; n < count; ++n) {
      keepAt(a.X_WO * walls[n].surface, a.X_WO.q * -walls[n].out, walls[n].gap - radius, feature + (n + 1) * kPlaces);
    }
  };
  if (!(axis.first < axis.last)) {
    add(0, 0);
    return !mesh && round && !purse.over;
  }
  std::uint32_t nearest = 0;
  double least = INFINITY;
  for (std::uint32_t i = 0; i < kBalls; ++i) {
    const double gap = gapAt(i);
    if (!(gap < least)) continue;
    least = gap;
    nearest = i;
  }
  if (!std::isfinite(least)) return false;
  double best = leastOf(std::max(0.0, nearest - 1.0), std::min(kBalls - 1.0, nearest + 1.0), gapAt);
  if (!(gapAt(best) <= least)) best = nearest;
  const double touching = gapAt(best) + ContactModel::kLeastReach;
  add(best, kBalls);
  add(lastOf(best, 0, touching, gapAt), kBalls + 1);
  add(lastOf(best, kBalls - 1, touching, gapAt), kBalls + 2);
  for (std::uint32_t i = 0; i < kBalls; ++i) add(i, i);
  return !mesh && round && !purse.over;
}

}  // namespace hapticd
