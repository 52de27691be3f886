// What is nearer beyond the ridges of a flat side, however that is cut, against all ridges of it about the foot.
#include "rt/render/proxy/flat_side.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/render/proxy/proxy_step.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

using test::TestMesh;

constexpr double kEdge = 0.005;     ///< Half of the flat square's [m].
constexpr std::uint32_t kCut = 4;   ///< It has twice the square of that many triangles.
constexpr double kFlatBelow = 0.1;  ///< Times a triangle's side: what is less deep is of the flat square.

/** As the square is skewed. */
Vec3 skewed(const Vec3& x, double skew) { return {x.x() + skew * x.y(), x.y(), x.z()}; }

/** A flat square, skewed, and beyond each of its edges a side that falls, or rises. */
TestMesh plateau(Random& random, const Pose& X, double skew) {
  std::array<double, 4> falls;
  for (double& fall : falls) fall = random.once(6) ? -0.5 : std::tan(random.in(0.3, 1.2));
  TestMesh mesh = test::heightMesh(2 * kEdge, 2 * kCut, [&](double x, double y) {
    return -falls[x > 0 ? 0 : 1] * std::max(0.0, std::abs(x) - kEdge) -
           falls[y > 0 ? 2 : 3] * std::max(0.0, std::abs(y) - kEdge);
  });
  for (auto& v : mesh.vertices) {
    const Vec3 x = X * skewed({v[0], v[1], v[2]}, skew);
    v = {static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())};
  }
  return mesh;
}

double distanceToSegment(const Vec3& a, const Vec3& b, const Vec3& x) {
  const double t = (x - a).dot(b - a) / (b - a).squaredNorm();
  if (t > 0 && t < 1) return (x - a).cross(b - a).norm() / (b - a).norm();
  return std::min((x - a).norm(), (x - b).norm());
}

/** How deep x is below the plane of triangle t. */
double depthBelow(const MeshView& mesh, std::uint32_t t, const Vec3& x) {
  const Vec3 a = mesh.vertex(t, 0), n = (mesh.vertex(t, 1) - a).cross(mesh.vertex(t, 2) - a).normalized();
  return n.dot(a - x);
}

/** Of the planes beyond ridges of the square that come so near to the foot as a turn of 60 degrees asks, the nearest
 * to the hip; infinite: none is nearer than the square. */
double nearestBeyond(const MeshView& mesh, const Pose& X, const Vec3& hip, double depth) {
  const Vec3 foot = X * Vec3(hip.x(), hip.y(), 0), x = X * hip;
  const auto isFlat = [&](std::uint32_t t) {
    double most = 0;
    for (int k = 0; k < 3; ++k) most = std::max(most, std::abs((X.inverse() * mesh.vertex(t, k)).z()));
    return most < kFlatBelow * kEdge / kCut;
  };
  double least = depth;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    if (!isFlat(t)) continue;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t across = mesh.neighbours[t][k];
      if (isFlat(across) ||
          distanceToSegment(mesh.vertex(t, k), mesh.vertex(t, (k + 1) % 3), foot) * std::sqrt(3) > depth)
        continue;
      bool falls = true;
      for (int i = 0; i < 3; ++i)
        falls = falls && (X.inverse() * mesh.vertex(across, i)).z() < kFlatBelow * kEdge / kCut;
      const double below = depthBelow(mesh, across, x);
      if (falls && below > 0) least = std::min(least, below);
    }
  }
  return least < depth ? least : INFINITY;
}

/** The face of the square over which the hip is. */
std::uint32_t faceOver(const MeshView& mesh, const Vec3& x, const Vec3& up) {
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    SeenFace face(mesh, t);
    face.seek(x);
    if (face.out() < 0 && face.up.normalized().dot(up) > 1 - 1e-6) return t;
  }
  return HD_NO_INDEX;
}

TEST(FlatSide, TheNearestPlaneBeyondItsRidgesIsFoundHoweverItIsCut) {
  int nearer = 0, none = 0;
  forSeeds(600, [&](unsigned seed) {
    Random random(seed);
    const Pose X = random.pose(0.01);
    const double skew = random.in(-1, 1);
    TestMesh made = plateau(random, X, skew);
    const MeshView& mesh = *made.view();
    const double depth = std::pow(10, random.in(-4, -1.7));
    const double x = random.in(-kEdge, kEdge), y = random.in(-kEdge, kEdge);
    const Vec3 hip = skewed({x, y, -depth}, skew);
    const std::uint32_t over = faceOver(mesh, X * hip, X.q * Vec3::UnitZ());
    ASSERT_NE(over, HD_NO_INDEX);
    SeenFace face(mesh, over);
    face.seek(X * hip);
    std::uint32_t work = 0;
    const std::uint32_t found = nearerThanSide(face, X * hip, depth, kMaxOfSide, work);
    const double least = nearestBeyond(mesh, X, hip, depth);
    ASSERT_EQ(found != HD_NO_INDEX, std::isfinite(least)) << depth;
    EXPECT_LT(work, 2 * kCut * kCut);
    (found != HD_NO_INDEX ? nearer : none) += 1;
    if (found != HD_NO_INDEX) {
      EXPECT_NEAR(depthBelow(mesh, found, X * hip), least, 1e-7 * depth);
    }
    EXPECT_EQ(nearerThanSide(face, X * hip, -depth, kMaxOfSide, work), HD_NO_INDEX) << "in the air";
  });
  EXPECT_GT(nearer, drawn(60));
  EXPECT_GT(none, drawn(60));
}

/** A side that goes on far beyond what may be looked at. */
TEST(FlatSide, NoMoreOfItIsLookedAtThanAsked) {
  TestMesh made = test::heightMesh(0.01, 40, [](double, double) { return 0.0; });
  const MeshView& mesh = *made.view();
  const Vec3 hip(1e-4, 5e-5, -0.008);
  SeenFace face(mesh, faceOver(mesh, hip, Vec3::UnitZ()));
  face.seek(hip);
  for (const int most : {1, 2, 7, kMaxOfSide}) {
    std::uint32_t work = 0;
    EXPECT_EQ(nearerThanSide(face, hip, 0.008, most, work), HD_NO_INDEX);
    EXPECT_EQ(work, static_cast<std::uint32_t>(most - 1));
  }
}

TEST(FlatSide, AnEdgeIsAsFarAsItsNearestPoint) {
  Random random(seedOf(3));
  for (int i = 0; i < 1000; ++i) {
    TestMesh made;
    for (int k = 0; k < 3; ++k) (void)made.addVertex(random.vector(1));
    made.addTriangle(0, 1, 2);
    const MeshView& mesh = *made.view();
    const Vec3 x = random.vector(2);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Vec3 a = mesh.vertex(0, static_cast<int>(k)), b = mesh.vertex(0, static_cast<int>((k + 1) % 3));
      EXPECT_NEAR(distanceToEdge(mesh, 0, k, x), distanceToSegment(a, b, x), 1e-12);
    }
  }
}

}  // namespace
}  // namespace hapticd
