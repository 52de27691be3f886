#include "rt/scene/vertex_motion.h"

#include <algorithm>

namespace hapticd {
namespace {

constexpr double kMostSpeed = 10.0;  // As of a pose that is a motion [m/s],
constexpr double kMostTime = 0.02;   // which counts as no longer, however long there was none before it [s].

Vec3 lastVelocity(const MeshView& mesh, std::uint32_t vertex) HD_RT {
  const VertexMotion& motion = mesh.deform.motion[vertex];
  const float(&now)[3] = mesh.vertices[vertex];
  const Vec3 step(double{now[0]} - motion.from[0], double{now[1]} - motion.from[1], double{now[2]} - motion.from[2]);
  return step / motion.duration;
}

Vec3 velocityOf(const MeshView& mesh, std::uint32_t vertex, double time) HD_RT {
  const VertexMotion& motion = mesh.deform.motion[vertex];
  const double age = time - motion.time;
  if (!(motion.duration > 0 && age >= 0 && age < kLatePose * motion.duration) || isJump(mesh, vertex))
    return Vec3::Zero();
  return lastVelocity(mesh, vertex);
}

}  // namespace

void noteMotion(MeshView& mesh, std::uint32_t vertex, const float (&from)[3], double time, double dt) HD_RT {
  VertexMotion& motion = mesh.deform.motion[vertex];
  if (motion.duration > 0 && motion.time == time) return;  // Twice in a tick: from where it was before both.
  motion.duration = static_cast<float>(std::clamp(time - motion.time, dt, std::max(dt, kPoseSpread)));
  motion.time = time;
  std::copy_n(from, 3, motion.from);
  mesh.deform.moved = time;
}

void forgetMotion(MeshView& mesh) noexcept {
  if (mesh.deform.motion != nullptr) std::fill_n(mesh.deform.motion, mesh.vertex_count, VertexMotion{});
  mesh.deform.moved = 0;
  mesh.deform.noted = 0;
}

bool isJump(const MeshView& mesh, std::uint32_t vertex) HD_RT {
  const double duration = mesh.deform.motion[vertex].duration, faster = std::max(1.0, duration / kMostTime);
  return !((faster * lastVelocity(mesh, vertex)).squaredNorm() <= kMostSpeed * kMostSpeed);
}

Vec3 deformingVelocity(const MeshView& mesh, std::uint32_t triangle, const Vec3& x, double time) HD_RT {
  const double age = time - mesh.deform.moved;
  if (mesh.deform.motion == nullptr || !(age >= 0 && age < kLatePose * kPoseSpread) || triangle >= mesh.triangle_count)
    return Vec3::Zero();
  const Vec3 a = mesh.vertex(triangle, 0), one = mesh.vertex(triangle, 1) - a, other = mesh.vertex(triangle, 2) - a;
  const Vec3 area = one.cross(other);
  const double area2 = area.squaredNorm();
  if (!(area2 > 0)) return Vec3::Zero();
  double weight[3] = {0, area.dot((x - a).cross(other)) / area2, area.dot(one.cross(x - a)) / area2};
  weight[0] = 1 - weight[1] - weight[2];
  Vec3 velocity = Vec3::Zero();
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double share = std::max(0.0, weight[i]);
    velocity += share * velocityOf(mesh, mesh.triangles[triangle][i], time);
    sum += share;
  }
  return velocity / sum;
}

}  // namespace hapticd
