/** @file
 * Free bodies and solids of any kind and size that come to be in each other in any way, alone and beside others: a body
 * goes no faster than it is led, keeps no motion of it, moves nobody else, and alone comes out.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/overlap.h"
#include "tests/support/shape/signed_gap.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kSolid = makeObjectId(20, 1), kInside = makeObjectId(21, 1), kBeside = makeObjectId(22, 1);
constexpr double kLedTick = 1e-3;  ///< [s]

/** In the air, without weight. */
struct PutTogether {
  explicit PutTogether(unsigned seed) : random(seed) {
    house = test::houseWithoutFloor();
    house->aim({0.5, 0.5, 0.3});
    house->run(5);
  }
  Shape anyShape(double least, double most) {
    constexpr ShapeKind kKinds[] = {ShapeKind::kBox, ShapeKind::kCylinder, ShapeKind::kCapsule};
    return {kKinds[random.below(3)], {random.in(least, most), random.in(least, most), random.in(least, most)}};
  }
  void add(std::uint32_t id, const Shape& shape, const Pose& X, bool moves, bool falls = false) {
    AddObject order = test::object(id, shape.kind, shape.size, X.p);
    store(X.q, order.q);
    if (shape.kind == ShapeKind::kMesh) {
      test::TestMesh& mesh = *meshes.emplace_back(std::make_unique<test::TestMesh>(test::boxMesh(shape.size)));
      mesh.flags = HD_MESH_CLOSED;
      order.shape.mesh = static_cast<std::uint32_t>(meshes.size());
      house->meshes.publish(order.shape.mesh, mesh.view());
    }
    house->send(CommandKind::kAddObject, order);
    if (!moves) return;
    SetBody body{};
    body.object = id;
    body.falls = falls ? 1 : 0;
    body.mass = std::pow(10, random.in(-3, 0));
    const double most = shape.size.maxCoeff();
    for (int i = 0; i < 3; ++i) body.inertia[i] = 0.4 * body.mass * most * most;
    house->send(CommandKind::kSetBody, body);
  }
  /** What stands comes to be about the body at X, or it the other way round. */
  void meet(const Shape& solid, const Shape& inside, const Pose& X) {
    const int how = random.below(5);
    const Pose away{{0, 0, 1}, X.q};
    add(kSolid, solid, how == 0 ? away : Pose{}, false);
    if (how == 1) house->send(CommandKind::kObjectFlags, hd_object_flags{kSolid, HD_OBJECT_ENABLED, 0});
    if (how == 2) house->send(CommandKind::kObjectMaterial, hd_object_material{kSolid, 0, {}});
    add(kInside, inside, how == 3 ? away : X, true);
    house->run(50);
    if (how == 0) house->send(CommandKind::kObjectPose, poseMessage(kSolid, {}));
    if (how == 1) house->send(CommandKind::kObjectFlags, hd_object_flags{kSolid, HD_OBJECT_ENABLED, HD_OBJECT_ENABLED});
    if (how == 2) house->send(CommandKind::kObjectMaterial, hd_object_material{kSolid, 0, {1000, 0, 0.4, 0.3}});
    if (how == 3) house->send(CommandKind::kObjectPose, poseMessage(kInside, X));
    house->run(1);
  }
  [[nodiscard]] const RigidBody& body(std::uint8_t k) const { return house->servo->cycle().bodies().body(k).body; }

  Random random;
  std::vector<std::unique_ptr<test::TestMesh>> meshes;
  std::unique_ptr<test::ToolHouse> house;
};

