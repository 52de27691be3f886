// The one-sided descent's leaf: a voxel as a point of A's surface and an area, which B's field is asked for.
#include <gtest/gtest.h>

#include <cstring>

#include "rt/contact/field_query.h"
#include "rt/contact/sphere_descent.h"
#include "rt/volume/distance.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_volume.h"
#include "tests/unit/contact/voxels.h"

namespace hapticd {
namespace {

using test::queryOf, test::surfaceVoxels, test::TestVolume;

/** Voxels' centres, settled by a kernel. */
struct Settled {
  std::vector<float> x, y, z;
  std::vector<std::uint16_t> share;
  std::uint32_t count;

  Settled(const PointKernel& kernel, const VolumeView& v, const std::vector<Vec3>& centres)
      : count(static_cast<std::uint32_t>(centres.size())) {
    for (const Vec3& c : centres) {
      x.push_back(static_cast<float>(c.x()));
      y.push_back(static_cast<float>(c.y()));
      z.push_back(static_cast<float>(c.z()));
    }
    const std::size_t padded = (centres.size() + 15) / 16 * 16;
    x.resize(padded);
    y.resize(padded);
    z.resize(padded);
    share.resize(padded);
    kernel.settle(fieldOf(v), placementIn(v, {}), {x.data(), y.data(), z.data(), share.data(), v.voxel, 1}, count);
  }
  [[nodiscard]] Vec3 at(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

TEST(Settle, PutsVoxelsOnTheSurfaceAndSharesItsAreaOut) {
  const double radius = 0.012, ring = 0.012, tube = 0.005;
  const TestVolume sphere = test::sphereVolume(radius, 0.0005, 60), torus = test::torusVolume(ring, tube, 0.0005);
  const TestVolume box = test::boxVolume({0.0101, 0.0072, 0.0123}, 0.0005);
  struct Case {
    const VolumeView& view;
    double area;
    std::function<double(const Vec3&)> distance;
  };
  const Case cases[] = {
      {sphere.view, 4 * M_PI * radius * radius, [&](const Vec3& p) { return p.norm() - radius; }},
      {torus.view, 4 * M_PI * M_PI * ring * tube,
       [&](const Vec3& p) { return std::hypot(p.head<2>().norm() - ring, p.z()) - tube; }},
      {box.view, 8 * (0.0101 * 0.0072 + 0.0072 * 0.0123 + 0.0123 * 0.0101), nullptr},
  };
  for (const Case& c : cases) {
    const std::vector<Vec3> voxels = surfaceVoxels(c.view);
    const Settled got(pointKernel(), c.view, voxels);
    const double face = std::pow(c.view.voxel, 2) / kShareSteps;
    double area = 0, worst = 0;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      area += face * got.share[i];
      if (c.distance != nullptr) worst = std::max(worst, std::abs(c.distance(got.at(i))));
      EXPECT_LT((got.at(i) - voxels[i]).norm(), 0.87 * c.view.voxel);
    }
    EXPECT_NEAR(area, c.area, 0.03 * c.area);
    // The interpolated field alone is off by up to v^2/8 times the curvatures' sum: 5 and 11 um.
    EXPECT_LT(worst, 0.004 * c.view.voxel);
  }
}

/** A plate whose middle lies `shift` voxels beside a layer of lattice points, for what stands on it reaches farther. */
TestVolume plate(double thick, double shift, double voxel) {
  test::TestMesh mesh = test::boxMesh({0.01, 0.01, thick / 2});
  const test::TestMesh knob = test::boxMesh(Vec3::Constant(0.001));
  for (const double end : {0.002 + 2 * shift * voxel, -0.002}) {
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    const double begin = std::copysign(thick / 2 + 0.0005, end), low = std::min(begin, end), high = begin + end - low;
    for (const auto& v : knob.vertices) mesh.addVertex({v[0], v[1], v[2] < 0 ? low : high});
    for (const auto& t : knob.triangles) mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
  return test::volumeOfMesh(mesh, voxel);
}

/** In the middle between two walls the field has no slope: what stood there counted for up to 75 faces. */
TEST(Settle, NoVoxelStandsForMoreThanAPlaneCutsOutOfIt) {
  for (const double thick : {0.2, 0.5, 1.0, 2.0}) {
    for (const double shift : {0.0, 0.25, 0.5}) {
      const TestVolume volume = plate(thick * 0.0005, shift, 0.0005);
      const std::vector<Vec3> voxels = surfaceVoxels(volume.view);
      const Settled got(pointKernel(), volume.view, voxels);
      for (std::size_t i = 0; i < voxels.size(); ++i)
        ASSERT_LE(got.share[i], 1.42F * kShareSteps) << thick << " " << shift << " at " << voxels[i].transpose();
    }
  }
}

TEST(Settle, IsTheSameOnEveryPath) {
  const PointPath best = pointPath();
  for (const TestVolume& volume : {test::torusVolume(0.012, 0.004, 0.001), plate(0.001, 0.5, 0.001)}) {
    std::vector<Vec3> places = surfaceVoxels(volume.view);
    Random random(seedOf(3));
    for (int i = 0; i < 3000; ++i) places.push_back(random.vector(0.03));  // Some beyond the lattice.
    const Settled expected(kPortablePointKernel, volume.view, places);
    for (const PointPath path : {PointPath::kAvx2, PointPath::kAvx512}) {
      if (!choosePointPath(path)) continue;
      const Settled got(pointKernel(), volume.view, places);
      const std::size_t bytes = expected.x.size() * sizeof(float);
      EXPECT_EQ(std::memcmp(got.x.data(), expected.x.data(), bytes), 0);
      EXPECT_EQ(std::memcmp(got.y.data(), expected.y.data(), bytes), 0);
      EXPECT_EQ(std::memcmp(got.z.data(), expected.z.data(), bytes), 0);
      EXPECT_EQ(got.share, expected.share);
    }
    ASSERT_TRUE(choosePointPath(best));
  }
}

TEST(SphereDescent, OneSidedFindsWhatTheFieldSaysOfEachVoxelsPoint) {
  const TestVolume a = test::torusVolume(0.012, 0.004, 0.001);
  const TestVolume b = test::sphereVolume(0.012, 0.001);
  const auto voxels = surfaceVoxels(a.view);
  const Settled points(kPortablePointKernel, a.view, voxels);
  SphereDescentDetector detector({.leaf = SphereLeaf::kFieldValue});
  Random random(seedOf(4));
  ContactSet contacts;
  std::uint64_t total = 0;
  const double face = std::pow(a.view.voxel, 2) / kShareSteps;
  const double whole = kShareSteps * face;  // single precision leaves 1e-7 m of the depth of each such face undecided
  for (int i = 0; i < 50; ++i) {
    const Pose X_BA = random.pose(0.02);
    std::uint32_t sure = 0, most = 0;
    Vec3 force = Vec3::Zero();
    double area = 0, between = 0;
    for (std::size_t k = 0; k < voxels.size(); ++k) {
      const Vec3 x = X_BA * points.at(k);
      const DistanceSample s = distanceAt(b.view, x);
      sure += s.value < -1e-7 ? 1 : 0;
      most += s.value < 1e-7 ? 1 : 0;
      if (s.value >= 0) continue;
      force -= face * points.share[k] * s.value * s.gradient;
      area += face * points.share[k];
      // At the border of two cells rounding decides whose gradient it is.
      const Vec3 step = Vec3::Constant(1e-7);
      const Vec3 jump = distanceAt(b.view, x + step).gradient - distanceAt(b.view, x - step).gradient;
      between -= face * points.share[k] * s.value * jump.norm();
    }
    detector.find(queryOf(a, b, X_BA), contacts);
    EXPECT_GE(contacts.report.touching, sure);
    EXPECT_LE(contacts.report.touching, most);
    EXPECT_NEAR(contacts.touching_area, area, 2e-3 * area + 3e-6 * (most - sure));
    EXPECT_LE((contacts.integral.force - force).norm(),
              2e-3 * force.norm() + whole * 1e-7 * (1 + most - sure) + between);
    total += sure;
  }
  EXPECT_GT(total, 1000u);
}

// A ball pressed into a plane by much less than a voxel: depth integrated over its cap is pi R d^2, less a d/R-th part.
TEST(SphereDescent, OneSidedTellsAShallowTouchsForce) {
  const double radius = 0.02, voxel = 0.0005;
  const TestVolume ball = test::sphereVolume(radius, voxel, 120);
  const TestVolume plate = test::boxVolume({0.03, 0.03, 0.01}, voxel);
  SphereDescentDetector detector({.leaf = SphereLeaf::kFieldValue});
  ContactSet contacts;
  Random random(seedOf(8));
  for (const double depth : {0.05e-3, 0.1e-3, 0.25e-3, 1e-3}) {
    const double truth = M_PI * radius * depth * depth, cap = 2 * M_PI * radius * depth;
    double mean = 0, area = 0;
    constexpr int kPoses = 40;
    for (int i = 0; i < kPoses; ++i) {
      Pose X = random.pose(0.005);
      X.p.z() = 0.01 + radius - depth;
      detector.find(queryOf(ball, plate, X), contacts);
      const Vec3 f = contacts.integral.force;
      mean += f.z() / kPoses;
      area += contacts.touching_area / kPoses;
      EXPECT_NEAR(f.z(), truth, depth < 0.2e-3 ? 0.35 * truth : 0.12 * truth) << depth;
      EXPECT_LT(f.head<2>().norm(), 0.02 * f.z());
      EXPECT_NEAR(contacts.deepest, depth, 0.02 * voxel + 0.3 * depth);
    }
    EXPECT_NEAR(mean, truth, 0.05 * truth) << depth;
    EXPECT_NEAR(area, cap, 0.05 * cap) << depth;
  }
}

}  // namespace
}  // namespace hapticd
