#include "tools/haptic-bench/load/stroke.h"

#include <array>
#include <cmath>

#include "tools/haptic-bench/model/shapes.h"

namespace haptic_bench {
namespace {

/** Waves over the directions, their heights summing to one. */
struct Wave {
  double height;
  Vec3 number;
  double phase;
};
const std::array<Wave, 4> kWaves{
    {{0.4, {5, 2, -3}, 0.3}, {0.3, {-4, 7, 2}, 1.1}, {0.2, {3, -6, 9}, 2.0}, {0.1, {-12, 5, 11}, 0.7}}};

constexpr double kAbove = 5e-3;  ///< Where the hand comes from [m].
constexpr double kStep = 1e-5;   ///< Of the differences that give tangents [rad].

}  // namespace

Vec3 BumpySphere::point(const Vec3& direction) const {
  const Vec3 u = direction.normalized();
  double waves = 0;
  for (const Wave& w : kWaves) waves += w.height * std::sin(w.number.dot(u) + w.phase);
  return radius * (1 + bumps * waves) * u;
}

Vec3 BumpySphere::normal(const Vec3& direction) const {
  const Vec3 u = direction.normalized();
  const Vec3 a = u.unitOrthogonal();
  const Vec3 b = u.cross(a);
  const Vec3 along_a = point(u + kStep * a) - point(u - kStep * a);
  const Vec3 along_b = point(u + kStep * b) - point(u - kStep * b);
  return along_a.cross(along_b).normalized();
}

Model tessellate(const BumpySphere& shape, std::uint32_t triangles) {
  int stacks = 3;
  while (4 * stacks * (stacks - 1) < static_cast<int>(triangles)) ++stacks;
  Model model = sphere(shape.radius, stacks);
  for (auto& vertex : model.vertices) {
    const Vec3 p = shape.point({vertex[0], vertex[1], vertex[2]});
    for (int k = 0; k < 3; ++k) vertex[static_cast<std::size_t>(k)] = static_cast<float>(p[k]);
  }
  return model;
}

Stroked strokeOver(const BumpySphere& shape, const Stroke& stroke, double seconds) {
  const Vec3 a(std::cos(stroke.tilt), 0, std::sin(stroke.tilt));
  const Vec3 b = Vec3(-0.3 * std::sin(stroke.tilt), 1, 0.3 * std::cos(stroke.tilt)).normalized();
  const auto direction = [&](double turn) { return Vec3(std::cos(turn) * a + std::sin(turn) * b); };
  Stroked out;
  const auto add = [&](const Vec3& u, double above) {
    const Vec3 n = shape.normal(u);
    const double depth = stroke.force / stroke.stiffness - above;
    out.hips.emplace_back(shape.point(u) - depth * n);
    out.forces.emplace_back(stroke.stiffness * std::max(0.0, depth) * n);
  };
  for (std::size_t i = 0; i < kApproach; ++i) add(direction(0), kAbove * (1 - static_cast<double>(i) / kApproach));
  double turn = 0;
  for (auto n = std::llround(seconds / kTick_s); n > 0; --n) {
    add(direction(turn), 0);
    const Vec3 along = shape.point(direction(turn + kStep)) - shape.point(direction(turn - kStep));
    turn += stroke.speed * kTick_s * 2 * kStep / along.norm();
  }
  return out;
}

}  // namespace haptic_bench
