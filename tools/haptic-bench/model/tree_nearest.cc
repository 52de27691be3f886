#include "tools/haptic-bench/model/tree_nearest.h"

#include <cmath>
#include <limits>

#include "rt/geometry/nearest/nearest.h"
#include "tools/haptic-bench/model/built_mesh.h"

namespace haptic_bench {

TreeNearest::TreeNearest(const Model& model) : mesh_(buildMesh(model)) {}

SurfacePoint TreeNearest::find(const Vec3& x) const {
  hapticd::NearestQuery query;
  query.x = x;
  query.limit = std::numeric_limits<std::uint32_t>::max();
  hapticd::Nearest nearest;
  SurfacePoint found;
  if (hapticd::nearestOnMesh(mesh_.view, query, nearest) != hapticd::NearestResult::kFound) return found;
  found.point = nearest.point;
  found.normal = nearest.pseudo_normal;
  found.distance = std::sqrt(nearest.squared_distance);
  found.inside = nearest.isInside(x);
  found.triangle = nearest.feature;
  return found;
}

}  // namespace haptic_bench
