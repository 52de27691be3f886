#include "daemon/builder/volume/mass.h"

#include "rt/base/math.h"

namespace hapticd {

hd_volume_mass massOf(std::span<const Float3> vertices, std::span<const Index3> triangles) {
  const auto point = [&](std::uint32_t v) { return Vec3(vertices[v][0], vertices[v][1], vertices[v][2]); };
  const Vec3 apex = point(triangles.front()[0]);
  double volume = 0;
  Vec3 first = Vec3::Zero();   // Integral of x from the apex.
  Mat3 second = Mat3::Zero();  // Integral of x x^T.
  for (const Index3& t : triangles) {
    const Vec3 a = point(t[0]) - apex, b = point(t[1]) - apex, c = point(t[2]) - apex, sum = a + b + c;
    const double v = a.dot(b.cross(c)) / 6;
    volume += v;
    first += v / 4 * sum;
    second += v / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  const Vec3 mean = first / volume;
  const Mat3 about = second - volume * mean * mean.transpose();
  const Mat3 inertia = about.trace() * Mat3::Identity() - about;
  const Vec3 centroid = apex + mean;
  return {volume,
          {centroid.x(), centroid.y(), centroid.z()},
          {inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(1, 2), inertia(2, 0)}};
}

}  // namespace hapticd
