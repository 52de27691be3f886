#include "tools/haptic-bench/collide/truth.h"

#include "rt/geometry/nearest/nearest.h"
#include "tools/haptic-bench/model/built_mesh.h"

namespace haptic_bench {

using hapticd::Pose;

Truth::Truth(const Model& base, const Model& tool, int split) : base_(buildMesh(base)) {
  for (std::uint32_t t = 0; t < tool.triangles.size(); ++t) {
    const Vec3 a = tool.corner(t, 0), u = (tool.corner(t, 1) - a) / split, v = (tool.corner(t, 2) - a) / split;
    const double area = 0.5 * u.cross(v).norm();
    for (int i = 0; i < split; ++i) {
      for (int j = 0; i + j < split; ++j) {
        samples_.push_back({a + (i + 1.0 / 3) * u + (j + 1.0 / 3) * v, area});
        if (i + j + 2 <= split) samples_.push_back({a + (i + 2.0 / 3) * u + (j + 2.0 / 3) * v, area});
      }
    }
  }
}

Penalty Truth::at(const Pose& tool, double reach) const {
  Penalty sum;
  for (const Sample& s : samples_) {
    const Vec3 r = tool.q * s.p;
    hapticd::NearestQuery query;
    query.x = r + tool.p;
    query.reach = reach;
    query.limit = 10'000'000;
    hapticd::Nearest nearest;
    if (hapticd::nearestOnMesh(base_.view, query, nearest) != hapticd::NearestResult::kFound) continue;
    if (!nearest.isInside(query.x)) continue;
    const Vec3 out = nearest.point - query.x;  // Its length is the depth.
    sum.integral.force += s.area * out;
    sum.integral.torque += s.area * r.cross(out);
    sum.volume += s.area * out.norm();
    sum.area += s.area;
    sum.deepest = std::max(sum.deepest, out.norm());
  }
  return sum;
}

WrenchError compare(const hapticd::Wrench& wrench, const hapticd::Wrench& truth, double peak, double lever) {
  WrenchError error;
  error.force = (wrench.force - truth.force).norm() / peak;
  error.torque = (wrench.torque - truth.torque).norm() / (peak * lever);
  const double product = wrench.force.norm() * truth.force.norm();
  if (product > 0) error.direction = std::atan2(wrench.force.cross(truth.force).norm(), wrench.force.dot(truth.force));
  return error;
}

}  // namespace haptic_bench