TEST(PutInsideProperty, WhatIsAloneInSomethingComesOutSlowly) {
  unsigned inside = 0;
  forSeeds(60, [&](unsigned seed) {
    PutTogether scene(seed);
    const Shape solid = scene.anyShape(0.02, 0.04), body = scene.anyShape(0.003, 0.01);  // It looks out of one side.
    const Pose X{scene.random.vector(0.02), scene.random.turn()};
    const double deep = test::depthOf(body, solid, X.inverse());
    scene.meet(solid, body, X);
    inside += deep > 1e-3;
    for (int i = 0, still = 0; i < 1200 && still < 100; ++i) {
      const Pose before = scene.body(0).pose();
      scene.house->run(1);
      const Pose after = scene.body(0).pose();
      still = after.p == before.p ? still + 1 : 0;
      ASSERT_LE((after.p - before.p).norm(), 1.01 * Tool::kRecoverSpeed * kLedTick) << "tick " << i;
      ASSERT_LT(after.q.angularDistance(before.q), 1e-6) << "tick " << i;
      ASSERT_LT(scene.body(0).twist().v.norm(), 1e-6) << "tick " << i;
    }
    EXPECT_LT(test::depthOf(body, solid, scene.body(0).pose().inverse()), 5e-4)
        << static_cast<int>(body.kind) << " in " << static_cast<int>(solid.kind) << ", it was " << deep << " deep";
  });
  EXPECT_GT(inside, drawn(60) / 3);
}

/** Two of one size, plates that cross, or any; of every pair of kinds, as deep as may be, one of them standing or not.
 */
TEST(PutInsideProperty, WhateverIsMadeInEachOtherComesApart) {
  constexpr ShapeKind kKinds[] = {ShapeKind::kBox, ShapeKind::kCylinder, ShapeKind::kCapsule, ShapeKind::kSphere,
                                  ShapeKind::kMesh};
  enum Family : std::uint8_t { kSamePlace, kAlike, kPlates, kAny };
  constexpr int kTicks = 2500;
  unsigned inside = 0;
  forSeeds({122, 239}, 50, [&](unsigned seed) {
    PutTogether scene(seed);
    Random& random = scene.random;
    const auto family = static_cast<Family>(random.below(4));
    Shape first{kKinds[seed % 5], {random.in(0.004, 0.02), random.in(0.004, 0.02), random.in(0.004, 0.02)}};
    Shape second{kKinds[seed / 5 % 5], first.size};
    if (family == kAny) second.size = {random.in(0.004, 0.02), random.in(0.004, 0.02), random.in(0.004, 0.02)};
    for (Shape* shape : {&first, &second}) {
      if (family == kPlates) shape->size[shape->kind == ShapeKind::kCylinder ? 1 : 2] = random.in(0.0005, 0.002);
    }
    Pose X_first, X_second;
    if (family != kSamePlace) {
      X_first.q = random.turn();
      X_second = {random.vector(0.003), random.turn()};
    }
    const double deep = test::overlapOf(first, X_first, second, X_second);
    inside += deep > 1e-3;
    const bool stands = random.once(3), turned = random.once(2);
    scene.add(turned ? kInside : kSolid, first, X_first, !stands);
    scene.add(turned ? kSolid : kInside, second, X_second, true);
    scene.house->run(1);
    const std::uint8_t count = stands ? 1 : 2;
    const auto overlap = [&] {
      return test::overlapOf(first, stands ? X_first : scene.body(0).pose(), second, scene.body(count - 1).pose());
    };
    for (int i = 0; i < kTicks && (i % 100 > 0 || overlap() > 1e-4); ++i) {
      std::array<Pose, 2> before;
      for (std::uint8_t k = 0; k < count; ++k) before[k] = scene.body(k).pose();
      scene.house->run(1);
      for (std::uint8_t k = 0; k < count; ++k) {
        const Pose after = scene.body(k).pose();
        ASSERT_LE((after.p - before[k].p).norm(), 1.01 * Tool::kRecoverSpeed * kLedTick) << "tick " << i;
        ASSERT_LT(after.q.angularDistance(before[k].q), 1e-6) << "tick " << i;
        ASSERT_LT(scene.body(k).twist().v.norm(), 1e-6) << "tick " << i;
      }
    }
    EXPECT_LT(overlap(), 3e-4) << static_cast<int>(first.kind) << " and " << static_cast<int>(second.kind)
                               << ", family " << static_cast<int>(family) << ", they were " << deep << " in each other";
  });
  EXPECT_GT(inside, drawn(50) * 7 / 10);
}

/** Above a floor or in it: what they gain is what they are lifted by, so that nothing is thrown, and they come apart.
 */
