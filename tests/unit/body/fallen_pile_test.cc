// Bodies that fall fast into a bin, one upon the other: none sinks into it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/concave_mesh.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kWall;
using test::object;
using House = test::ToolHouse;

constexpr double kBinHalf = 0.03, kBinBottom = 0.01;  ///< Half the bin's inner width, and how high its bottom is [m].
constexpr double kCapsuleRadius = 0.005, kCapsuleHalf = 0.016;  ///< [m]

test::TestMesh openBin() {
  const std::vector<double> side{-kBinHalf - 0.02, -kBinHalf, kBinHalf, kBinHalf + 0.02};
  return test::meshOfCells({side, side, {kBinBottom - 0.02, kBinBottom, kBinBottom + 0.3}}, Quat::Identity(),
                           [](int i, int j, int k) { return k == 0 || i != 1 || j != 1; });
}

const FreeBody& fallen(const House& house, std::uint32_t k) {
  return house.servo->cycle().bodies().body(static_cast<std::uint8_t>(k));
}

/** How deep it is in the bin's walls and bottom: the room is convex, so one of its ends is deepest. */
double depthInBin(const Pose& X_WO) {
  double deepest = 0;
  for (const double end : {-kCapsuleHalf, kCapsuleHalf}) {
    const Vec3 x = X_WO * Vec3(0, 0, end);
    const double gap = std::min({x.z() - kBinBottom, kBinHalf - std::abs(x.x()), kBinHalf - std::abs(x.y())});
    deepest = std::max(deepest, kCapsuleRadius - gap);
  }
  return deepest;
}

/** What the fastest end could reach was once near to all of a capsule: what held its other end had no place among the
 * touches. */
TEST(FallenPile, NoCapsuleSinksIntoTheBin) {
  for (const unsigned seed : seeds(3)) {
    Random random(seed);
    House house;
    house.aim({0.5, 0.5, 0.3});
    house.run(50);
    test::TestMesh mesh = openBin();
    house.meshes.publish(3, mesh.view());
    AddObject wall = object(kWall, ShapeKind::kMesh, Vec3::Zero(), Vec3::Zero());
    wall.shape.mesh = 3;
    house.send(CommandKind::kAddObject, wall);
    for (std::uint32_t k = 0; k < kMaxBodies; ++k) {
      const std::uint32_t id = makeObjectId(10 + k, 1);
      AddObject capsule = object(id, ShapeKind::kCapsule, {kCapsuleRadius, kCapsuleHalf, 0},
                                 Vec3(0, 0, 0.06 + 0.05 * k) + random.vector(0.004));
      store(random.turn(), capsule.q);
      house.send(CommandKind::kAddObject, capsule);
      SetBody order{};
      order.object = id;
      order.falls = 1;
      order.mass = 0.03;
      const Vec3 sides = 2 * Vec3(kCapsuleRadius, kCapsuleRadius, kCapsuleRadius + kCapsuleHalf);
      const Mat3 inertia = MassProperties::ofBox(order.mass, sides).inertia_O;
      for (int i = 0; i < 3; ++i) order.inertia[i] = inertia(i, i);
      house.send(CommandKind::kSetBody, order);
    }
    house.run(20);
    house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
    double deepest = 0, fastest = 0;
    for (int i = 0; i < 450; ++i) {
      house.run(1);
      for (std::uint32_t k = 0; k < kMaxBodies; ++k) {
        deepest = std::max(deepest, depthInBin(fallen(house, k).body.pose()));
        fastest = std::max(fastest, fallen(house, k).body.twist().v.norm());
      }
    }
    if (std::getenv("HAPTICD_SHOW")) std::printf("seed %u: %.3f mm deep\n", seed, 1e3 * deepest);
    EXPECT_LT(deepest, 2e-4) << seed;
    EXPECT_GT(fastest, 1) << seed << ": they fall fast [m/s]";
  }
}

}  // namespace
}  // namespace hapticd
