// Meshes that enclose nothing, walls from both sides: a tool slides over them as over what has an inside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/shape/concave_mesh.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::TestMesh;

const Shape kSheetBall{ShapeKind::kSphere, {0.01, 0, 0}}, kTraySaucer{ShapeKind::kCylinder, {0.03, 0.003, 0}};

/** How deep a tool gets in what a hand wanders over, and how much that shakes it. */
template <class Depth>
test::Wandered wanderedOver(const Shape& tool, TestMesh mesh, unsigned seed, const Depth& depth) {
  Random random(seed);
  const auto house = test::houseWithoutFloor();
  house->meshes.publish(4, mesh.view());
  house->reshape(tool.kind, tool.size);
  const Vec3 hand(0, 0, 0.06);
  house->aim(hand);
  house->run(500);
  AddObject ground = test::object(test::kWall, ShapeKind::kMesh, Vec3::Zero(), Vec3::Zero());
  ground.shape.mesh = 4;
  ground.material = {1000, 0, 0, 0};
  house->send(CommandKind::kAddObject, ground);
  house->hold();
  return wanderOver(*house, depth, hand, Vec3::Zero(), test::anywhere(random), random);
}

double shakenOver(const Shape& tool, const TestMesh& mesh, unsigned seed) {
  return wanderedOver(tool, mesh, seed, [](const Pose&) { return 0.0; }).shaken;
}

enum class Waves { kSolid, kSheet, kSheetFromBehind };

/** Waves: of a sheet, or the top of a block. */
TestMesh waves(Waves ground) {
  constexpr int kParts = 24;
  constexpr double kHalf = 0.06;
  TestMesh mesh;
  mesh.flags = ground == Waves::kSolid ? HD_MESH_CLOSED : 0;
  std::vector<std::uint32_t> upper, lower;
  const auto at = [](int i, int j) { return static_cast<std::size_t>(i * (kParts + 1) + j); };
  for (int i = 0; i <= kParts; ++i) {
    for (int j = 0; j <= kParts; ++j) {
      const double x = kHalf * (2.0 * i / kParts - 1), y = kHalf * (2.0 * j / kParts - 1);
      upper.push_back(mesh.addVertex({x, y, 0.004 * std::sin(x / 0.012) * std::sin(y / 0.015)}));
    }
  }
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    ground == Waves::kSheetFromBehind ? mesh.addQuad(a, d, c, b) : mesh.addQuad(a, b, c, d);
  };
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; j < kParts; ++j)
      quad(upper[at(i, j)], upper[at(i + 1, j)], upper[at(i + 1, j + 1)], upper[at(i, j + 1)]);
  }
  if (ground != Waves::kSolid) return mesh;
  for (int i = 0; i <= kParts; ++i) {
    for (int j = 0; j <= kParts; ++j) {
      lower.push_back(mesh.addVertex({kHalf * (2.0 * i / kParts - 1), kHalf * (2.0 * j / kParts - 1), -0.04}));
    }
  }
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; j < kParts; ++j)
      quad(lower[at(i, j)], lower[at(i, j + 1)], lower[at(i + 1, j + 1)], lower[at(i + 1, j)]);
    const auto side = [&](std::size_t from, std::size_t to) { quad(lower[from], lower[to], upper[to], upper[from]); };
    side(at(i, 0), at(i + 1, 0));
    side(at(i + 1, kParts), at(i, kParts));
    side(at(0, i + 1), at(0, i));
    side(at(kParts, i), at(kParts, i + 1));
  }
  return mesh;
}

/** Held by the last answer's plane it was shaken nearly twice as much. */
TEST(Sheets, ABallRollsOverOneAsOverASolid) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const double solid = shakenOver(kSheetBall, waves(Waves::kSolid), seed);
    EXPECT_NEAR(shakenOver(kSheetBall, waves(Waves::kSheet), seed), solid, 0.1 * solid) << seed;
    EXPECT_NEAR(shakenOver(kSheetBall, waves(Waves::kSheetFromBehind), seed), solid, 0.1 * solid) << seed;
  }
}

/** A bottom and four sides, without thickness; turned by q. */
TestMesh tray(const Quat& q) {
  constexpr double kHalf = 0.04, kHigh = 0.02;
  TestMesh mesh;
  for (const double z : {0.0, kHigh}) {
    for (const auto& [x, y] : {std::pair{-kHalf, -kHalf}, {kHalf, -kHalf}, {kHalf, kHalf}, {-kHalf, kHalf}})
      mesh.addVertex(q * Vec3(x, y, z));
  }
  mesh.addQuad(0, 1, 2, 3);
  for (std::uint32_t i = 0; i < 4; ++i) mesh.addQuad((i + 1) % 4, i, 4 + i, 4 + (i + 1) % 4);
  return mesh;
}

/**
 * Its discs were told of where a wall would be if it did not end, through its border, and thrown by up to 33 N; and a
 * point of it that came over the border between two answers stayed behind the tray, whose bottom then held it down.
 */
TEST(Sheets, ASaucerOnATrayIsNotThrown) {
  for (const unsigned seed : {1u, 4u, 7u, 13u}) {
    Random random(seed + 100);
    EXPECT_LT(shakenOver(kTraySaucer, tray(fromRotationVector(random.vector(0.2))), seed), 300) << seed;
  }
}

}  // namespace
}  // namespace hapticd
