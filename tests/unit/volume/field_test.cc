// Distances, points and mass of volumes against closed forms.
#include <algorithm>
#include <random>

#include "rt/volume/distance.h"
#include "rt/volume/octahedral.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/test_volume.h"

namespace hapticd::test {
namespace {

TEST(Volume, distanceIsWithinItsStatedErrorEverywhere) {
  const Vec3 half(0.021, 0.013, 0.008);
  const double s = 0.001;
  const TestVolume box = boxVolume(half, s);
  const Shape shape{ShapeKind::kBox, half};
  std::mt19937 random(seedOf(1));
  int fine = 0, inside = 0, beyond = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 x = randomPoint(random, i % 2 == 0 ? 0.06 : 0.022);
    const DistanceSample got = distanceAt(box.view, x);
    const double truth = distanceTo(shape, x);
    EXPECT_LE(std::abs(got.value - truth), got.error) << x.transpose();
    fine += got.fine;
    inside += truth < -4 * s;
    beyond += truth > 20 * s;
    // Over a face, away from edges, the field is linear: interpolation adds nothing.
    const Vec3 clear = (half - x.cwiseAbs());
    if (got.fine && clear.x() > 8 * s && clear.y() > 8 * s && std::abs(clear.z()) < s) {
      EXPECT_NEAR(got.value, truth, 0.51 * box.view.fine_step);
      EXPECT_NEAR(got.gradient.z(), std::copysign(1, x.z()), 1e-3);
      EXPECT_LT(got.gradient.head<2>().norm(), 1e-3);
    }
  }
  EXPECT_GT(fine, 1000);
  EXPECT_GT(inside, 300);
  EXPECT_GT(beyond, 1000);
}

TEST(Volume, gradientPointsTheWayOutFromDeepInside) {
  const double radius = 0.04;
  const TestVolume ball = sphereVolume(radius, 0.001);
  std::mt19937 random(seedOf(2));
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x = randomPoint(random, 0.1);
    if (x.norm() < 0.015) continue;  // About the centre all directions are alike.
    const DistanceSample got = distanceAt(ball.view, x);
    // Coarse cells see the field bend: by the square of their size over the distance from the centre.
    EXPECT_GT(got.gradient.normalized().dot(x.normalized()), std::min(0.97, 1 - 1.5e-5 / x.squaredNorm()))
        << x.transpose();
    EXPECT_NEAR(got.value, x.norm() - radius, got.fine ? 3e-5 : x.norm() > 0.04 ? got.error : 2e-3);
  }
}

TEST(Volume, gradientIsTheSlopeOfTheValue) {
  const TestVolume torus = torusVolume(0.03, 0.01, 0.001);
  std::mt19937 random(seedOf(3));
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x = randomPoint(random, 0.04).cwiseProduct(Vec3(1, 1, 0.25));  // Within the lattice.
    const DistanceSample got = distanceAt(torus.view, x);
    for (int k = 0; k < 3; ++k) {
      const double h = 1e-8;
      const DistanceSample to = distanceAt(torus.view, x + h * Vec3::Unit(k));
      if (to.fine != got.fine || std::abs(to.gradient[k] - got.gradient[k]) > 1e-9) continue;  // Another cell's.
      EXPECT_NEAR((to.value - got.value) / h, got.gradient[k], 1e-5);
    }
  }
}

TEST(Volume, ofAMeshIsTheExactDistance) {
  std::mt19937 random(seedOf(4));
  TestMesh mesh = crumpled(random, 8);
  const TestVolume volume = volumeOfMesh(mesh, 0.05);
  MeshView* const view = mesh.view();
  int fine = 0;
  for (std::uint32_t n = 0; n < 4000; ++n) {
    // At lattice points the samples stand themselves.
    const Vec3 at(static_cast<double>(random() % (8 * volume.view.cells[0])),
                  static_cast<double>(random() % (8 * volume.view.cells[1])),
                  static_cast<double>(random() % (8 * volume.view.cells[2])));
    const Vec3 x = volume.view.originPoint() + double{volume.view.voxel} * at;
    const DistanceSample got = distanceAt(volume.view, x);
    if (!got.fine) continue;
    ++fine;
    EXPECT_NEAR(std::abs(got.value), distanceTo(*view, x), 1.1 * volume.view.fine_step);
    if (std::abs(got.value) > 1e-3) {
      EXPECT_EQ(got.value<0, windingNumber(*view, x)> 0.5) << x.transpose();
    }
  }
  EXPECT_GT(fine, 500);
}

