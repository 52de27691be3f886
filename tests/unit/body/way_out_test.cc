// What the collide thread tells of two that were put into each other: the least way out, below the middle of whom it
// tells.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>

#include "rt/collide/collider.h"
#include "rt/collide/feature.h"
#include "rt/collide/overlap.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kAsker = 5;  ///< The slot of who asks.

/** Of one that asks about an obstacle, in the world. */
struct WayTold {
  Vec3 n, at;  ///< From the obstacle, and where on whom it tells [m].
  double deep = 0;
};

std::optional<WayTold> ask(const Solid& asks, const Solid& about, std::uint32_t slot, bool put = true,
                           std::uint32_t asker = kAsker) {
  const auto collider = std::make_unique<Collider>();
  CollideRequest request;
  CollideRequest::Held& held = request.held[kMaxDevices];
  held.object = makeObjectId(asker, 1);
  held.shape = asks.shape;
  held.X_WO = asks.X_WO;
  held.put = put;
  held.count = 1;
  held.obstacle[0].slot = slot;
  held.obstacle[0].shape = about.shape;
  held.obstacle[0].X_WO = about.X_WO;
  collider->questions.put(request);
  collider->step(nullptr);
  Command answer;
  if (!collider->answers.pop(answer)) return std::nullopt;
  const auto& contacts = answer.as<ToolContacts>();
  for (std::uint32_t i = 0; i < contacts.count; ++i) {
    const ToolContacts::Point& p = contacts.point[i];
    if ((p.key & 0xffffffU) - 1 != kWayOut) continue;
    EXPECT_EQ(p.key >> 24, slot);
    const Vec3 n_B(p.n_B[0], p.n_B[1], p.n_B[2]), at = asks.X_WO * Vec3(p.p_A[0], p.p_A[1], p.p_A[2]);
    return WayTold{about.X_WO.q * n_B, at, p.offset - n_B.dot(about.X_WO.inverse() * at)};
  }
  return std::nullopt;
}

/** Of a ball or a box that is turned as the box is: through the nearest face. Whichever has the lower slot. */
TEST(WayOut, LeadsThroughTheNearestFaceFromBelowTheMiddle) {
  forSeeds(60, [](unsigned seed) {
    Random random(seed);
    const Vec3 half(random.in(0.01, 0.03), random.in(0.01, 0.03), random.in(0.01, 0.03));
    const Pose X = random.pose(0.1);
    const Vec3 at = random.vector(1).cwiseProduct(half);
    const bool ball = random.once(2);
    const Shape inside{ball ? ShapeKind::kSphere : ShapeKind::kBox,
                       {random.in(0.004, 0.01), random.in(0.004, 0.01), random.in(0.004, 0.01)}};
    const Vec3 reach = ball ? Vec3(Vec3::Constant(inside.size.x())) : inside.size;
    test::TestMesh made = test::boxMesh(half);
    Shape box{random.once(2) ? ShapeKind::kBox : ShapeKind::kMesh, half};
    box.mesh = made.view();
    const std::uint32_t slot = random.once(2) ? kAsker - 1 : kAsker + 1;
    int face = 0;
    const double deep = (half + reach - at.cwiseAbs()).minCoeff(&face);
    const Vec3 n = std::copysign(1, at[face]) * (X.q * Vec3::Unit(face));
    const std::optional<WayTold> told = ask({inside, X * Pose{at, Quat::Identity()}}, {box, X}, slot);
    ASSERT_TRUE(told);
    EXPECT_LT((told->n - n).norm(), 1e-3);
    EXPECT_NEAR(told->deep, deep, 1e-7);
    EXPECT_LT((told->at - (X * at - reach[face] * n)).norm(), 1e-3 * reach[face] + 1e-7);
    EXPECT_FALSE(ask({inside, X * Pose{at, Quat::Identity()}}, {box, X}, slot, false)) << "nobody put it there";
  });
}

TEST(WayOut, IsToldOfSolidsThatReachFarIntoEachOtherOnly) {
  const double r = 0.005, half = 0.01;
  const Shape ball{ShapeKind::kSphere, {r, 0, 0}}, box{ShapeKind::kBox, Vec3::Constant(half)};
  test::TestMesh made = test::boxMesh(Vec3::Constant(half)), open = test::boxMesh(Vec3::Constant(half));
  open.flags = 0;
  Shape mesh{ShapeKind::kMesh, Vec3::Zero()}, sheet = mesh, soft = mesh;
  mesh.mesh = made.view();
  sheet.mesh = open.view();
  const auto isTold = [&](const Shape& of, const Shape& by, double deep) {
    return ask({by, {Vec3(0, 0, half + r - deep), Quat::Identity()}}, {of, {}}, 1).has_value();
  };
  for (const Shape& solid : {box, mesh}) {
    EXPECT_FALSE(isTold(solid, ball, 1.9 * kWithin));
    EXPECT_TRUE(isTold(solid, ball, 2.2 * kWithin));
    EXPECT_TRUE(isTold(solid, ball, 0.008));
  }
  EXPECT_FALSE(isTold(sheet, ball, 0.008));
  EXPECT_FALSE(isTold({ShapeKind::kPlane, Vec3::Zero()}, ball, 0.013));
  test::TestMesh yields = test::boxMesh(Vec3::Constant(half));
  soft.mesh = yields.deformableView();
  EXPECT_FALSE(isTold(soft, ball, 0.008));
  EXPECT_FALSE(isTold(box, sheet, 0.008));
}

/** In one place any way is as short: each goes where the other's answer sends it away from. */
TEST(WayOut, TwoThatAskOfEachOtherAreSentApart) {
  forSeeds(40, [](unsigned seed) {
    Random random(seed);
    const Shape box{ShapeKind::kBox, Vec3::Constant(random.in(0.005, 0.02))};
    const Shape other{random.once(2) ? ShapeKind::kBox : ShapeKind::kSphere, box.size};
    const Pose X = random.pose(0.1), Y{X.p, random.once(2) ? X.q : random.turn()};
    const std::optional<WayTold> one = ask({box, X}, {other, Y}, 9),
                                 second = ask({other, Y}, {box, X}, kAsker, true, 9);
    ASSERT_TRUE(one && second);
    EXPECT_LT((one->n + second->n).norm(), 1e-5);
    EXPECT_NEAR(one->deep, second->deep, 1e-7);
  });
}

/** The box about a mesh is no solid: between two parts of one is room. */
TEST(WayOut, IsNotToldOfWhoIsInTheBoxAboutAMeshAlone) {
  const Shape ball{ShapeKind::kSphere, {0.005, 0, 0}};
  test::TestMesh parts = test::boxMesh(Vec3::Constant(0.01), {-0.03, 0, 0}), right = parts;
  for (const auto& v : right.vertices) parts.vertices.push_back({v[0] + 0.06F, v[1], v[2]});
  for (const auto& t : right.triangles) parts.addTriangle(t[0] + 8, t[1] + 8, t[2] + 8);
  Shape mesh{ShapeKind::kMesh, Vec3::Zero()};
  mesh.mesh = parts.view();
  EXPECT_FALSE(ask({ball, {}}, {mesh, {}}, 1));
  EXPECT_TRUE(ask({ball, {Vec3(0.03, 0, 0), Quat::Identity()}}, {mesh, {}}, 1));
}

}  // namespace
}  // namespace hapticd
