// A body that was put into something that stands, or about which something has been put, comes out: slowly, the least
// way, and without a motion that would be left to it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/support/shape/signed_gap.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::object;

constexpr std::uint32_t kAbout = makeObjectId(20, 1), kPut = makeObjectId(21, 1);
const Vec3 kAboutHalf(0.05, 0.05, 0.04), kAboutAt(0.2, 0, 0.1);

enum class How : std::uint8_t { kMade, kMoved, kBlockMade, kBlockEnabled, kBlockGrown, kBlockFelt, kGrown };

struct Put {
  ShapeKind block, shape;
  Vec3 size;
  double deep;  ///< Its middle below the block's top [m].
  How how;
};

class PutHouse {
 public:
  PutHouse() { house.meshes.publish(3, mesh_.view()); }
  void addBlock(ShapeKind kind) {
    AddObject block = object(kAbout, kind, kAboutHalf, kAboutAt);
    block.shape.mesh = 3;
    house.send(CommandKind::kAddObject, block);
  }
  void addBody(const Put& put, const Vec3& at, double mass = 0.1) {
    house.send(CommandKind::kAddObject, object(kPut, put.shape, put.size, at));
    setFree(kPut, mass, true);
  }
  /** An object of that id moves freely from now on. */
  void setFree(std::uint32_t id, double mass = 0.1, bool falls = false) {
    SetBody order{};
    order.object = id;
    order.falls = falls ? 1 : 0;
    order.mass = mass;
    for (double* i = order.inertia; i < order.inertia + 3; ++i) *i = 1e-4 * mass;
    house.send(CommandKind::kSetBody, order);
  }
  void reshape(std::uint32_t id, ShapeKind kind, const Vec3& size) {
    SetShape order{id, 0, {static_cast<std::uint32_t>(kind), 3, {}}};
    store(size, order.shape.size);
    house.send(CommandKind::kSetShape, order);
  }
  void put(const Put& put) {
    const Vec3 at = kAboutAt + Vec3(0.001, 0.002, kAboutHalf.z() - put.deep);
    const Vec3 little = Vec3::Constant(1e-4);
    const hd_object_flags enabled{kAbout, HD_OBJECT_ENABLED, HD_OBJECT_ENABLED};
    if (put.how != How::kBlockMade) addBlock(put.block);
    if (put.how == How::kBlockEnabled) house.send(CommandKind::kObjectFlags, hd_object_flags{kAbout, enabled.mask, 0});
    if (put.how == How::kBlockFelt) house.send(CommandKind::kObjectMaterial, hd_object_material{kAbout, 0, {}});
    if (put.how == How::kBlockGrown) reshape(kAbout, ShapeKind::kBox, little);
    Put first = put;
    if (put.how == How::kGrown) first.size = little;
    const bool elsewhere = put.how == How::kMoved || put.how == How::kGrown;
    addBody(first, elsewhere ? Vec3(kAboutAt + Vec3(0, 0, 0.2)) : at);
    house.run(300);
    if (put.how == How::kBlockMade) addBlock(put.block);
    if (put.how == How::kBlockEnabled) house.send(CommandKind::kObjectFlags, enabled);
    if (put.how == How::kBlockFelt)
      house.send(CommandKind::kObjectMaterial, hd_object_material{kAbout, 0, {1000, 0, 0.4, 0.3}});
    if (put.how == How::kBlockGrown) reshape(kAbout, put.block, kAboutHalf);
    if (!elsewhere) return;
    hd_object_pose pose{kPut, 0, {}, {1}, {}, {}};
    store(at, pose.p);
    house.send(CommandKind::kObjectPose, pose);
    house.run(1);
    if (put.how == How::kGrown) reshape(kPut, put.shape, put.size);
  }
  [[nodiscard]] const FreeBody& body() const { return house.servo->cycle().bodies().body(0); }

  test::ToolHouse house;

 private:
  test::TestMesh mesh_ = test::boxMesh(kAboutHalf);
};