TEST(Volume, pointsCarryTheWholeAreaAndItsVector) {
  std::mt19937 random(seedOf(5));
  TestMesh mesh = crumpled(random, 10);
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const auto p = [&](std::uint32_t v) { return Vec3(mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2]); };
    area += (p(t[1]) - p(t[0])).cross(p(t[2]) - p(t[0])).norm() / 2;
  }
  const MeshView* const view = mesh.view();
  for (const double spacing : {0.0, 0.15}) {
    VolumeOptions options;
    options.point_spacing_m = spacing;
    const TestVolume volume = volumeOfMesh(mesh, 0.05, options);
    double sum = 0;
    for (std::uint32_t i = 0; i < volume.view.point_count; ++i) {
      sum += volume.view.area[i] * double{volume.view.area_step};
      if (i % 61 == 0) {
        EXPECT_LT(distanceTo(*view, volume.view.pointAt(i)), 1e-6);
      }
    }
    EXPECT_NEAR(sum, area, 1e-4 * area);
    EXPECT_NEAR(volume.view.header->area, area, 1e-9 * area);
    double of_patches = 0;
    for (const hd_volume_patch& p : volume.view.patches) of_patches += double{p.area};
    EXPECT_NEAR(of_patches, area, 1e-5 * area);
  }
}

/** Its lattice reaches beyond what a mesh may: such a volume was built, and then refused as damaged. */
TEST(Volume, ofAMeshAsLargeAsThereMayBeIsOpened) {
  const Vec3 half(HD_MAX_COORDINATE, 3, 3);
  const TestVolume box = volumeOfMesh(boxMesh(half), 0.9);
  ASSERT_NE(box.view.header, nullptr);
  EXPECT_NEAR(distanceAt(box.view, Vec3(HD_MAX_COORDINATE - 0.9, 0, 0)).value, -0.9, 0.01);
}

TEST(Volume, bothSidesOfAThinWallHavePoints) {
  const TestVolume wall = boxVolume(Vec3(0.01, 0.01, 0.0001), 0.001);  // A fifth of a voxel thick.
  double up = 0, down = 0;
  for (std::uint32_t i = 0; i < wall.view.point_count; ++i) {
    const double z = octahedralNormal(wall.view.normal[i]).z(), a = wall.view.area[i] * double{wall.view.area_step};
    (z > 0.9 ? up : z < -0.9 ? down : up) += std::abs(z) > 0.9 ? a : 0;
  }
  EXPECT_NEAR(up, 4e-4, 1e-7);
  EXPECT_NEAR(down, 4e-4, 1e-7);
}

TEST(Volume, firstPartsOfAPatchCoverIt) {
  const TestVolume ball = sphereVolume(0.02, 0.0005, 64);
  for (const hd_volume_patch& patch : ball.view.patches) {
    if (patch.count < 16) continue;
    const std::uint32_t quarter = (patch.count + 3) / 4;
    double worst = 0;
    for (std::uint32_t i = patch.first; i < patch.first + patch.count; ++i) {
      double nearest = 1;
      for (std::uint32_t q = patch.first; q < patch.first + quarter; ++q)
        nearest = std::min(nearest, (ball.view.pointAt(i) - ball.view.pointAt(q)).norm());
      worst = std::max(worst, nearest);
    }
    EXPECT_NEAR(worst, patch.spread, 1e-6);
    // A quarter of the points, each twice as far from the next: no hole is wider than a few spacings.
    EXPECT_LT(worst, 2.5 * std::sqrt(double{patch.area} / quarter));
  }
}

TEST(Volume, massIsThatOfTheSolid) {
  const Vec3 half(0.03, 0.02, 0.01), at(0.5, -0.2, 0.1);
  const TestVolume box = volumeOf(
      boxMesh(half, at),
      [=](const Vec3& x) {
        return distanceTo(Shape{ShapeKind::kBox, half}, x - at);
      },
      0.002);
  const double v = 8 * half.prod();
  const hd_volume_mass& m = box.view.mass;
  EXPECT_NEAR(m.volume, v, 1e-6 * v);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(m.centroid[k], at[k], 1e-7);
    const double b = half[(k + 1) % 3], c = half[(k + 2) % 3];
    EXPECT_NEAR(m.inertia[k], v * (b * b + c * c) / 3, 1e-5 * m.inertia[0]);
    EXPECT_NEAR(m.inertia[3 + k], 0, 1e-6 * m.inertia[0]);
  }
}

TEST(Octahedral, isOffByLessThanItSays) {
  std::mt19937 random(seedOf(6));
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 n = randomPoint(random, 1).normalized();
    worst = std::max(worst, (octahedralNormal(octahedralBits(n)) - n).norm());
  }
  EXPECT_LT(worst, 0.004 * M_PI / 180);
  for (int k = 0; k < 6; ++k) {
    const Vec3 n = (k < 3 ? 1 : -1) * Vec3::Unit(k % 3);
    EXPECT_LT((octahedralNormal(octahedralBits(n)) - n).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace hapticd::test
