// Samples of a surface: they lie all over each triangle, however thin it is.
#include "daemon/builder/volume/surface_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "daemon/builder/volume/mesh_volume.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

Float3 floats(const Vec3& x) { return {float(x.x()), float(x.y()), float(x.z())}; }

/** A right triangle's legs, and a shift of its corner along the longer one: needles, blades and plain ones. */
struct Thin {
  double length, width, shift;
};

TEST(SurfacePoints, LieAllOverATriangleHoweverThin) {
  const double step = 0.25e-3;
  for (const Thin& thin : {Thin{0.02, 1e-5, 0}, Thin{0.02, 1e-4, 0.5}, Thin{0.02, 6e-4, 0}, Thin{0.02, 2e-3, 1},
                           Thin{0.02, 2e-3, 0.3}, Thin{0.02, 0.015, 0.5}, Thin{1e-4, 1e-4, 0}}) {
    const Vec3 b(0, 0, 0), c(thin.length, 0, 0), a(thin.shift * thin.length, thin.width, 0);
    std::vector<SurfaceSample> samples;
    const Float3 corners[] = {floats(a), floats(b), floats(c)};
    const Index3 triangle[] = {{0, 1, 2}};
    sampleSurface(corners, triangle, step, [&](const SurfaceSample& s) { samples.push_back(s); });
    const double area = 0.5 * thin.length * thin.width;
    double sum = 0;
    Vec3 middle = Vec3::Zero();
    for (const SurfaceSample& s : samples) {
      sum += s.area;
      middle += s.area * s.x;
      EXPECT_NEAR(s.normal.z(), 1, 1e-9);
      EXPECT_LE(s.area, 1.01 * step * step);
    }
    EXPECT_NEAR(sum, area, 1e-6 * area);
    EXPECT_LT((middle / sum - (a + b + c) / 3).norm(), 1e-8);
    // No place of the triangle is farther from a sample than a piece is large.
    double farthest = 0;
    for (int i = 0; i <= 200; ++i) {
      for (const double t : {0.0, 0.1, 0.5}) {
        const Vec3 x = b + i / 200.0 * (c - b) + t * (a - b - i / 200.0 * (c - b));
        double nearest = 1;
        for (const SurfaceSample& s : samples) nearest = std::min(nearest, (s.x - x).norm());
        farthest = std::max(farthest, nearest);
      }
    }
    EXPECT_LT(farthest, 1.5 * step) << thin.width << " " << thin.shift;
    EXPECT_LT(samples.size(), 4 * (area / (step * step) + thin.length / step + 1));
  }
}

/** What a build may take is refused by it before any memory is. */
TEST(SurfacePoints, AreNoMoreThanIsSaidBefore) {
  const double step = 0.25e-3;
  Random random(seedOf(7));
  double tightest = 0;
  for (int i = 0; i < 3000; ++i) {
    const double size = std::pow(10, random.in(-4, -1.7)), thin = std::pow(10, random.in(-5, 0));
    const Vec3 b = random.vector(size), c = random.vector(size);
    const Vec3 a = b + random.in(0, 1) * (c - b) + thin * random.vector(size);
    const Float3 corners[] = {floats(a), floats(b), floats(c)};
    const Index3 triangle[] = {{0, 1, 2}};
    double count = 0;
    sampleSurface(corners, triangle, step, [&](const SurfaceSample&) { ++count; });
    const double most = mostSamples(a, b, c, step);
    ASSERT_LE(count, most) << size << " " << thin;
    tightest = std::max(tightest, count / most);
  }
  EXPECT_GT(tightest, 0.9) << "and no more than need be";
}

/** Triangles much smaller than a voxel are counted: an estimate for each would refuse fine meshes that fit. */
TEST(SurfacePoints, OfFineMeshesAreCounted) {
  test::TestMesh ball = test::sphereMesh(0.01, 60);
  const double voxel = 5e-3;
  double samples = 0;
  sampleSurface(ball.vertices, ball.triangles, voxel / kSamplesPerVoxel, [&](const SurfaceSample&) { ++samples; });
  BuildMonitor monitor;
  EXPECT_EQ(extentOf(*ball.view(), voxel, monitor)->samples, samples);
}

/** Each is one of them: those wanted nearer to one another cost no more. */
TEST(SurfacePoints, WantedNearerThanTheSamplesAreTheSamples) {
  test::TestMesh ball = test::sphereMesh(0.05, 60);
  const double voxel = 1e-3;
  VolumeOptions options;
  options.point_spacing_m = 1e-6;
  BuildMonitor monitor;
  const SurfaceExtent extent = *extentOf(*ball.view(), voxel, monitor);
  EXPECT_LT(bytesToBuild(latticeAbout(Vec3::Constant(-0.05), Vec3::Constant(0.05), voxel), extent, options), 300e6);
  const auto volume = buildMeshVolume(ball.vertices, ball.triangles, voxel, options, monitor);
  ASSERT_TRUE(volume.ok()) << toString(volume.error());
}

