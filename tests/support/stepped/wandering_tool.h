/** @file
 * How deep a tool sinks into something under a hand that wanders over it and turns at random, and how it is shaken.
 */
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <span>

#include "tests/support/random.h"
#include "tests/support/shape/finer_mesh.h"
#include "tests/support/shape/signed_gap.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd::test {

/** Calls visit(x, radius) for balls along the axis that fill most of the mantle, and for points of edges. */
template <class Visit>
void onSurface(const Shape& shape, const Visit& visit) {
  constexpr int kPlaces = 80;
  for (int j = 0; j <= kPlaces; ++j) {
    const double t = 2.0 * j / kPlaces - 1, radius = shape.size.x(), half = shape.size.y();
    const bool can = shape.kind == ShapeKind::kCylinder;
    if (shape.kind == ShapeKind::kBox) {
      onBoxEdges(shape.size, t, [&](const Vec3& x) { visit(x, 0); });
    } else if (!can || std::abs(t) * half + radius <= half) {
      visit({0, 0, t * half}, radius);
    }
    if (!can) continue;
    const double angle = EIGEN_PI * t;
    for (const double z : {-half, half}) visit({radius * std::cos(angle), radius * std::sin(angle), z}, 0);
  }
}

/** Boxes, cylinders and capsules, each sampled against the other: at which pose in which frame the names tell. */
inline double depthOf(const Shape& tool, const Shape& ground, const Pose& X_TG) {
  double deepest = 0;
  onSurface(tool, [&](const Vec3& x, double radius) {
    deepest = std::max(deepest, radius - signedGap(ground, X_TG.inverse() * x));
  });
  onSurface(ground,
            [&](const Vec3& x, double radius) { deepest = std::max(deepest, radius - signedGap(tool, X_TG * x)); });
  return deepest;
}

inline const Shape kStylus{ShapeKind::kCapsule, {0.002, 0.06, 0}}, kSpoke{ShapeKind::kCylinder, {0.003, 0.05, 0}};
inline const Shape kTub{ShapeKind::kCylinder, {0.01, 0.02, 0}}, kBrick{ShapeKind::kBox, {0.01, 0.02, 0.005}};
inline const Shape kBlock{ShapeKind::kBox, {0.02, 0.015, 0.01}}, kTin{ShapeKind::kCylinder, {0.02, 0.012, 0}};

/** A tool and what it is on. Boxes may be meshes: of so many parts along an edge of each of 12 triangles; 0: of none.
 */
struct ToolOnGround {
  Shape tool, ground;
  int tool_parts = 0, ground_parts = 0;
  Vec3 first_turn = Vec3::Zero();
  double friction = 0;
};

struct Wandered {
  double deepest = 0;  ///< [m]
  double shaken = 0;   ///< By how much the contact's force changed from tick to tick, in all [N].
};

/** Where the ground's parts are, in the world. */
struct Placed {
  Shape shape;
  Pose X_WP;
};

/** Where the hand goes: to another place every 300 ticks, and it turns by so much a tick [rad]. */
struct Wandering {
  std::function<Vec3(int)> place;  ///< By its number.
  double turning = 0.003;
};

/** Anywhere near to the origin. */
inline Wandering anywhere(Random& random) {
  return {[&random](int) { return random.vector(0.03); }};
}

/** What is held wanders from where the hand is for 3000 ticks; expects that it touches in many. `depth` now and then.
 */
template <class Depth>
Wandered wanderOver(ToolHouse& house, const Depth& depth, Vec3 hand, Vec3 turn, const Wandering& wandering,
                    Random& random) {
  Wandered wandered;
  Vec3 to = hand, force = Vec3::Zero();
  int touched = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 300 == 0) to = wandering.place(i / 300);
    hand += 0.004 * (to - hand);
    turn += random.vector(wandering.turning);
    house.aim(hand, turn);
    house.run(1);
    const auto& last = house.servo->cycle().tool(0).last();
    touched += last.touching > 0;
    wandered.shaken += (last.contact.force - force).norm();
    force = last.contact.force;
    if (i % 4 == 0) wandered.deepest = std::max(wandered.deepest, depth(house.place()));
  }
  EXPECT_GT(touched, 500);
  return wandered;
}

/** In the deepest of the parts of a ground, at a pose of the tool. */
inline double depthIn(std::span<const Placed> ground, const Shape& tool, const Pose& X_WT) {
  double deepest = 0;
  for (const Placed& part : ground) deepest = std::max(deepest, depthOf(tool, part.shape, X_WT.inverse() * part.X_WP));
  return deepest;
}

/** A house without a floor. */
inline std::unique_ptr<ToolHouse> houseWithoutFloor() {
  auto house = std::make_unique<ToolHouse>();
  house->send(CommandKind::kObjectPose, hd_object_pose{kFloor, 0, {0, 0, -1}, {1, 0, 0, 0}, {}, {}});
  return house;
}

inline Wandered wander(const ToolOnGround& pair, Random& random) {
  const Pose X_WG{Vec3::Zero(), random.turn()};
  const auto meshOf = [](const Shape& shape, int parts, const Pose& X) {
    TestMesh block = boxMesh(shape.size);
    block.flags = HD_MESH_CLOSED;
    return finer(block, std::max(1, parts), X);
  };
  TestMesh held = meshOf(pair.tool, pair.tool_parts, {}), mesh = meshOf(pair.ground, pair.ground_parts, X_WG);
  const auto house = houseWithoutFloor();
  house->meshes.publish(3, held.view());
  house->meshes.publish(4, mesh.view());
  pair.tool_parts > 0 ? house->reshape(ShapeKind::kMesh, Vec3::Zero(), 3)
                      : house->reshape(pair.tool.kind, pair.tool.size);
  AddObject obstacle = object(kWall, ShapeKind::kMesh, Vec3::Zero(), Vec3::Zero());
  obstacle.shape.mesh = 4;
  if (pair.ground_parts == 0) {
    obstacle = object(kWall, pair.ground.kind, pair.ground.size, Vec3::Zero());
    store(X_WG.q, obstacle.q);
  }
  obstacle.material = {1000, 0, pair.friction, pair.friction};
  const Vec3 hand(0, 0, 0.07);
  house->aim(hand, pair.first_turn);
  house->run(500);
  house->send(CommandKind::kAddObject, obstacle);
  house->hold();
  const Placed ground{pair.ground, X_WG};
  const auto depth = [&](const Pose& X_WT) { return depthIn({&ground, 1}, pair.tool, X_WT); };
  return wanderOver(*house, depth, hand, pair.first_turn, anywhere(random), random);
}

/** Over a ground of several boxes and the like, without friction. */
inline Wandered wander(const Shape& tool, std::span<const Placed> ground, const Vec3& hand, const Vec3& turn,
                       Random& random) {
  const auto house = houseWithoutFloor();
  house->reshape(tool.kind, tool.size);
  house->aim(hand, turn);
  house->run(500);
  for (std::size_t i = 0; i < ground.size(); ++i) {
    const auto id = makeObjectId(static_cast<std::uint32_t>(10 + i), 1);
    AddObject part = object(id, ground[i].shape.kind, ground[i].shape.size, ground[i].X_WP.p);
    store(ground[i].X_WP.q, part.q);
    part.material = {1000, 0, 0, 0};
    house->send(CommandKind::kAddObject, part);
  }
  house->hold();
  const auto depth = [&](const Pose& X_WT) { return depthIn(ground, tool, X_WT); };
  return wanderOver(*house, depth, hand, turn, anywhere(random), random);
}

}  // namespace hapticd::test
