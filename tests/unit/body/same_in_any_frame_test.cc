// A body that is thrown at something moves the same, whichever way the scene is turned, mirrored or drifts, and in
// whatever order objects and triangles come: within rounding, until chaos sets in some hundredths of a second later.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::object;

const Vec3 kSceneMiddle(1.5, -0.7, 1.1), kWayDown(0, 0, -9.81);
constexpr std::uint32_t kGroundBelow = makeObjectId(30, 1), kFallingBody = makeObjectId(21, 1);
constexpr double kSecondsATick = 1e-3;

struct TurnedSolid {
  const char* name;
  ShapeKind kind;
  Vec3 size;
  bool open = false;
};

/** How a scene is told otherwise. */
struct Told {
  const char* name;
  Quat turn = Quat::Identity();
  bool mirrored = false;         ///< In y.
  Vec3 drift = Vec3::Zero();     ///< Velocity of all that is there [m/s].
  bool body_first = false;       ///< Of the two objects.
  bool triangles_about = false;  ///< Another order of triangles, and of corners in them.

  [[nodiscard]] Vec3 vector(Vec3 x) const {
    if (mirrored) x.y() = -x.y();
    return turn * x;
  }
  [[nodiscard]] Vec3 axis(Vec3 w) const {
    if (mirrored) w = Vec3(-w.x(), w.y(), -w.z());
    return turn * w;
  }
  [[nodiscard]] Quat turned(const Quat& q) const {
    return (turn * (mirrored ? Quat(q.w(), -q.x(), q.y(), -q.z()) : q)).normalized();
  }
  [[nodiscard]] Pose pose(const Pose& X) const { return {kSceneMiddle + vector(X.p), turned(X.q)}; }
  [[nodiscard]] Vec3 asItWas(Vec3 x) const {
    x = turn.conjugate() * x;
    if (mirrored) x.y() = -x.y();
    return x;
  }
};