TEST(SurfacePoints, AreAllKeptHoweverNearToOneAnotherTheyAreWanted) {
  const test::TestMesh ball = test::sphereMesh(0.05, 12);
  std::vector<SurfaceSample> samples;
  sampleSurface(ball.vertices, ball.triangles, 5e-3, [&](const SurfaceSample& s) { samples.push_back(s); });
  for (const double spacing : {1e-6, 1e-21, 1e-300})
    EXPECT_EQ(thinOut(samples, Vec3::Constant(-0.06), spacing).size(), samples.size()) << spacing;
}

/** Of a mesh that is fine for its voxels each pair of points in one is looked at: for hours, of millions. */
TEST(SurfacePoints, StopsWhereItIsAskedToHoweverManyAreInAPlace) {
  struct Case {
    const char* stage;
    double voxel;
    int rings;
  };
  for (const Case& c : {Case{"measuring the surface", 1e-3, 30}, Case{"making patches", 0.1, 60}}) {
    test::TestMesh ball = test::sphereMesh(0.05, c.rings);
    VolumeOptions options;
    options.point_spacing_m = 1e-6;
    BuildMonitor monitor;
    int told = 0, after = 0;
    bool stopped = false;
    monitor.progress = [&](float, const char* stage) {
      after += stopped ? 1 : 0;
      told += std::strcmp(stage, c.stage) == 0 ? 1 : 0;
      stopped = stopped || told == 3;
      return !stopped;
    };
    const auto volume = buildMeshVolume(ball.vertices, ball.triangles, c.voxel, options, monitor);
    EXPECT_FALSE(volume.ok()) << c.stage << " told " << told;
    if (volume.ok()) continue;
    EXPECT_EQ(volume.error().code, ErrorCode::kCancelled) << toString(volume.error());
    EXPECT_EQ(after, 0) << c.stage;
  }
}

/** A star of needles has next to no area. */
TEST(SurfacePoints, OfNeedlesCostWhatTheyAreMany) {
  for (const double width : {1e-6, 1e-5, 1e-3, 1e-2}) {
    test::TestMesh star;
    for (int i = 0; i < 500; ++i) {
      const double turn = 0.0126 * i;
      const std::uint32_t tip = star.addVertex({0.05 * std::cos(turn), 0.05 * std::sin(turn), 1e-4 * i});
      const std::uint32_t foot = star.addVertex({0, 0, 1e-4 * i});
      star.addTriangle(star.addVertex({0, 0, 1e-4 * i + width}), foot, tip);
    }
    const double voxel = 0.5e-3;
    double samples = 0;
    sampleSurface(star.vertices, star.triangles, voxel / kSamplesPerVoxel, [&](const SurfaceSample&) { ++samples; });
    BuildMonitor monitor;
    const SurfaceExtent extent = *extentOf(*star.view(), voxel, monitor);
    EXPECT_GE(extent.samples, samples) << width;
    EXPECT_LT(extent.samples, 1.15 * samples) << width;
    EXPECT_GE(bytesToBuild(latticeAbout({0, 0, 0}, {0.01, 0.01, 0.01}, voxel, 2), extent, {}), 88 * samples) << width;
  }
}

/** Of facets as wide as a quarter of a voxel and as long as the cylinder each has a voxel wherever it goes. */
TEST(SurfacePoints, ACylinderOfLongFacetsHasPointsAllAlong) {
  constexpr int kAround = 96;
  const double radius = 0.005, half = 0.02, voxel = 0.001;
  test::TestMesh mesh;
  for (int i = 0; i < kAround; ++i) {
    const double a = 2 * EIGEN_PI * i / kAround;
    mesh.addVertex({radius * std::cos(a), radius * std::sin(a), -half});
    mesh.addVertex({radius * std::cos(a), radius * std::sin(a), half});
  }
  const std::uint32_t low = mesh.addVertex({0, 0, -half}), high = mesh.addVertex({0, 0, half});
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const std::uint32_t j = (i + 1) % kAround;
    mesh.addQuad(2 * i, 2 * j, 2 * j + 1, 2 * i + 1);
    mesh.addTriangle(low, 2 * j, 2 * i);
    mesh.addTriangle(high, 2 * i + 1, 2 * j + 1);
  }
  // The area of the mantle by slices as long as three voxels.
  std::vector<double> slice(12, 0);
  std::vector<SurfaceSample> samples;
  sampleSurface(mesh.vertices, mesh.triangles, voxel / 4, [&](const SurfaceSample& s) { samples.push_back(s); });
  for (const SurfaceSample& s : thinOut(samples, Vec3::Constant(-half - voxel), voxel / 2)) {
    if (std::abs(s.normal.z()) > 0.5) continue;
    slice[static_cast<std::size_t>(std::clamp((s.x.z() + half) / (2 * half) * 12, 0.0, 11.0))] += s.area;
  }
  const double mantle = 2 * kAround * radius * std::sin(EIGEN_PI / kAround) * 2 * half;
  for (const double area : slice) EXPECT_NEAR(area, mantle / 12, 0.05 * mantle / 12);
}

}  // namespace
}  // namespace hapticd