TEST(PutInsideProperty, WhatIsMadeInEachOtherUnderWeightGainsNoEnergy) {
  constexpr double kGravity = 9.81;
  int inside = 0;
  forSeeds({138}, 12, [&](unsigned seed) {
    PutTogether scene(seed);
    Random& random = scene.random;
    scene.add(makeObjectId(30, 1), {ShapeKind::kBox, {0.2, 0.2, 0.02}}, {{0, 0, -0.02}, Quat::Identity()}, false);
    scene.house->send(CommandKind::kSetGravity, SetGravity{{0, 0, -kGravity}});
    std::array<Shape, 2> shape;
    for (Shape& one : shape) one = scene.anyShape(0.004, 0.02);
    if (random.once(2)) shape[1] = shape[0];
    for (std::uint8_t k = 0; k < 2; ++k) {
      const Pose X{Vec3(0, 0, 0.01) + random.vector(0.004), random.once(2) ? Quat::Identity() : random.turn()};
      scene.add(k == 0 ? kSolid : kInside, shape[k], X, true, true);
    }
    scene.house->run(1);
    const auto overlap = [&] {
      return test::overlapOf(shape[0], scene.body(0).pose(), shape[1], scene.body(1).pose());
    };
    inside += overlap() > 1e-3;
    double mass = 0, lifted = 0;  // [kg, J]
    const auto energy = [&](const RigidBody& body) {
      return body.kineticEnergy() + kGravity * body.mass() * body.com().z();
    };
    const double first = energy(scene.body(0)) + energy(scene.body(1));
    for (int i = 0; i < 900; ++i) {
      const std::array<Vec3, 2> was{scene.body(0).com(), scene.body(1).com()};
      scene.house->run(1);
      double now = 0;
      mass = 0;
      for (std::uint8_t k = 0; k < 2; ++k) {
        const RigidBody& body = scene.body(k);
        const Vec3 led = body.com() - was[k] - kLedTick * body.twist().v;
        ASSERT_LE(led.norm(), 1.01 * Tool::kRecoverSpeed * kLedTick) << "tick " << i;
        lifted += kGravity * body.mass() * led.z();
        now += energy(body);
        mass += body.mass();
      }
      ASSERT_LT(now - first - lifted, 1e-6 * mass) << "tick " << i;
    }
    EXPECT_LT(overlap(), 5e-4);
  });
  EXPECT_GT(inside, drawn(8));
}

/** Whatever lies about it, near or in it: only what is in something itself is led. */
TEST(PutInsideProperty, NobodyIsPushedByWhatIsLed) {
  unsigned led = 0, overlapped = 0;
  forSeeds(30, [&](unsigned seed) {
    PutTogether scene(seed);
    const Shape solid = scene.anyShape(0.01, 0.04), body = scene.anyShape(0.003, 0.015);
    const Shape beside = scene.anyShape(0.003, 0.015);
    const Pose X{scene.random.vector(0.02), scene.random.turn()};
    const Pose X_beside{scene.random.vector(0.04), scene.random.turn()};
    scene.meet(solid, body, X);
    const bool moves = !scene.random.once(3);
    scene.add(kBeside, beside, X_beside, moves);
    const bool overlaps =
        test::depthOf(beside, solid, X_beside.inverse()) > 0 || test::depthOf(beside, body, X_beside.inverse() * X) > 0;
    overlapped += overlaps;
    const Vec3 stood = scene.body(0).com();
    scene.house->run(1);
    const Vec3 other = scene.body(1).com();
    for (int i = 0; i < 800; ++i) {
      scene.house->run(1);
      for (std::uint8_t k = 0; k < (moves ? 2 : 1); ++k)
        ASSERT_LT(scene.body(k).twist().v.norm(), 1e-6) << static_cast<int>(k) << " in tick " << i;
    }
    led += (scene.body(0).com() - stood).norm() > 1e-3;
    if (moves && !overlaps) {
      EXPECT_LT((scene.body(1).com() - other).norm(), 1e-6);
    }
  });
  EXPECT_GT(led, drawn(30) / 6);
  EXPECT_GT(overlapped, drawn(30) / 6);
}