test::TestMesh meshOf(const TurnedSolid& solid, const Told& told) {
  test::TestMesh mesh = test::boxMesh(solid.size);
  if (solid.open) {  // The top alone.
    mesh = test::TestMesh();
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      mesh.addVertex({x * solid.size.x(), y * solid.size.y(), 0});
    mesh.addQuad(0, 1, 2, 3);
  }
  if (!told.triangles_about) return mesh;
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  for (auto& t : mesh.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
  return mesh;
}

/** Where its centre of mass is after each tick, as if nothing had been told otherwise. */
std::vector<Vec3> wayOf(const TurnedSolid& body, const TurnedSolid& ground, unsigned seed, const Told& told) {
  Random random(seed);
  test::ToolHouse house;
  house.aim({0.1, 0.1, 0.2});
  test::TestMesh body_mesh = meshOf(body, told), ground_mesh = meshOf(ground, told);
  house.meshes.publish(3, body_mesh.view());
  house.meshes.publish(4, ground_mesh.view());
  const auto add = [&](std::uint32_t id, const TurnedSolid& solid, const Pose& X, std::uint32_t mesh) {
    AddObject order = object(id, solid.kind, solid.size, X.p);
    order.shape.mesh = mesh;
    store(X.q, order.q);
    house.send(CommandKind::kAddObject, order);
  };
  const Pose X_ground = told.pose({Vec3::Zero(), fromRotationVector(random.vector(0.3))});
  const Pose X_body = told.pose({{random.in(-0.01, 0.01), random.in(-0.01, 0.01), 0.06}, random.turn()});
  if (told.body_first) add(kFallingBody, body, X_body, 3);
  add(kGroundBelow, ground, X_ground, 4);
  if (!told.body_first) add(kFallingBody, body, X_body, 3);
  SetBody order{};
  order.object = kFallingBody;
  order.mass = 0.1;
  order.falls = 1;
  const Vec3 half = body.kind == ShapeKind::kBox || body.kind == ShapeKind::kMesh
                        ? body.size
                        : Vec3(body.size.x(), body.size.x(), std::max(body.size.x(), body.size.y()));
  const MassProperties mass = MassProperties::ofBox(order.mass, 2 * half);
  for (int i = 0; i < 3; ++i) order.inertia[i] = mass.inertia_O(i, i);
  house.send(CommandKind::kSetBody, order);
  house.run(10);
  SetGravity gravity{};
  store(told.vector(kWayDown), gravity.g);
  house.send(CommandKind::kSetGravity, gravity);
  const Vec3 v = random.vector(0.1) - Vec3(0, 0, 0.3), w = random.vector(5);
  house.send(CommandKind::kObjectPose, poseMessage(kFallingBody, X_body, {told.vector(v) + told.drift, told.axis(w)}));
  std::vector<Vec3> way;
  for (int i = 0; i < 130; ++i) {
    const Pose X{X_ground.p + i * kSecondsATick * told.drift, X_ground.q};
    if (!told.drift.isZero(0))
      house.send(CommandKind::kObjectPose, poseMessage(kGroundBelow, X, {told.drift, Vec3::Zero()}));
    house.run(1);
    const Vec3 com = house.servo->cycle().bodies().body(0).body.com();
    way.push_back(told.asItWas(com - kSceneMiddle - (i + 1) * kSecondsATick * told.drift));
  }
  return way;
}

/** The tick in which what fell is no longer where it would have fallen to. */
std::size_t firstTouch(const std::vector<Vec3>& way) {
  const auto changes = [&](std::size_t i) { return Vec3((way[i + 1] - 2 * way[i] + way[i - 1]) / kSecondsATick); };
  std::size_t i = 2;
  while (i + 2 < way.size() && (changes(i) - kSecondsATick * kWayDown).norm() < 1e-3) ++i;
  return i;
}

/** A box has hundreds of points, of which others are kept in another frame. */
double allowedApart(const TurnedSolid& body) { return body.kind == ShapeKind::kBox ? 2e-5 : 1e-9; }

TEST(SameInAnyFrame, ABodyThatFallsOnSomething) {
  const Vec3 half(0.02, 0.015, 0.01), ground_half(0.1, 0.1, 0.01);
  const TurnedSolid bodies[] = {{"box", ShapeKind::kBox, half},
                                {"mesh", ShapeKind::kMesh, half},
                                {"ball", ShapeKind::kSphere, {0.01, 0, 0}},
                                {"capsule", ShapeKind::kCapsule, {0.006, 0.02, 0}},
                                {"cylinder", ShapeKind::kCylinder, {0.01, 0.015, 0}}};
  const TurnedSolid grounds[] = {{"box", ShapeKind::kBox, ground_half},
                                 {"mesh", ShapeKind::kMesh, ground_half},
                                 {"sheet", ShapeKind::kMesh, ground_half, true}};
  const Told otherwise[] = {{.name = "turned", .turn = fromRotationVector({0.7, -0.4, 1.1})},
                            {.name = "mirrored", .mirrored = true},
                            {.name = "drifting", .drift = {0.2, 0.1, 0}},
                            {.name = "made in another order", .body_first = true},
                            {.name = "with triangles in another order", .triangles_about = true}};
  constexpr unsigned kSeed = 2;
  for (const TurnedSolid& body : bodies) {
    for (const TurnedSolid& ground : grounds) {
      const std::vector<Vec3> way = wayOf(body, ground, kSeed, {"as it is"});
      const std::size_t soon = firstTouch(way) + 10;
      ASSERT_LT(soon, way.size()) << body.name << " on " << ground.name;
      for (const Told& told : otherwise)
        EXPECT_LT((wayOf(body, ground, kSeed, told)[soon] - way[soon]).norm(), allowedApart(body))
            << body.name << " on " << ground.name << ", " << told.name;
    }
  }
}

}  // namespace
}  // namespace hapticd
