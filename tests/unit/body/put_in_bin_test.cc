// What was put into the floor of a bin: the bin is a mesh with an inside, but the box about it is not what holds.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/shape/concave_mesh.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::object;

constexpr std::uint32_t kBin = makeObjectId(20, 1), kLowBall = makeObjectId(21, 1), kHighBall = makeObjectId(22, 1);
constexpr double kBinBall = 0.01, kFloorThick = 0.005;  ///< The floor of the bin is from -kFloorThick to 0 [m].

/** Far from the hand's tool. */
struct Bin {
  Bin() {
    const std::vector<double> side{-0.06, -0.05, 0.05, 0.06};
    mesh = test::meshOfCells({side, side, {-kFloorThick, 0, 0.055}}, Quat::Identity(),
                             [](int i, int j, int k) { return k == 0 || i != 1 || j != 1; });
    house.meshes.publish(3, mesh.view());
    house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
    AddObject bin = object(kBin, ShapeKind::kMesh, Vec3::Zero(), kAt);
    bin.shape.mesh = 3;
    house.send(CommandKind::kAddObject, bin);
    house.run(50);
  }
  void addBall(std::uint32_t id, double z, bool falls) {
    house.send(CommandKind::kAddObject, object(id, ShapeKind::kSphere, {kBinBall, 0, 0}, kAt + Vec3(0, 0, z)));
    SetBody order{};
    order.object = id;
    order.falls = falls ? 1 : 0;
    order.mass = 0.1;
    for (int i = 0; i < 3; ++i) order.inertia[i] = 4e-6;
    house.send(CommandKind::kSetBody, order);
  }
  [[nodiscard]] const RigidBody& ball(std::uint8_t k) const { return house.servo->cycle().bodies().body(k).body; }
  [[nodiscard]] double height(std::uint8_t k) const { return ball(k).com().z() - kAt.z(); }

  const Vec3 kAt{0.3, 0, 0.1};
  test::TestMesh mesh;
  test::ToolHouse house;
};

TEST(PutInBin, ABallWaitsForTheOneOnItAndIsNotLedThroughTheFloor) {
  Bin bin;
  bin.addBall(kLowBall, kBinBall - 0.0003, false);
  bin.addBall(kHighBall, 3 * kBinBall - 0.0003, false);
  bin.house.run(2);
  for (int i = 0; i < 600; ++i) {
    bin.house.run(1);
    ASSERT_GT(bin.height(0), kBinBall - 0.0004) << "tick " << i;
    ASSERT_GT(bin.height(1), 3 * kBinBall - 0.0004) << "tick " << i;
  }
}

/** Down a slope a full ball rolls with 5/7 of what pulls it along: as its points hold it, with nothing from the box. */
TEST(PutInBin, ABallRollsWhileItIsLedOutOfTheFloor) {
  Bin bin;
  bin.addBall(kLowBall, kBinBall - 0.0003, true);
  bin.house.run(2);
  constexpr double kAlong = 2;
  bin.house.send(CommandKind::kSetGravity, SetGravity{{kAlong, 0, -9.81}});
  for (int i = 1; i <= 60; ++i) {
    bin.house.run(1);
    ASSERT_NEAR(bin.ball(0).twist().v.x(), 5.0 / 7 * kAlong * 1e-3 * i, 1e-4) << "tick " << i;
    ASSERT_LT(std::abs(bin.ball(0).twist().v.z()), 1e-3) << "tick " << i;
  }
  EXPECT_GT(bin.height(0), kBinBall - 1e-4);
}

}  // namespace
}  // namespace hapticd
