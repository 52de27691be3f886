// Volumes of open meshes whose holes are filled, against the solids that they should be.
#include <gmock/gmock.h>

#include <cstring>

#include "rt/volume/distance.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/test_volume.h"

namespace hapticd::test {
namespace {

constexpr double kRadius = 0.02, kVoxel = 0.001;
constexpr std::uint32_t kStacks = 48;
const double kCut = kRadius * std::cos(M_PI * 14 / kStacks);  // Where a ring of vertices stands: the hole is flat.
const double kRim = kRadius * std::sin(M_PI * 14 / kStacks);

/** A sphere without what is above kCut. */
TestMesh bowl(bool inward = false) {
  const TestMesh sphere = sphereMesh(kRadius, kStacks);
  TestMesh mesh;
  mesh.vertices = sphere.vertices;
  for (auto t : sphere.triangles) {
    const auto above = [&](std::uint32_t v) { return double{sphere.vertices[v][2]} > kCut + 1e-6; };
    if (above(t[0]) || above(t[1]) || above(t[2])) continue;
    if (inward) std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  }
  return mesh;
}

/** The signed distance to a ball cut off at kCut. */
double toBowl(const Vec3& x) {
  const double across = std::hypot(x.x(), x.y()), out = x.norm() - kRadius, up = x.z() - kCut;
  if (out <= 0 && up <= 0) return std::max(out, up);
  if (up <= 0) return out;
  if (across <= kRim) return up;
  return kRadius * x.z() / x.norm() <= kCut ? out : std::hypot(across - kRim, up);
}

double toRim(const Vec3& x) { return std::hypot(std::hypot(x.x(), x.y()) - kRim, x.z() - kCut); }

VolumeOptions filling() {
  VolumeOptions options;
  options.fill_holes = true;
  return options;
}

/** Two cubes that share an edge have no hole: told so, and their volume is made where winding numbers tell the inside.
 */
TEST(Holes, anEdgeOfFourTrianglesIsNotCalledOpen) {
  const Vec3 half = Vec3::Constant(0.01);
  TestMesh cubes = boxMesh(half);
  const TestMesh one = boxMesh(half);
  const auto base = static_cast<std::uint32_t>(cubes.vertices.size());
  for (const auto& v : one.vertices) cubes.vertices.push_back({v[0] + 0.02f, v[1] + 0.02f, v[2]});
  for (const auto& t : one.triangles) cubes.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  BuildMonitor monitor;
  const auto refused = buildMeshVolume(cubes.vertices, cubes.triangles, kVoxel, {}, monitor);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().where, "edge at 0.01 0.01 0 m");
  EXPECT_THAT(refused.error().what, ::testing::HasSubstr("more than two triangles meet there"));
  EXPECT_THAT(refused.error().what, ::testing::HasSubstr("it has 1 such edges"));
  const TestVolume volume = volumeOfMesh(cubes, kVoxel, filling());
  ASSERT_NE(volume.view.header, nullptr);
  EXPECT_NEAR(volume.view.mass.volume, 2 * 0.02 * 0.02 * 0.02, 1e-9);

  cubes.triangles.pop_back();  // A hole beside it is what is told.
  const auto open = buildMeshVolume(cubes.vertices, cubes.triangles, kVoxel, {}, monitor);
  ASSERT_FALSE(open.ok());
  EXPECT_THAT(open.error().what, ::testing::HasSubstr("the surface is open there; it has 3 such edges"));
}

TEST(Holes, aFlatOneIsClosedFlat) {
  for (const bool inward : {false, true}) {
    const TestVolume volume = volumeOfMesh(bowl(inward), kVoxel, filling());
    ASSERT_NE(volume.view.header, nullptr);
    std::mt19937 random(seedOf(1));
    int near_lid = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = i % 2 == 0
                         ? randomPoint(random, 0.025)
                         : Vec3(randomPoint(random, kRim).head<2>().homogeneous().cwiseProduct(Vec3(1, 1, kCut)) +
                                randomPoint(random, 0.003));
      const double truth = toBowl(x);
      const DistanceSample got = distanceAt(volume.view, x);
      // The sphere is of triangles, which is 0.01 mm; about the rim the fill is a voxel off.
      const double allowed = got.error + 2e-5 + std::max(0.0, kVoxel - 0.5 * toRim(x));
      ASSERT_NEAR(got.value, truth, allowed) << x.transpose() << " inward " << inward;
      if (toRim(x) > 2 * kVoxel && std::abs(truth) > got.error) {
        ASSERT_EQ(got.value < 0, truth < 0) << x.transpose();
      }
      if (got.fine && std::abs(x.z() - kCut) < kVoxel && x.head<2>().norm() < kRim - 3 * kVoxel) {
        ++near_lid;
        ASSERT_NEAR(got.value, truth, 0.03 * kVoxel) << x.transpose();  // Over the lid's middle the field is linear.
      }
    }
    EXPECT_GT(near_lid, 300);
    const double cap = kRadius - kCut;  // V = 4/3 pi R^3 - pi h^2 (3 R - h) / 3
    const double solid = 4.0 / 3 * M_PI * std::pow(kRadius, 3) - M_PI * cap * cap * (3 * kRadius - cap) / 3;
    EXPECT_NEAR(volume.view.mass.volume, solid, 0.01 * solid);
    const double surface = 2 * M_PI * kRadius * (2 * kRadius - cap) + M_PI * kRim * kRim;
    EXPECT_NEAR(volume.view.header->area, surface, 0.02 * surface);
  }
}

