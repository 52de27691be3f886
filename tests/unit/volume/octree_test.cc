// The octree of every shape against the voxels themselves.
#include "rt/volume/octree.h"

#include "rt/volume/tight_sphere.h"
#include "tests/support/shape/test_volume.h"

namespace hapticd::test {
namespace {

constexpr OctreeShape kShapes[] = {OctreeShape::kEight, OctreeShape::kSixtyFour, OctreeShape::kFiveTwelve,
                                   OctreeShape::kMixed};

/** Walks the whole tree; calls leaf(corner) for each surface voxel and inner(level, node, corner, side). */
template <class Leaf, class Inner>
void walk(const OctreeView& tree, Leaf&& leaf, Inner&& inner) {
  struct Here {
    std::uint32_t level, node;
    Eigen::Vector3i corner;
  };
  std::vector<Here> stack{{0, 0, Eigen::Vector3i::Zero()}};
  while (!stack.empty()) {
    const Here here = stack.back();
    stack.pop_back();
    const OctreeLevel& level = tree.level[here.level];
    inner(here.level, here.node, here.corner, 1 << level.side_log2);
    forEachChild(level, here.node, [&](std::uint32_t place, std::uint32_t child) {
      const ChildPlace k = childPlace(level.split, place);
      const Eigen::Vector3i corner =
          here.corner + Eigen::Vector3i(static_cast<int>(k.x), static_cast<int>(k.y), static_cast<int>(k.z)) *
                            (1 << (level.side_log2 - level.split));
      if (level.first == nullptr) {
        leaf(corner);
      } else {
        stack.push_back({here.level + 1, child, corner});
      }
    });
  }
}

std::size_t octreeBytes(const VolumeView& v) {
  return v.header->section[HD_VOLUME_OCCUPIED].bytes + v.header->section[HD_VOLUME_SURFACE].bytes +
         v.header->section[HD_VOLUME_FIRST].bytes;
}

TEST(Octree, allShapesHoldTheSameVoxelsAndTheirPoints) {
  std::vector<std::array<int, 3>> before;
  for (const OctreeShape shape : kShapes) {
    VolumeOptions options;
    options.octree = shape;
    const TestVolume torus = torusVolume(0.03, 0.01, 0.001, options);
    std::vector<std::array<int, 3>> voxels;
    walk(
        torus.view.octree,
        [&](const Eigen::Vector3i& v) {
          voxels.push_back({v.x(), v.y(), v.z()});
        },
        [](std::uint32_t, std::uint32_t, const Eigen::Vector3i&, int) {});
    std::sort(voxels.begin(), voxels.end());
    EXPECT_EQ(voxels.size(), torus.view.header->surface_voxels);
    if (!before.empty()) {
      EXPECT_EQ(voxels, before);
    }
    before = voxels;
    for (std::uint32_t i = 0; i < torus.view.point_count; ++i) {
      const Vec3 u = (torus.view.pointAt(i) - torus.view.originPoint()) / torus.view.voxel;
      const std::array<int, 3> in{static_cast<int>(u.x()), static_cast<int>(u.y()), static_cast<int>(u.z())};
      EXPECT_TRUE(std::binary_search(voxels.begin(), voxels.end(), in));
    }
  }
}

TEST(Octree, tellsStatesAsDistancesDo) {
  const double radius = 0.02, s = 0.001;
  for (const OctreeShape shape : kShapes) {
    VolumeOptions options;
    options.octree = shape;
    const TestVolume ball = sphereVolume(radius, s, 48, options);
    const auto n = static_cast<std::int32_t>(8 * ball.view.cells[0]);
    int counts[4] = {};
    for (std::int32_t k = -1; k <= n; ++k)
      for (std::int32_t j = -1; j <= n; ++j)
        for (std::int32_t i = -1; i <= n; ++i) {
          const VoxelState state = voxelState(ball.view.octree, i, j, k);
          ++counts[static_cast<int>(state)];
          const double d = (ball.view.originPoint() + s * Vec3(i + 0.5, j + 0.5, k + 0.5)).norm() - radius;
          const double half = std::sqrt(3.0) / 2 * s;  // The mesh is within 0.05 s of the sphere.
          if (state == VoxelState::kSurface) {
            EXPECT_LT(std::abs(d), half + 0.1 * s);
          }
          if (state == VoxelState::kFull) {
            EXPECT_LT(d, 0);
          }
          if (state == VoxelState::kProximity) {
            EXPECT_TRUE(d > -0.1 * s && d < 3 * half + 0.1 * s);
          }
          if (state == VoxelState::kEmpty) {
            EXPECT_GT(d, s / 2 - 0.1 * s);
          }
          if (d < -half - 0.1 * s) {
            EXPECT_EQ(state, VoxelState::kFull);
          }
        }
    for (const int count : counts) EXPECT_GT(count, 1000);
  }
}

TEST(Octree, ballsHoldTheVoxelsOfTheirNodes) {
  for (const OctreeShape shape : kShapes) {
    VolumeOptions options;
    options.octree = shape;
    const TestVolume box = boxVolume(Vec3(0.02, 0.013, 0.007), 0.0011, options);
    const OctreeView& tree = box.view.octree;
    std::vector<Eigen::Vector3i> voxels;
    walk(
        tree, [&](const Eigen::Vector3i& v) { voxels.push_back(v); },
        [](std::uint32_t, std::uint32_t, const Eigen::Vector3i&, int) {});
    std::size_t tighter = 0;
    walk(
        tree, [](const Eigen::Vector3i&) {},
        [&](std::uint32_t l, std::uint32_t node, const Eigen::Vector3i& corner, int side) {
          const TightSphere& tight = tightSphere(octants(tree.level[l], node));
          tighter += tight.radius < 1.7F;  // sqrt(3) about the whole node.
          const Vec3 center = corner.cast<double>() + Vec3::Constant(side / 2.0) +
                              side / 2.0 * Vec3(tight.center[0], tight.center[1], tight.center[2]);
          for (const Eigen::Vector3i& v : voxels) {
            if (((v - corner).array() < 0).any() || ((v - corner).array() >= side).any()) continue;
            for (int c = 0; c < 8; ++c) {
              const Vec3 x = v.cast<double>() + Vec3(c & 1, c >> 1 & 1, c >> 2 & 1);
              EXPECT_LE((x - center).norm(), side / 2.0 * tight.radius * (1 + 1e-6));
            }
          }
        });
    EXPECT_GT(tighter, 0u);
  }
}

TEST(Octree, offsetsTurnedOnceAreThoseOfTheChildren) {
  const Mat3 R_WO = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const TurnedOffsets turned(R_WO);
  for (std::uint32_t split = 1; split <= 3; ++split) {
    const std::uint32_t n = 1u << split;
    for (std::uint32_t place = 0; place < n * n * n; ++place) {
      const double x = place % n, y = place / n % n, z = place / n / n;
      const Vec3 center = (Vec3(x, y, z) + Vec3::Constant(0.5)) / n - Vec3::Constant(0.5);
      EXPECT_LT((turned.offset(split, place) - R_WO * center).norm(), 1e-15);
    }
  }
}

TEST(Octree, takesFewBytesALeaf) {
  for (const OctreeShape shape : kShapes) {
    VolumeOptions options;
    options.octree = shape;
    const TestVolume ball = sphereVolume(0.02, 0.0005, 64, options);
    const double bytes = static_cast<double>(octreeBytes(ball.view)) / ball.view.header->surface_voxels;
    RecordProperty("bytes_a_leaf_" + std::to_string(static_cast<int>(shape)), std::to_string(bytes));
    if (shape == OctreeShape::kMixed) {
      EXPECT_LE(bytes, 1.5);
    }
  }
}

TEST(Octree, anObjectOf100MillimetresTakesLessThan12Megabytes) {
  const TestVolume ball = sphereVolume(0.05, 0.0005, 128);
  EXPECT_LT(ball.view.header->total_bytes, 12'000'000u);
  EXPECT_GT(ball.view.point_count, 120'000u);  // One for each voxel that the surface crosses, of 31 400 mm2.
  EXPECT_LT(static_cast<double>(octreeBytes(ball.view)), 1.5 * ball.view.header->surface_voxels);
}

TEST(Octree, sensationIsWhatItsVoxelsAre) {
  VolumeOptions options;
  options.sensation = true;
  const double half = 0.0121;
  const TestVolume box = boxVolume(Vec3::Constant(half), 0.001, options);
  const OctreeView& tree = box.view.octree;
  ASSERT_NE(tree.sensation, nullptr);
  walk(
      tree, [](const Eigen::Vector3i&) {},
      [&](std::uint32_t l, std::uint32_t node, const Eigen::Vector3i& corner, int side) {
        const hd_octree_sensation& s = tree.sensation[tree.first_sensation[l] + node];
        int full = 0;
        for (int i = 0; i < side * side * side; ++i) {
          const VoxelState state =
              voxelState(tree, corner.x() + i % side, corner.y() + i / side % side, corner.z() + i / side / side);
          full += state == VoxelState::kSurface || state == VoxelState::kFull;
        }
        EXPECT_NEAR(s.empty, 1 - full / std::pow(side, 3), 1e-6);
        // In the middle of a face 9 voxels' worth of surface supports a contact; never more on a box, but for the
        // pieces of a third of a voxel that it is summed of.
        EXPECT_GT(s.support_area, 0);
        EXPECT_LT(s.support_area, 11e-6);
      });
  // A node over the middle of a face sees one normal only.
  const Vec3 u = (Vec3(0, 0, half) - box.view.originPoint()) / 0.001;
  bool seen = false;
  const auto last = tree.levels - 1;
  walk(
      tree, [](const Eigen::Vector3i&) {},
      [&](std::uint32_t l, std::uint32_t node, const Eigen::Vector3i& corner, int side) {
        const Vec3 low = corner.cast<double>();
        if (l != last || ((u - low).array() < 0).any() || ((u - low).array() >= side).any()) return;
        const hd_octree_sensation& s = tree.sensation[tree.first_sensation[l] + node];
        EXPECT_NEAR(s.support_area, 9e-6, 2e-6);
        seen = true;
      });
  EXPECT_TRUE(seen);
}

}  // namespace
}  // namespace hapticd::test
