#include "rt/collide/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rt/geometry/half_spaces.h"
#include "rt/geometry/nearest/nearest.h"

namespace hapticd {
namespace {

/** A solid by how far it reaches: about its middle the same to both sides. */
class Reach {
 public:
  explicit Reach(const Solid& solid) HD_RT : kind_(solid.shape.kind), size_(solid.shape.size) {
    middle_ = solid.X_WO.p;
    axes_ = solid.X_WO.q.toRotationMatrix();
    if (kind_ != ShapeKind::kMesh) return;
    Vec3 low, high;
    boxAbout(*solid.shape.mesh, low, high);
    size_ = 0.5 * (high - low);
    middle_ += axes_ * (0.5 * (low + high));
  }
  static void boxAbout(const MeshView& mesh, Vec3& low, Vec3& high) HD_RT {
    const hd_bvh_node& root = mesh.nodes[0];
    for (int i = 0; i < 3; ++i) {
      low[i] = *std::min_element(root.lower[i], root.lower[i] + root.used);
      high[i] = *std::max_element(root.upper[i], root.upper[i] + root.used);
    }
  }
  [[nodiscard]] double along(const Vec3& n) const HD_RT {
    const Vec3 d = axes_.transpose() * n;
    switch (kind_) {
      case ShapeKind::kSphere:
        return size_.x();
      case ShapeKind::kCapsule:
        return size_.x() + size_.y() * std::abs(d.z());
      case ShapeKind::kCylinder:
        return size_.x() * d.head<2>().norm() + size_.y() * std::abs(d.z());
      default:
        return size_.dot(d.cwiseAbs());
    }
  }
  [[nodiscard]] bool isCurved() const HD_RT { return kind_ != ShapeKind::kBox && kind_ != ShapeKind::kMesh; }
  [[nodiscard]] Vec3 axis(int i) const HD_RT { return axes_.col(i); }
  [[nodiscard]] const Vec3& middle() const HD_RT { return middle_; }

 private:
  ShapeKind kind_;
  Vec3 size_, middle_;
  Mat3 axes_;
};

class PartingSearch {
 public:
  PartingSearch(const Reach& first, const Reach& second) HD_RT : first_(first),
                                                                 second_(second),
                                                                 between_(second.middle() - first.middle()) {
    best_.way = std::numeric_limits<double>::infinity();
  }
  /** To both sides. */
  bool tryAlong(const Vec3& axis) HD_RT {
    const double length = axis.norm();
    if (!(length > kLeastAxis)) return false;
    const double sign = between_.dot(axis) < 0 ? -1 : 1;
    const Vec3 n = sign / length * axis;
    const double first = first_.along(n), second = second_.along(n);
    const double way = first + second - between_.dot(n);
    if (!(way < best_.way - kLess)) return false;
    best_ = {n, way, first, second};
    return true;
  }
  /** Beside the best, in ever smaller steps. */
  void refine() HD_RT {
    double step = 0.3;
    for (int i = 0; i < kRounds; ++i) {
      const Vec3 n = best_.n;
      const Vec3 aside = step * n.unitOrthogonal(), across = n.cross(aside);
      bool less = false;
      for (const Vec3& to : {aside, Vec3(-aside), across, Vec3(-across)}) less = tryAlong(n + to) || less;
      if (!less) step /= 2;
    }
  }
  [[nodiscard]] const Vec3& between() const HD_RT { return between_; }
  [[nodiscard]] const Parting& best() const HD_RT { return best_; }

 private:
  static constexpr double kLeastAxis = 1e-6;  ///< A shorter one is of parallels, or of what has one middle.
  static constexpr double kLess = 1e-9;       ///< Of two ways that are the same the first stays [m].
  static constexpr int kRounds = 20;

  const Reach &first_, &second_;
  Vec3 between_;
  Parting best_;
};

/** The half-space kWithin below the surface nearest to x; false: nobody knows. */
bool below(const Solid& solid, const Vec3& x, std::uint32_t limit, std::uint32_t& work, HalfSpace& out) HD_RT {
  NearestQuery query;
  query.x = solid.X_WO.inverse() * x;
  query.limit = limit > work ? limit - work : 0;
  Nearest nearest;
  const bool found = query.limit > 0 && nearestOnShape(solid.shape, query, nearest) == NearestResult::kFound;
  work += query.work;
  if (!found) return false;
  const double apart = std::sqrt(nearest.squared_distance), gap = nearest.isInside(query.x) ? -apart : apart;
  out.normal = solid.X_WO.q * (apart > 1e-7 ? Vec3((query.x - nearest.point) / gap) : nearest.pseudo_normal);
  out.offset = out.normal.dot(x) - gap - kWithin;
  return isFinite(out.normal);
}

/** The point nearest to x in both; of nearly parallel ones in that which it is farther from. */
Vec3 into(const HalfSpace& a, const HalfSpace& b, const Vec3& x) HD_RT {
  constexpr double kParallel = 1e-6;
  const double over_a = a.height(x), over_b = b.height(x);
  const HalfSpace& worse = over_a > over_b ? a : b;
  const HalfSpace& other = over_a > over_b ? b : a;
  const double over = std::max(over_a, over_b);
  if (!(over > 0)) return x;
  Vec3 alone = x - over * worse.normal;
  const double c = a.normal.dot(b.normal), det = 1 - c * c;
  if (!(other.height(alone) > 0) || det < kParallel) return alone;
  return x - (over_a - c * over_b) / det * a.normal - (over_b - c * over_a) / det * b.normal;
}

}  // namespace

Vec3 middleOf(const Solid& solid) HD_RT { return Reach(solid).middle(); }

Parting leastParting(const Solid& first, const Solid& second) HD_RT {
  const Reach a(first), b(second);
  PartingSearch search(a, b);
  for (int i = 0; i < 3; ++i) (void)search.tryAlong(a.axis(i));
  for (int i = 0; i < 3; ++i) (void)search.tryAlong(b.axis(i));
  for (int i = 0; i < 9; ++i) (void)search.tryAlong(a.axis(i / 3).cross(b.axis(i % 3)));
  (void)search.tryAlong(search.between());
  if (a.isCurved() || b.isCurved()) search.refine();
  return search.best();
}

bool findWithin(const Solid& first, const Solid& second, std::uint32_t limit, std::uint32_t& work) HD_RT {
  // `farther`: times the way. Where 1.7 goes to and fro about an edge 1.9 gets in, and the other way round.
  struct Try {
    Vec3 start;
    int steps;
    double farther;
  };
  const bool mesh = first.shape.kind == ShapeKind::kMesh || second.shape.kind == ShapeKind::kMesh;
  const Vec3 a = middleOf(first), b = middleOf(second);
  for (const Try& one : {Try{0.5 * (a + b), 32, 1.7}, Try{a, 64, 1.9}, Try{b, mesh ? 0 : 64, 1.8}}) {
    Vec3 x = one.start;
    for (int i = 0; i < one.steps; ++i) {
      HalfSpace in_a, in_b;
      if (!below(first, x, limit, work, in_a) || !below(second, x, limit, work, in_b)) return false;
      if (!(in_a.height(x) > 1e-7) && !(in_b.height(x) > 1e-7)) return true;
      x += one.farther * (into(in_a, in_b, x) - x);
    }
  }
  return false;
}

}  // namespace hapticd
