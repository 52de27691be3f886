/** @file
 * What a tool is told of an obstacle that it hardly touches, of any kind, against the nearest places of convex bodies.
 */
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "rt/collide/scene_contacts.h"
#include "rt/geometry/nearest/nearest.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

/** A convex body of some millimetres to centimetres. */
struct ConvexBody {
  explicit ConvexBody(Random& random) {
    const double size = std::pow(10, random.in(-2.2, -1.3));
    const auto length = [&] { return size * random.in(0.4, 1.5); };
    const int kind = random.below(6);
    for (double& x : shape.size) x = length();
    if (kind < 4) {
      shape.kind = std::array{ShapeKind::kSphere, ShapeKind::kCapsule, ShapeKind::kCylinder, ShapeKind::kBox}[kind];
      return;
    }
    mesh = kind == 4 ? test::boxMesh(shape.size) : test::sphereMesh(shape.size.x(), 5 + random.below(8u));
    mesh.flags = HD_MESH_CLOSED;
    shape.kind = ShapeKind::kMesh;
    shape.mesh = mesh.view();
  }

  /** The point of the body nearest to x, in the world. */
  [[nodiscard]] Vec3 nearestTo(const Vec3& x) const {
    NearestQuery query;
    query.x = X_WO.inverse() * x;
    query.limit = 1'000'000;
    Nearest nearest;
    EXPECT_EQ(nearestOnShape(shape, query, nearest), NearestResult::kFound);
    return nearest.isInside(query.x) ? x : X_WO * nearest.point;
  }

  Shape shape;
  test::TestMesh mesh;
  Pose X_WO;
};

/** From the second to the first, where they are nearest, by going to and fro between them (von Neumann). */
Vec3 wayBetween(const ConvexBody& first, const ConvexBody& second) {
  constexpr int kMost = 20'000, kLookEvery = 20;
  Vec3 x = first.X_WO.p, way = Vec3::Zero();
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMost; ++i) {
    const Vec3 y = second.nearestTo(x);
    x = first.nearestTo(y);
    way = x - y;
    if (i % kLookEvery > 0) continue;
    if (last - way.norm() < 1e-13) break;
    last = way.norm();
  }
  return way;
}

/** Wherever its corners, edges and faces come on those of the obstacle. */
TEST(ContactsProperty, OfTwoThatAreInEachOtherByAHairATouchIsToldThatDeep) {
  constexpr double kHair = 2e-5;
  const auto contacts = std::make_unique<SceneContacts>(1);
  forSeeds(1000, [&](unsigned seed) {
    Random random(seed);
    ConvexBody tool(random), obstacle(random);
    tool.X_WO = random.pose(0.1);
    obstacle.X_WO = {tool.X_WO.p + 0.3 * random.vector(1).normalized(), random.turn()};
    const Vec3 way = wayBetween(tool, obstacle), out = way.normalized();
    tool.X_WO.p -= way + kHair * out;  // Along that way all of it goes in by no more than so far.

    CollideRequest::Held held;
    held.object = makeObjectId(9, 1);
    held.shape = tool.shape;
    held.shape.number = seed + 1;
    held.X_WO = tool.X_WO;
    held.count = 1;
    held.obstacle[0] = {7, obstacle.shape, obstacle.X_WO, {}};
    ContactModel model;
    DetectorReport report;
    contacts->find(held, 0.003, {400'000, 0, nullptr}, model, report);
    double deepest = -1;
    for (std::uint32_t i = 0; i < model.count; ++i) {
      deepest = std::max(deepest, -model.touch(i, tool.X_WO, tool.X_WO.p, obstacle.X_WO, {}).gap);
    }
    // A cylinder's rim is points 11 degrees apart: between two it is lower by half a hundredth of its radius. And what
    // a disc says is that deep in a plane, which what is round or edged leaves.
    const bool discs = tool.shape.kind == ShapeKind::kCylinder;
    const double between = discs ? 0.005 * tool.shape.size.x() : 0;
    if (!discs) {
      EXPECT_LT(deepest, 3 * kHair);
    }
    EXPECT_GT(deepest, 0.5 * kHair - between) << model.count << " touches";
  });
}

}  // namespace
}  // namespace hapticd
