// A ball in a hollow of a mesh touches other walls than the nearest: it lies on both sides of a groove at once.
#include <array>
#include <cmath>

#include "rt/collide/edge_search.h"
#include "rt/collide/feature.h"
#include "rt/collide/purse.h"
#include "rt/geometry/nearest/nearest.h"
#include "rt/geometry/sweep/sweep.h"

namespace hapticd {
namespace {

/** Whether nothing of the mesh stands between x and a point of it. */
bool isInSight(const Shape& mesh, const Vec3& x, const Vec3& point, std::uint32_t limit, std::uint32_t& work) HD_RT {
  constexpr double kMostOfTheWay = 0.999;
  Sweep sweep;
  sweep.a = x;
  sweep.d = kMostOfTheWay * (point - x);
  sweep.two_sided = true;
  sweep.limit = limit;
  SweepHit hit;
  const SweepResult result = sweepShape(mesh, sweep, hit);
  work += sweep.work;
  return result == SweepResult::kNone;
}

}  // namespace

/** Each is the nearest of those that lead elsewhere than the ones before. */
std::uint32_t SceneContacts::furtherWalls(const Shape& mesh, const Vec3& x, const Vec3& first, double facing,
                                          double reach, Purse& purse, Walls& out) HD_RT {
  std::array<Vec3, std::tuple_size_v<Walls>> ways{first};
  for (std::uint32_t n = 0; n < out.size(); ++n) {
    if (purse.empty()) return n;
    NearestQuery query;
    query.x = x;
    query.reach = reach;
    query.ways = ways.data();
    query.way_count = n + 1;
    query.cosine = kSameWay;
    query.limit = purse.left();
    Nearest wall;
    const NearestResult result = nearestOnShape(mesh, query, wall);
    purse.report.work += query.work;
    if (result != NearestResult::kFound) return n;
    const Vec3 way = x - wall.point;
    const double apart = way.norm();
    if (!(facing * way.dot(wall.pseudo_normal) >= 0)) return n;
    if (!isInSight(mesh, x, wall.point, purse.left(), purse.report.work)) return n;
    out[n] = {wall.point, way / apart, apart, wall.feature};
    if (n + 1 < ways.size()) ways[n + 1] = out[n].out;
  }
  return static_cast<std::uint32_t>(out.size());
}

void SceneContacts::tryFurtherWalls(std::uint32_t i, std::uint32_t k, const CollideRequest::Held& held,
                                    const PointTouch& first, int side, double margin, Purse& purse) HD_RT {
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  const bool disc = held.shape.kind == ShapeKind::kCylinder && ToolPoints::isDisc(i);
  const double radius = disc ? held.shape.size.x() : points_.radius();
  const bool point = !(radius > 0);
  if (obstacle.shape.kind != ShapeKind::kMesh) return;
  if (point ? first.gap > reach_ + kInset : !(first.gap > 0)) return;
  // A point may be in the first wall by a hair: the others are looked for from before it.
  const Vec3 x = first.surface + (point ? std::max(first.gap, kInset) : first.gap) * first.out;
  const double reach = radius + (point ? reach_ + 2 * kInset : margin);
  const Vec3 x_W = point ? held.X_WO * points_.at(i) : obstacle.X_WO * x;
  Walls walls;
  const std::uint32_t count = furtherWalls(obstacle.shape, x, first.out, side < 0 ? -1 : 1, reach, purse, walls);
  for (std::uint32_t n = 0; n < count; ++n) {
    Contact contact;
    contact.n_W = obstacle.X_WO.q * walls[n].out;
    contact.p_WB = obstacle.X_WO * walls[n].surface;
    if (!lowest(i, held, x_W, contact.n_W, contact.p_WA)) continue;
    contact.depth = contact.n_W.dot(contact.p_WB - contact.p_WA);
    const std::uint32_t of_mesh = held.shape.kind == ShapeKind::kSphere ? ballFeature(walls[n].triangle, side) : 0;
    contact.feature_a = of_mesh > 0 ? of_mesh : i + (n + 1) * ToolPoints::kMost;
    if (disc && !isThere(contact, held, obstacle, radius + margin, side, purse)) continue;
    if (point && !mayLean(i, held, k, contact, purse)) continue;
    if (contact.depth < -margin || !isFinite(contact.n_W) || !isFinite(contact.p_WA)) continue;
    keep(contact, held, k);
    purse.report.touching += contact.depth >= 0 ? 1 : 0;
  }
}

}  // namespace hapticd