TEST(PutInside, ComesOutSlowlyAndStays) {
  const Vec3 ball(0.005, 0, 0), box(0.01, 0.01, 0.005);
  const Put cases[] = {{ShapeKind::kBox, ShapeKind::kSphere, ball, 0.004, How::kMade},
                       {ShapeKind::kMesh, ShapeKind::kSphere, ball, 0.025, How::kMoved},
                       {ShapeKind::kMesh, ShapeKind::kBox, box, 0.004, How::kMoved},
                       {ShapeKind::kBox, ShapeKind::kBox, box, 0.025, How::kBlockMade},
                       {ShapeKind::kMesh, ShapeKind::kBox, box, 0.012, How::kMade},
                       {ShapeKind::kBox, ShapeKind::kBox, {0.02, 0.01, 0.005}, 0.025, How::kMade},
                       {ShapeKind::kBox, ShapeKind::kBox, box, 0.025, How::kBlockEnabled},
                       {ShapeKind::kMesh, ShapeKind::kSphere, ball, 0.004, How::kBlockEnabled},
                       {ShapeKind::kMesh, ShapeKind::kSphere, ball, 0.025, How::kBlockGrown},
                       {ShapeKind::kBox, ShapeKind::kBox, box, 0.004, How::kBlockGrown},
                       {ShapeKind::kMesh, ShapeKind::kBox, box, 0.025, How::kBlockFelt},
                       {ShapeKind::kBox, ShapeKind::kSphere, ball, 0.004, How::kBlockFelt},
                       {ShapeKind::kBox, ShapeKind::kSphere, ball, 0.004, How::kGrown}};
  for (const Put& one : cases) {
    PutHouse scene;
    const std::string what = std::to_string(static_cast<int>(one.how)) + ": " +
                             std::string(one.block == ShapeKind::kMesh ? "mesh" : "box") + ", " +
                             (one.shape == ShapeKind::kBox ? "box " : "ball ") + std::to_string(one.deep);
    if (one.how != How::kMade) {
      scene.put(one);
    } else {
      scene.addBlock(one.block);
      scene.addBody(one, kAboutAt + Vec3(0.001, 0.002, kAboutHalf.z() - one.deep));
    }
    double fastest = 0, motion = 0;
    Vec3 was = scene.body().body.com();
    for (int i = 0; i < 800; ++i) {
      scene.house.run(1);
      if (i > 1) fastest = std::max(fastest, (scene.body().body.com() - was).norm() / 1e-3);
      motion = std::max(motion, scene.body().body.twist().v.norm());
      was = scene.body().body.com();
    }
    const double lies = kAboutAt.z() + kAboutHalf.z() + (one.shape == ShapeKind::kBox ? one.size.z() : one.size.x());
    EXPECT_NEAR(was.z(), lies, 2 * Tool::kSlop) << what;
    EXPECT_NEAR(was.x(), kAboutAt.x() + 0.001, 1e-6) << what << ": the least way";
    EXPECT_LE(fastest, 1.001 * Tool::kRecoverSpeed) << what;
    EXPECT_LT(motion, 1e-6) << what;
    EXPECT_TRUE(scene.body().asleep()) << what;
  }
}

/** Halfway out at the top it is put in at the bottom: that way leads back to nothing. */
TEST(PutInside, ComesOutAnewWhereItIsPutAnew) {
  PutHouse scene;
  const double size = 0.005;
  scene.addBlock(ShapeKind::kBox);
  scene.addBody({ShapeKind::kBox, ShapeKind::kSphere, {size, 0, 0}, 0, How::kMade},
                kAboutAt + Vec3(0, 0, kAboutHalf.z() - 0.02));
  scene.house.run(100);
  ASSERT_GT(scene.body().body.com().z(), kAboutAt.z() + kAboutHalf.z() - 0.015) << "it is being led up";
  hd_object_pose pose{kPut, 0, {}, {1}, {}, {}};
  store(kAboutAt - Vec3(0, 0, kAboutHalf.z() - 0.004), pose.p);
  scene.house.send(CommandKind::kObjectPose, pose);
  scene.house.run(800);
  EXPECT_NEAR(scene.body().body.com().z(), kAboutAt.z() - kAboutHalf.z() - size, 2 * Tool::kSlop);
}

/** Weight does not take it down meanwhile. */
TEST(PutInside, ComesOutAgainstItsWeight) {
  PutHouse scene;
  scene.house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
  scene.addBlock(ShapeKind::kMesh);
  scene.addBody({ShapeKind::kMesh, ShapeKind::kBox, {0.01, 0.01, 0.005}, 0, How::kMade},
                kAboutAt + Vec3(0, 0, kAboutHalf.z() - 0.02));
  double lowest = 1;
  for (int i = 0; i < 1000; ++i) {
    scene.house.run(1);
    lowest = std::min(lowest, scene.body().body.com().z());
  }
  EXPECT_GT(lowest, kAboutAt.z() + kAboutHalf.z() - 0.021);
  EXPECT_NEAR(scene.body().body.com().z(), kAboutAt.z() + kAboutHalf.z() + 0.005, 2 * Tool::kSlop);
  EXPECT_TRUE(scene.body().asleep());
}

