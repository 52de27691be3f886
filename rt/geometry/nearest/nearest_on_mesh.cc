#include <cmath>
#include <limits>

#include "rt/geometry/nearest/fan.h"
#include "rt/geometry/nearest/nearest.h"
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/tree/box_queries.h"
#include "rt/geometry/tree/tree_walk.h"
#include "rt/geometry/tree/vicinity.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kWider = 1 + 0x1p-30;  // Beyond rounding.
constexpr double kAnySide = std::numeric_limits<double>::infinity();
constexpr double kAsNear = 1 - 0x1p-20;  // Of squares: flat sides in parts are not quite flat.

/** Whether nothing of the triangles about a foot of t is nearer to x than that. */
bool isLeast(const MeshView& mesh, std::uint32_t t, const TriangleFoot& foot, const Vec3& x,
             std::uint32_t& work) HD_RT {
  if (foot.kind == FeatureKind::kFace || mesh.neighbours == nullptr) return true;
  const double least = kAsNear * (x - foot.point).squaredNorm();
  const auto isNearer = [&](std::uint32_t other) HD_RT {
    ++work;
    return (x - nearestOnTriangle(cornersOf(mesh, other), x).point).squaredNorm() < least;
  };
  if (foot.kind == FeatureKind::kEdge) {
    const std::uint32_t across = mesh.neighbours[t][foot.corner];
    return across == HD_NO_INDEX || !isNearer(across);
  }
  return !anyAbout(mesh, t, mesh.triangles[t][foot.corner],
                   [&](std::uint32_t other, std::uint32_t) HD_RT { return isNearer(other); });
}

/** Whether a foot of t is what such a query looks for. */
bool leadsElsewhere(const MeshView& mesh, std::uint32_t t, const TriangleFoot& foot, NearestQuery& query) HD_RT {
  const Vec3 way = query.x - foot.point;
  const double most = query.cosine * way.norm();
  for (std::uint32_t i = 0; i < query.way_count; ++i) {
    if (!(way.dot(query.ways[i]) < most)) return false;
  }
  return isLeast(mesh, t, foot, query.x, query.work);
}

}  // namespace

NearestResult nearestOnMesh(const MeshView& mesh, NearestQuery& query, Nearest& nearest) HD_RT {
  double best = query.reach * query.reach;
  TriangleFoot foot;
  std::uint32_t triangle = HD_NO_INDEX;
  const auto look = [&](std::uint32_t t) {
    const Corners v = cornersOf(mesh, t);
    const Vec3 n = (v.b - v.a).cross(v.c - v.a);  // A needle's roughly: its neighbours are as near.
    const double nn = n.squaredNorm(), height = n.dot(query.x - v.a);
    if (height * height > best * nn * kWider) return;  // Already its plane is too far.
    if (query.turned && !(n.dot(query.axis) > query.cosine * std::sqrt(nn))) return;
    const TriangleFoot here = nearestOnTriangle(v, query.x);
    const double squared = (query.x - here.point).squaredNorm();
    // Of equals the lowest, so that any order will do.
    if (!(squared < best || (squared == best && t < triangle && triangle != HD_NO_INDEX))) return;
    if (query.way_count > 0 && !leadsElsewhere(mesh, t, here, query)) return;
    best = squared;
    foot = here;
    triangle = t;
  };
  Vicinity* const vicinity = query.vicinity;
  if (vicinity != nullptr && vicinity->holds(query.x, query.reach)) {
    Vicinity::Reached reached;
    vicinity->reach(query.x, query.x, query.reach, kAnySide, reached);
    query.work += reached.blocks + reached.count;
    for (std::uint32_t i = 0; i < reached.count; ++i) look(reached.triangle[i]);
  } else {
    const BoxTests& tests = boxTests();
    const BoxPoint point = boxPoint(query.x);
    const bool finished = walkTree(
        mesh, {query.work, query.limit},
        [&](const hd_bvh_node& node, float* key) { return tests.approach(node, point, roundedUp(best), key); },
        [&] { return roundedUp(best); },
        [&](std::uint32_t first, std::uint32_t count) {
          for (std::uint32_t t = first; t < first + count; ++t) look(t);
        });
    if (!finished && !(query.nearly && triangle != HD_NO_INDEX)) return NearestResult::kExhausted;
  }
  if (triangle == HD_NO_INDEX) return NearestResult::kNone;
  nearest = {foot.point, faceNormal(mesh, triangle), Vec3::Zero(), best, triangle, foot.kind, foot.corner};
  nearest.pseudo_normal = pseudoNormal(mesh, triangle, foot.kind, foot.corner, query.work);
  return NearestResult::kFound;
}

}  // namespace hapticd
