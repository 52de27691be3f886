// Edges, corners and rims of the scene's boxes and cylinders against a tool's surface, which they may meet between two
// of the tool's points.
#include <algorithm>
#include <cmath>

#include "rt/collide/edge_search.h"
#include "rt/collide/feature.h"
#include "rt/collide/mantle.h"
#include "rt/collide/purse.h"
#include "rt/collide/round.h"

namespace hapticd {
namespace {

/** One edge of B, straight or an arc of a rim, as far as A may reach; in B's frame. A rim may meet a face of A and, not
 * far on, another: of an arc so short that is one place. */
struct Edge {
  Vec3 origin;  ///< Its middle; of an arc that of the rim.
  Vec3 along;   ///< Unit; of an arc zero.
  double radius = 0, first = 0, last = 0;

  [[nodiscard]] double at(double t) const HD_RT { return first + t * (last - first); }
  [[nodiscard]] Vec3 point(double t) const HD_RT {
    const double s = at(t);
    return radius > 0 ? Vec3(origin + radius * Vec3(std::cos(s), std::sin(s), 0)) : Vec3(origin + s * along);
  }
  /** The end, where the place is hardly away from it: that is a corner, or where the tool's reach ends. */
  [[nodiscard]] double orEnd(double t) const HD_RT {
    if (radius > 0) return t;
    return t * length() < kInset ? 0 : (1 - t) * length() < kInset ? 1 : t;
  }
  [[nodiscard]] double length() const HD_RT { return (last - first) * (radius > 0 ? radius : 1); }
  [[nodiscard]] ObstacleEdge whole() const HD_RT {
    return radius > 0 ? ObstacleEdge{origin, origin, radius} : ObstacleEdge{point(0), point(1)};
  }
};

std::uint32_t edgesOf(const Shape& shape) HD_RT { return shape.kind == ShapeKind::kBox ? kBoxEdges : 2 * kRimArcs; }

/** `near`: A's middle in B's frame, and how far it reaches from there. */
Edge edgeOf(const Shape& shape, std::uint32_t i, const Vec3& near, double reach) HD_RT {
  Edge edge;
  if (shape.kind == ShapeKind::kCylinder) {
    const double arc = 2 * EIGEN_PI / kRimArcs;
    edge.origin = Vec3(0, 0, i < kRimArcs ? -shape.size.y() : shape.size.y());
    edge.along = Vec3::Zero();
    edge.radius = shape.size.x();
    edge.first = arc * (i % kRimArcs);
    edge.last = edge.first + arc;
    return edge;
  }
  const int axis = static_cast<int>(i / 4), u = (axis + 1) % 3, v = (axis + 2) % 3;
  edge.origin = edge.along = Vec3::Zero();
  edge.along[axis] = 1;
  edge.origin[u] = (i & 1) != 0 ? shape.size[u] : -shape.size[u];
  edge.origin[v] = (i & 2) != 0 ? shape.size[v] : -shape.size[v];
  edge.first = std::clamp(near[axis] - reach, -shape.size[axis], shape.size[axis]);
  edge.last = std::clamp(near[axis] + reach, -shape.size[axis], shape.size[axis]);
  return edge;
}

/**
 * A place a little within B's corner at x, or its edge `along`, from which A is looked at: edges that cross are in each
 * other, however little, and from within A its nearest face tells nothing of how they lie, while from here A's edge is
 * nearest.
 */
Vec3 withinEdge(const Shape& shape, const Vec3& x, const Vec3& along, double times = 1) HD_RT {
  const bool round = shape.kind == ShapeKind::kCylinder;
  const double inset =
      times * std::min(kInset, 0.25 * (round ? shape.size.head<2>().minCoeff() : shape.size.minCoeff()));
  if (round) {
    const double share = 1 - inset / shape.size.x();
    return {share * x.x(), share * x.y(), x.z() - std::copysign(inset, x.z())};
  }
  Vec3 at = x;
  for (int i = 0; i < 3; ++i) {
    if (along[i] == 0 && isAtBorder(shape, x, i)) at[i] -= std::copysign(inset, x[i]);
  }
  return at;
}

}  // namespace

bool leansOut(const Shape& shape, const Vec3& x, const Vec3& n, double turn) HD_RT {
  const double aside = kAside + std::sin(turn), along = kAlong + std::sin(turn);
  if (shape.kind == ShapeKind::kCylinder) {
    const double radius = x.head<2>().norm(), across = n.head<2>().norm();
    const bool end = shape.size.y() - std::abs(x.z()) <= kOnBorder * shape.size.y();
    if (end ? std::copysign(1.0, x.z()) * n.z() < -aside : std::abs(n.z()) > along) return false;
    if (!(shape.size.x() - radius <= kOnBorder * shape.size.x())) return !(across > along);
    const Vec3 out(x.x() / radius, x.y() / radius, 0);
    return out.dot(n) > -aside && std::abs(out.cross(n).z()) < along;
  }
  if (shape.kind != ShapeKind::kBox) return true;
  for (int i = 0; i < 3; ++i) {
    if (isAtBorder(shape, x, i) ? std::copysign(1.0, x[i]) * n[i] < -aside : std::abs(n[i]) > along) return false;
  }
  return true;
}

void SceneContacts::tryEdges(std::uint32_t k, const CollideRequest::Held& held, double margin, Purse& purse) HD_RT {
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  const bool mesh = held.shape.kind == ShapeKind::kMesh;
  if (obstacle.shape.kind != ShapeKind::kBox && obstacle.shape.kind != ShapeKind::kCylinder) return;
  if (isRound(held.shape) || (mesh && (held.shape.mesh->flags & HD_MESH_CLOSED) == 0)) return;
  const Pose X_AB = held.X_WO.inverse() * obstacle.X_WO;
  const double tool = points_.reach() + margin;
  NearestQuery query;
  Nearest nearest;
  const auto gapAt = [&](const Vec3& x_B, const Vec3& on, double reach, double times = 1) HD_RT {
    query = {};
    query.x = X_AB * withinEdge(obstacle.shape, x_B, on, times);
    if (mesh) query.reach = reach;
    query.limit = purse.left();
    const bool found = !purse.empty() && nearestOnShape(held.shape, query, nearest) == NearestResult::kFound;
    purse.report.work += query.work;
    if (!found) return static_cast<double>(INFINITY);
    const double apart = std::sqrt(nearest.squared_distance);
    return nearest.isInside(query.x) ? -apart : apart;
  };
  // From the obstacle to the tool, where it was asked last.
  const auto normal = [&](double apart) HD_RT {
    return std::abs(apart) > 1e-7 ? Vec3((nearest.point - query.x) / apart) : Vec3(-nearest.pseudo_normal);
  };
  const auto add = [&](const Edge& edge, double t, std::uint32_t feature) HD_RT {
    const double reach = std::max(kReach, margin);
    double apart = gapAt(edge.point(t), Vec3::Zero(), reach), times = 1;
    if (apart < 0 && apart > -2 * kToSide) {  // Barely inside, the normal is unreliable: look from farther out.
      times = 1.25;
      if (t > 0 && t < 1) {
        t = nearestBeside(t, edge.length(),
                          [&](double at) HD_RT { return gapAt(edge.point(at), edge.along, reach, times); });
      }
      apart = gapAt(edge.point(t), Vec3::Zero(), reach, times);
    }
    const Vec3 x_B = edge.point(t);
    if (!(apart <= margin + 2 * kInset)) return;
    Vec3 n_A = normal(apart), p_A = nearest.point;
    // A vertex of the tool counts, too: of what has come in over the edge by a hair its point is told one face only.
    if (nearest.kind == FeatureKind::kVertex && isToldAsPoint(p_A, held, obstacle, purse)) return;
    double gap = n_A.dot(p_A - X_AB * x_B);
    if (gap > margin) return;
    const Vec3 along = X_AB.q * edge.along;
    if (t > 0 && t < 1 && edge.radius == 0 && std::abs(n_A.dot(along)) > kAlong) {
      const auto look = [&](double shift, Vec3& n, Vec3& p) HD_RT {
        const double beside = gapAt(edge.point(t + shift / edge.length()), edge.along, kReach, times);
        n = normal(beside);
        p = nearest.point;
        return beside;
      };
      const Crossing crossing = crossingAt(X_AB * x_B, along, look);
      if (!crossing.found) return;
      n_A = crossing.n_A;
      gap = crossing.gap;
      p_A = X_AB * x_B + gap * n_A;
    }
    if (isAboutAxis(held.shape) && isOnMantle(held.shape, p_A, n_A) && isMantles(held.shape, edge.whole(), X_AB, x_B))
      return;
    if (!leansOut(obstacle.shape, x_B, X_AB.q.conjugate() * n_A)) return;
    Contact contact;
    contact.n_W = held.X_WO.q * n_A;
    contact.p_WA = held.X_WO * p_A;
    contact.p_WB = obstacle.X_WO * x_B;
    contact.depth = -gap;
    contact.feature_a = kFirstEdge + feature;
    if (!isFinite(contact.n_W) || !isFinite(contact.p_WA)) return;
    keep(contact, held, k);
    purse.report.touching += gap <= 0 ? 1 : 0;
  };
  const Vec3 middle = X_AB.inverse() * points_.middle();
  const std::uint32_t count = edgesOf(obstacle.shape);
  std::uint32_t to_its_end = count;  // Of a rim the arc of which the end was told.
  for (std::uint32_t i = 0; i < count && !purse.empty(); ++i) {
    const Edge edge = edgeOf(obstacle.shape, i, middle, tool);
    const double length = edge.length(), reach = 0.5 * length + std::max(kReach, margin);
    const Vec3 middle_B = edge.point(0.5);
    if ((middle_B - middle).norm() > tool + 0.5 * length) continue;
    const Vec3 within = X_AB.q * (withinEdge(obstacle.shape, middle_B, edge.along) - middle_B);
    const std::uint32_t parts = partsFor(points_, length);
    for (std::uint32_t part = 0; part < parts; ++part) {
      const auto whole = [&](double t) HD_RT { return (part + t) / parts; };
      const auto along = [&](double t) HD_RT { return gapAt(edge.point(whole(t)), edge.along, reach); };
      const EdgeSpan span =
          touchingSpan(margin + 2 * kInset, std::max(kAslant, reach_), length / parts, within, along, normal);
      for (std::uint32_t j = 0; j < 3; ++j) {
        if (!span.has(static_cast<int>(j))) continue;
        const double t = whole(span.place[j]);
        const bool told = t == 0 && to_its_end + 1 == i && i % kRimArcs > 0;
        if (edge.radius > 0 && t == 1) to_its_end = i;
        if (!told) add(edge, edge.orEnd(t), (3 * (i + part * count) + j) % (3 * 2 * kRimArcs));
      }
    }
  }
}

}  // namespace hapticd