/** Between two walls that both overlap it there is no way: it gives up, and lies still. */
TEST(PutInside, GivesUpWhereThereIsNoWay) {
  PutHouse scene;
  for (const double side : {-1.0, 1.0}) {
    scene.house.send(CommandKind::kAddObject, object(makeObjectId(side < 0 ? 30 : 31, 1), ShapeKind::kBox,
                                                     {0.05, 0.5, 0.5}, {side * 0.0549, 0.3, 0.6}));
  }
  scene.addBody({ShapeKind::kBox, ShapeKind::kSphere, {0.005, 0, 0}, 0, How::kMade}, {0, 0.3, 0.6});
  scene.house.run(4500);
  EXPECT_TRUE(scene.body().asleep());
  EXPECT_LT((scene.body().body.com() - Vec3(0, 0.3, 0.6)).norm(), 2e-4);
}

/** A block that somebody moves about it in one step, unmet, is no wall that comes: it was deep in there for ever. */
TEST(PutInside, ComesOutOfWhatStepsAboutIt) {
  PutHouse scene;
  const Vec3 ball(0.005, 0, 0);
  scene.addBlock(ShapeKind::kBox);
  const Vec3 at = kAboutAt + Vec3(0.15, 0, kAboutHalf.z() - 0.025);
  scene.addBody({ShapeKind::kBox, ShapeKind::kSphere, ball, 0.025, How::kMade}, at);
  scene.house.run(300);
  scene.house.send(CommandKind::kObjectPose, poseMessage(kAbout, {kAboutAt + Vec3(0.15, 0, 0), Quat::Identity()}));
  scene.house.run(800);
  const Vec3 x = scene.body().body.com() - kAboutAt - Vec3(0.15, 0, 0);
  EXPECT_GT(test::signedGap({ShapeKind::kBox, kAboutHalf}, x), ball.x() - 2 * Tool::kSlop);
}

/** Neither has a motion that could part them, and of what they lose nothing is left. */
TEST(PutInside, TwoBodiesThatAreMadeInEachOtherComeApart) {
  for (const double deep : {5e-4, 6e-3}) {
    for (const bool falls : {false, true}) {
      PutHouse scene;
      if (falls) scene.house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
      const Vec3 half(0.01, 0.01, 0.008), at(0.1, 0.1, falls ? half.z() : 0.3);
      scene.addBody({ShapeKind::kBox, ShapeKind::kBox, half, 0, How::kMade}, at);
      scene.house.run(400);
      const std::uint32_t other = makeObjectId(22, 1);
      scene.house.send(CommandKind::kAddObject,
                       object(other, ShapeKind::kBox, half, at + Vec3(5e-4, 3e-4, 2 * half.z() - deep)));
      scene.setFree(other, 0.1, true);
      const FreeBodies& bodies = scene.house.servo->cycle().bodies();
      double motion = 0;
      for (int i = 0; i < 600; ++i) {
        scene.house.run(1);
        motion = std::max({motion, bodies.body(0).body.twist().v.norm(), bodies.body(1).body.twist().v.norm()});
      }
      const Vec3 apart = bodies.body(1).body.com() - bodies.body(0).body.com();
      EXPECT_NEAR(apart.z(), 2 * half.z(), 2 * Tool::kSlop) << deep << falls;
      EXPECT_LT(apart.head<2>().norm(), 1e-3) << deep << falls;
      EXPECT_LT(motion, 0.01) << deep << falls;
    }
  }
}