/** What is made, or brought by a pose, about a body that a tool presses, for any time. */
TEST(PutInsideProperty, WhatAToolPressedMeanwhileComesOutSlowly) {
  unsigned pressed = 0;
  forSeeds(24, [&](unsigned seed) {
    PutTogether scene(seed);
    test::ToolHouse& house = *scene.house;
    Random& random = scene.random;
    house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
    const Vec3 half(random.in(0.008, 0.02), random.in(0.008, 0.02), random.in(0.004, 0.01));
    const double deep = random.in(0.0005, half.z()), thick = 0.02;
    const Vec3 under(0.1, 0.1, thick), place(0, 0, -thick);
    scene.add(makeObjectId(30, 1), {ShapeKind::kBox, under}, {place, Quat::Identity()}, false);
    scene.add(kInside, {ShapeKind::kBox, half}, {{0, 0, half.z()}, fromRotationVector({0, 0, random.in(0, 3)})}, false);
    SetBody body{};
    body.object = kInside;
    body.falls = 1;
    body.mass = random.in(2, 10);
    for (int i = 0; i < 3; ++i) body.inertia[i] = 1e-4 * body.mass;
    house.send(CommandKind::kSetBody, body);
    house.aim({0, 0, 0.1});
    house.run(500);
    house.hold();
    house.aim({random.in(-0.3, 0.3) * half.x(), random.in(-0.3, 0.3) * half.y(), 2 * half.z() + random.in(0, 0.004)});
    house.run(600);
    const bool by_pose = random.below(3) == 0;
    const Pose about{place + Vec3(0, 0, deep), Quat::Identity()};
    scene.add(kSolid, {ShapeKind::kBox, under}, by_pose ? Pose{{0, 0, -1}, Quat::Identity()} : about, false);
    if (by_pose) house.send(CommandKind::kObjectPose, poseMessage(kSolid, about));
    const auto goesOn = [&](int ticks) {
      for (int i = 0; i < ticks; ++i) {
        const Vec3 before = scene.body(0).com();
        house.run(1);
        const Vec3 led = scene.body(0).com() - before - kLedTick * scene.body(0).twist().v;
        ASSERT_LE(led.norm(), 1.01 * Tool::kRecoverSpeed * kLedTick) << "tick " << i;
        ASSERT_LT(scene.body(0).twist().v.norm(), 1.01 * Tool::kRecoverSpeed) << "tick " << i;
      }
    };
    goesOn(50 + static_cast<int>(random.below(400)));
    pressed += scene.body(0).com().z() < half.z() + 1e-4;
    house.aim({0, 0, 0.1});
    goesOn(800);
    EXPECT_NEAR(scene.body(0).com().z(), deep + half.z(), 3 * Tool::kSlop);
  });
  EXPECT_GT(pressed, drawn(24) / 3);
}

/** Each is led by what either knows: the other's way, back; whether one holds the other, or they are alike. */
TEST(PutInsideProperty, TwoInEachOtherTakeOppositeWays) {
  int deep = 0, opposite = 0;
  forSeeds(50, [&](unsigned seed) {
    PutTogether scene(seed);
    const bool alike = scene.random.once(2), same = alike && scene.random.once(2);
    const Shape solid = scene.anyShape(0.02, 0.04), other = scene.anyShape(0.003, 0.01);
    const Shape& body = alike ? solid : other;
    const Pose X = same ? Pose{} : Pose{scene.random.vector(0.03), scene.random.turn()};
    if (test::overlapOf(solid, {}, body, X) < 2e-3) return;
    scene.house->run(500);  // The hand has gone: it would push what is large.
    scene.add(kSolid, solid, {}, true);
    scene.add(kInside, body, X, true);
    scene.house->run(1);
    const Vec3 first = scene.body(0).com(), second = scene.body(1).com();
    scene.house->run(15);
    const Vec3 a = scene.body(0).com() - first, b = scene.body(1).com() - second;
    ++deep;
    opposite += a.norm() > 5e-4 && b.norm() > 5e-4 && a.normalized().dot(b.normalized()) < -0.9;
  });
  EXPECT_GT(deep, drawn(30));
  EXPECT_EQ(opposite, deep);
}

}  // namespace
}  // namespace hapticd