/** Six rectangles that do not meet: each side `gap` short of the box's edges. */
TestMesh looseBox(const Vec3& half, double gap) {
  TestMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      std::uint32_t corner[4];
      for (std::uint32_t c = 0; c < 4; ++c) {
        Vec3 x;
        x[axis] = side * half[axis];
        x[u] = (c == 1 || c == 2 ? 1 : -1) * (half[u] - gap);
        x[v] = (c >= 2 ? 1 : -1) * (half[v] - gap);
        corner[side > 0 ? c : 3 - c] = mesh.addVertex(x);
      }
      mesh.addQuad(corner[0], corner[1], corner[2], corner[3]);
    }
  }
  return mesh;
}

TEST(Holes, ofSixLooseWallsTheSideIsRightFartherThanTheGap) {
  const Vec3 half(0.021, 0.013, 0.008);
  for (const double gap : {0.0001, 0.0008, 0.0024}) {  // A tenth of a voxel, about one, more than two.
    const TestVolume volume = volumeOfMesh(looseBox(half, gap), kVoxel, filling());
    ASSERT_NE(volume.view.header, nullptr);
    const Shape box{ShapeKind::kBox, half};
    std::mt19937 random(seedOf(2));
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = randomPoint(random, i % 2 == 0 ? 0.03 : 0.022);
      Vec3 off = (x.cwiseAbs() - half).cwiseAbs();
      std::sort(off.data(), off.data() + 3);
      const double to_edge = std::hypot(off[0], off[1]), truth = distanceTo(box, x);
      const DistanceSample got = distanceAt(volume.view, x);
      if (to_edge > 1.5 * gap + kVoxel && std::abs(truth) > got.error) {
        ASSERT_EQ(got.value < 0, truth < 0) << x.transpose() << " gap " << gap;
      }
      ASSERT_NEAR(got.value, truth, got.error + 1.5 * gap) << x.transpose() << " gap " << gap;
    }
    const double solid = 8 * half.prod();
    EXPECT_NEAR(volume.view.mass.volume, solid, 0.08 * solid) << gap;
  }
}

TEST(Holes, openMeshesAreRefusedUnlessAsked) {
  BuildMonitor monitor;
  TestMesh mesh = bowl();
  const auto refused = buildMeshVolume(mesh.vertices, mesh.triangles, kVoxel, {}, monitor);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kBadMesh);
  EXPECT_THAT(refused.error().where, ::testing::HasSubstr("edge at"));
  EXPECT_THAT(refused.error().remedy, ::testing::HasSubstr("filled"));
}

TEST(Holes, whatEnclosesNothingIsRefused) {
  BuildMonitor monitor;
  TestMesh sheet = heightMesh(0.02, 4, [](double, double) { return 0.0; });
  const auto refused = buildMeshVolume(sheet.vertices, sheet.triangles, kVoxel, filling(), monitor);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kBadMesh);
  EXPECT_THAT(refused.error().what, ::testing::HasSubstr("encloses nothing"));
}

TEST(Holes, aLatticeTooLargeIsRefusedBeforeItIsWalked) {
  BuildMonitor monitor;
  monitor.progress = [](float, const char* stage) {
    EXPECT_STRNE(stage, "closing holes");
    return true;
  };
  TestMesh needle;  // Ten metres long, so thin that its memory would do.
  for (const double y : {0.0, 0.01}) {
    needle.addVertex(Vec3(0, y, 0));
    needle.addVertex(Vec3(10, y, 0));
  }
  needle.addTriangle(0, 1, 2);
  needle.addTriangle(1, 3, 2);
  const auto refused = buildMeshVolume(needle.vertices, needle.triangles, 0.001, filling(), monitor);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
}

TEST(Holes, aClosedMeshIsTheSameWithOrWithout) {
  const TestMesh mesh = sphereMesh(kRadius, 12);
  const TestVolume without = volumeOfMesh(mesh, kVoxel), with = volumeOfMesh(mesh, kVoxel, filling());
  const auto a = bytesOf(without.image), b = bytesOf(with.image);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size()), 0);
}

TEST(Holes, fillingStopsWhenAsked) {
  BuildMonitor monitor;
  TestMesh mesh = bowl();
  monitor.progress = [](float, const char* stage) { return std::strcmp(stage, "closing holes") != 0; };
  const auto stopped = buildMeshVolume(mesh.vertices, mesh.triangles, kVoxel, filling(), monitor);
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace hapticd::test
