/** @file
 * What a tool is told of an obstacle that it hardly touches, of any kind, against the nearest places of convex bodies.
 */
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

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

/** Two blades across a bar, each between its points, of a mesh whose origin is so far from them. */
ContactModel bladesOn(const Shape& bar, const Pose& X_WB, double far) {
  test::TestMesh blades;
  blades.flags = HD_MESH_CLOSED;
  for (const double x : {-0.012, 0.012}) {
    const test::TestMesh blade = test::boxMesh({0.002, 0.02, 0.003}, {x + far, 0, 0.003});
    const auto first = static_cast<std::uint32_t>(blades.vertices.size());
    blades.vertices.insert(blades.vertices.end(), blade.vertices.begin(), blade.vertices.end());
    for (const auto& t : blade.triangles) blades.addTriangle(first + t[0], first + t[1], first + t[2]);
  }
  CollideRequest::Held held;
  held.object = makeObjectId(9, 1);
  held.shape.kind = ShapeKind::kMesh;
  held.shape.mesh = blades.view();
  held.X_WO.p = {-far, 0, -5e-6};
  held.count = 1;
  held.obstacle[0] = {7, bar, X_WB, {}};
  ContactModel model;
  DetectorReport report;
  std::make_unique<SceneContacts>(1)->find(held, 0.003, {400'000, 0, nullptr}, model, report);
  for (ContactModel::Point& point : model.point) point.p_A[0] -= static_cast<float>(far);
  return model;
}

/** As of what is drawn where it stands in a machine: both blades once lay on the bar as one, or on nothing. */
TEST(ContactsProperty, AToolMayHaveItsOriginFarFromIt) {
  test::TestMesh bar = test::boxMesh({0.3, 0.004, 0.004});
  const Shape box{ShapeKind::kBox, {0.3, 0.004, 0.004}}, pipe{ShapeKind::kCapsule, {0.005, 0.3, 0}};
  Shape mesh{ShapeKind::kMesh, Vec3::Zero()};
  mesh.mesh = bar.view();
  const Quat on_edge(Eigen::AngleAxisd(EIGEN_PI / 4, Vec3::UnitX()));
  const Quat along_x(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitY()));
  const Vec3 edge(0, 0, -0.004 * std::sqrt(2)), mantle(0, 0, -0.005);
  for (const double far : {0.0, 0.1, 0.3, 1.0}) {
    for (const auto& [on, X_WB] :
         {std::pair{box, Pose{edge, on_edge}}, {mesh, {edge, on_edge}}, {pipe, {mantle, along_x}}}) {
      const ContactModel model = bladesOn(on, X_WB, far);
      int left = 0, right = 0;
      for (std::uint32_t i = 0; i < model.count; ++i) {
        const float x = model.point[i].p_A[0];
        left += std::abs(x + 0.012) < 0.0021;
        right += std::abs(x - 0.012) < 0.0021;
      }
      EXPECT_GT(left, 0) << far << " on " << static_cast<int>(on.kind);
      EXPECT_GT(right, 0) << far << " on " << static_cast<int>(on.kind);
    }
  }
}

}  // namespace
}  // namespace hapticd