/** It stops before it, and goes on when that has gone. */
TEST(PutInside, IsLedIntoNoBody) {
  PutHouse scene;
  const Put box{ShapeKind::kBox, ShapeKind::kBox, {0.01, 0.01, 0.005}, 0, How::kMade};
  const std::uint32_t hangs = makeObjectId(22, 1);
  const Vec3 above(0.1, 0.1, 0.012);
  scene.house.send(CommandKind::kAddObject, object(hangs, ShapeKind::kBox, box.size, above));
  scene.setFree(hangs);
  scene.house.run(20);
  scene.addBody(box, {0.1, 0.1, -0.001});
  const FreeBodies& bodies = scene.house.servo->cycle().bodies();
  scene.house.run(500);
  EXPECT_EQ(bodies.body(0).body.com(), above) << "to the bit";
  EXPECT_GT(bodies.body(1).body.com().z(), 0) << "it was led, ...";
  EXPECT_LT(bodies.body(1).body.com().z(), above.z() - 2 * box.size.z()) << "... and stopped";
  hd_object_pose pose{hangs, 0, {}, {1}, {}, {}};
  store(Vec3(0.3, 0.1, 0.3), pose.p);
  scene.house.send(CommandKind::kObjectPose, pose);
  scene.house.run(500);
  EXPECT_NEAR(bodies.body(1).body.com().z(), box.size.z(), 2 * Tool::kSlop);
}

/** Up out of a plate, and never out for a body above; then the plate has gone, and a block comes about its top. */
TEST(PutInside, NoWayOfAnotherTimeBindsIt) {
  PutHouse scene;
  const Put box{ShapeKind::kBox, ShapeKind::kBox, {0.01, 0.01, 0.005}, 0, How::kMade};
  constexpr double kTop = 0.3;
  const std::uint32_t hangs = makeObjectId(22, 1), later = makeObjectId(23, 1);
  const auto enable = [&](std::uint32_t id, std::uint32_t value) {
    scene.house.send(CommandKind::kObjectFlags, hd_object_flags{id, HD_OBJECT_ENABLED, value});
  };
  const auto move = [&](std::uint32_t id, const Vec3& to) {
    scene.house.send(CommandKind::kObjectPose, poseMessage(id, {to, Quat::Identity()}));
  };
  const Vec3 plate(0.05, 0.05, 0.01);
  scene.house.send(CommandKind::kAddObject, object(kAbout, ShapeKind::kBox, plate, {0.1, 0.1, kTop - plate.z()}));
  scene.house.send(CommandKind::kAddObject, object(later, ShapeKind::kBox, plate, {0.5, 0.1, kTop}));
  enable(later, 0);
  scene.house.send(CommandKind::kAddObject, object(hangs, ShapeKind::kBox, box.size, {0.1, 0.1, kTop + 0.0135}));
  scene.setFree(hangs);
  scene.house.run(20);
  scene.addBody(box, {0.1, 0.1, kTop - 0.001});
  const auto z = [&] { return scene.house.servo->cycle().bodies().body(1).body.com().z(); };
  scene.house.run(3600);
  EXPECT_LT(z(), kTop + 0.004) << "barred";
  enable(kAbout, 0);
  move(hangs, {0.4, 0.1, 0.4});
  scene.house.run(300);
  const double before = z();
  move(later, {0.1, 0.1, before + box.size.z() - 0.001 + plate.z()});
  scene.house.run(200);
  enable(later, HD_OBJECT_ENABLED);
  scene.house.run(1000);
  EXPECT_NEAR(before - z(), 0.001, 5e-5);
}

/** As many as may move, two in each place: two are looked at in a tick, and it comes to each as often. */
TEST(PutInside, ManyAreLedInTurns) {
  PutHouse scene;
  const Vec3 half(0.01, 0.008, 0.005);
  for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
    const std::uint32_t id = makeObjectId(20u + k, 1);
    scene.house.send(CommandKind::kAddObject, object(id, ShapeKind::kBox, half, {0.1, 0.1, 0.2 + 0.1 * (k / 2)}));
    scene.setFree(id);
  }
  scene.house.run(20);
  const FreeBodies& bodies = scene.house.servo->cycle().bodies();
  const auto com = [&](std::uint8_t k) { return bodies.body(k).body.com(); };
  std::array<std::uint32_t, kMaxBodies> led{};
  constexpr std::uint32_t kTicks = 80;
  for (std::uint32_t i = 0; i < kTicks; ++i) {
    std::array<Vec3, kMaxBodies> before;
    for (std::uint8_t k = 0; k < kMaxBodies; ++k) before[k] = com(k);
    scene.house.run(1);
    for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
      const double way = (com(k) - before[k]).norm();
      EXPECT_LE(way, 1.001e-3 * Tool::kRecoverSpeed);
      led[k] += way > 0 ? 1 : 0;
    }
    EXPECT_EQ(bodies.looks(), FreeBodies::kMostLooks);
  }
  for (const std::uint32_t each : led) EXPECT_EQ(each, kTicks * FreeBodies::kMostLooks / kMaxBodies);
  scene.house.run(1000);
  for (std::uint8_t k = 0; k < kMaxBodies; k += 2) EXPECT_NEAR((com(k + 1) - com(k)).norm(), 2 * half.z(), 1e-4);
  EXPECT_EQ(bodies.looks(), 0U) << "they are out";
}

