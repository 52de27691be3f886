#include "tools/haptic-bench/load/local_client.h"

#include <algorithm>
#include <cmath>

namespace haptic_bench {
namespace {

constexpr double kModelPatience = 3;  ///< Leases, in periods: two updates may be lost.
constexpr double kLeastLease = 0.05;  ///< [s]

std::int64_t nanoseconds(double s) { return std::llround(s * 1e9); }

std::int64_t leaseOf(const ClientTiming& timing) {
  return nanoseconds(std::max(kLeastLease, kModelPatience * timing.period_s));
}

}  // namespace

const char* nameOf(Source source) {
  switch (source) {
    case Source::kNative:
      return "native";
    case Source::kPlane:
      return "plane";
    case Source::kPatch:
      return "patch";
    case Source::kForce:
      return "force";
  }
  return "?";
}

haptic_local_model fitModel(Source source, const haptic::SurfaceMesh& mesh, const Vec3& p, const Vec3& v,
                            const ClientTiming& timing) {
  haptic_local_model model{};
  model.lease_ns = leaseOf(timing);
  model.material.stiffness = timing.stiffness;
  const haptic::PatchOptions options{timing.latency_s, timing.latency_s + timing.period_s, 1e-3};
  const haptic::Vector at{p[0], p[1], p[2]};
  const haptic::Vector moving{v[0], v[1], v[2]};
  if (source == Source::kPlane) {
    // One tangent plane turns into the next while the hand goes from one place to the next.
    model.blend_ns = nanoseconds(timing.period_s);
    fitPlane(mesh, at, moving, options, model);
  } else {
    fitPatch(mesh, at, moving, options, model);  // Two patches say the same of the same place: the shortest blend.
  }
  return model;
}

haptic_client_force fitForce(const haptic::SurfaceMesh& mesh, const Vec3& p, const ClientTiming& timing) {
  haptic_client_force force{};
  force.lease_ns = leaseOf(timing);
  const haptic::Vector at{p[0], p[1], p[2]};
  const haptic::SurfaceMesh::Foot foot = mesh.nearest(at);
  if (haptic::SurfaceMesh::above(foot, at) < 0) {
    for (std::size_t k = 0; k < 3; ++k) force.force[k] = timing.stiffness * (foot.point[k] - at[k]);
  }
  return force;
}

}  // namespace haptic_bench