/** Beside another body it stays: it would push that, with energy from nowhere. */
TEST(PutInside, PushesNoBodyAsItComesOut) {
  PutHouse scene;
  const Put box{ShapeKind::kBox, ShapeKind::kBox, {0.01, 0.01, 0.005}, 0, How::kMade};
  const Vec3 other(0.1, 0.1, 0.012);
  const std::uint32_t lies = makeObjectId(22, 1);
  scene.house.send(CommandKind::kAddObject, object(lies, ShapeKind::kBox, box.size, other));
  scene.addBody(box, {0.1, 0.1, 0.002});
  scene.setFree(lies);
  scene.house.run(500);
  EXPECT_NEAR(scene.body().body.com().z(), 0.002, 1e-4);
  EXPECT_NEAR(scene.house.servo->cycle().bodies().body(1).body.com().z(), other.z(), 1e-4);
}

/** A tool on it is not lifted; when that has gone it comes out. So heavy that what the tool has lost does not lift it.
 */
TEST(PutInside, WaitsForTheToolThatTouchesIt) {
  PutHouse scene;
  scene.house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
  scene.house.hold();
  scene.house.aim({0, 0, 0.011});  // Its bottom is at 6 mm, the body's top at 7.
  scene.house.run(1000);
  scene.addBody({ShapeKind::kBox, ShapeKind::kBox, {0.01, 0.01, 0.005}, 0, How::kMade}, {0, 0, 0.002}, 5);
  double highest = 0;
  for (int i = 0; i < 500; ++i) {
    scene.house.run(1);
    highest = std::max(highest, scene.body().body.com().z());
  }
  EXPECT_LT(highest, 0.002 + 1e-4);
  scene.house.aim({0, 0, 0.05});
  scene.house.run(1000);
  EXPECT_NEAR(scene.body().body.com().z(), 0.005, 2 * Tool::kSlop);
}

/** However long: what has come is nothing new any more when the tool goes. */
TEST(PutInside, ComesOutOfWhatCameWhileAToolPressedIt) {
  PutHouse scene;
  scene.house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
  const Vec3 half(0.01, 0.01, 0.005), block(0.05, 0.05, 0.01);
  scene.addBody({ShapeKind::kBox, ShapeKind::kBox, half, 0, How::kMade}, {0, 0, half.z()}, 5);
  scene.house.hold();
  scene.house.aim({0, 0, 0.012});  // By 3 mm into it.
  scene.house.run(1000);
  const double deep = 0.002;
  scene.house.send(CommandKind::kAddObject, object(kAbout, ShapeKind::kBox, block, {0, 0, deep - block.z()}));
  scene.house.run(4000);
  EXPECT_NEAR(scene.body().body.com().z(), half.z(), 1e-4);
  scene.house.aim({0, 0, 0.05});
  scene.house.run(1000);
  EXPECT_NEAR(scene.body().body.com().z(), deep + half.z(), 2 * Tool::kSlop);
  EXPECT_TRUE(scene.body().asleep());
}

/** A servo that wakes late is no hand that puts bodies elsewhere. */
TEST(PutInside, WhatFliesWhilePeriodsAreMissedWasNotPut) {
  PutHouse scene;
  const Vec3 at(0.3, 0, 0.3), v(3, 0, 0);
  scene.addBody({ShapeKind::kBox, ShapeKind::kSphere, {0.005, 0, 0}, 0, How::kMade}, at);
  scene.house.run(300);
  scene.house.send(CommandKind::kObjectPose, poseMessage(kPut, {at, Quat::Identity()}, {v, Vec3::Zero()}));
  for (int i = 0; i < 40; ++i) {
    if (i % 4 == 3) scene.house.clock.advance(5 * test::kPeriodNs);
    scene.house.run(1);
    EXPECT_GT(scene.house.servo->cycle().scene().sinceUnmet(objectSlot(kPut)), FreeBodies::kStale) << "tick " << i;
  }
  EXPECT_GT(scene.body().body.com().x(), at.x() + 0.1) << "it flew";
}

}  // namespace
}  // namespace hapticd
