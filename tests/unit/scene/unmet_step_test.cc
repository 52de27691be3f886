// What a pose brings where nobody could foresee it, and what is late only.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "rt/base/rotation.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestScene;

constexpr double kLong = 0.1;  ///< What comes is unmet for less than this [s].
const Vec3 kUnmetHalf(0.01, 0.01, 0.01);
const double kUnmetRadius = kUnmetHalf.norm();

struct Unmet : TestScene {
  std::uint32_t addBox(const Vec3& at, std::uint32_t parent = 0) {
    return add(ShapeKind::kBox, kUnmetHalf, {at, Quat::Identity()}, {1000, 0, 0, 0}, HD_OBJECT_ENABLED, parent);
  }
  void rest() {
    for (int i = 0; i < 200; ++i) scene->advance(kTick);
  }
  [[nodiscard]] bool isUnmet(std::uint32_t id) const { return scene->sinceUnmet(objectSlot(id)) < kLong; }
};

/** A body goes on by one period, however many the scene has missed: all bodies in flight were taken for put there. */
TEST(UnmetStep, AShorterWayThanItsVelocityTellsIsMet) {
  for (const int missed : {0, 1, 3, 15}) {
    Unmet t;
    const auto id = t.addBox(Vec3::Zero());
    t.rest();
    const Twist V{{3, 0, -2}, {0, 30, 10}};
    Pose X;
    for (int i = 0; i < 20; ++i) {
      X = {X.p + kTick * V.v, rotated(X.q, V.w, kTick)};
      t.pose(id, X, V);
      t.scene->advance(kTick * (1 + missed));
      EXPECT_FALSE(t.isUnmet(id)) << missed << " missed, tick " << i;
    }
  }
}

TEST(UnmetStep, WhatComesAsideOrAgainstItsVelocityIsUnmet) {
  struct {
    Pose step;
    Twist V;
    bool unmet;
  } cases[] = {
      {{{0.003, 0, 0}, Quat::Identity()}, {{3, 0, 0}, {0, 0, 0}}, false},
      {{{0.003, 0.0019, 0}, Quat::Identity()}, {{3, 0, 0}, {0, 0, 0}}, false},
      {{{0.003, 0.0021, 0}, Quat::Identity()}, {{3, 0, 0}, {0, 0, 0}}, true},
      {{{-0.0021, 0, 0}, Quat::Identity()}, {{3, 0, 0}, {0, 0, 0}}, true},
      {{{0.0052, 0, 0}, Quat::Identity()}, {{3, 0, 0}, {0, 0, 0}}, true},
      {{{0.0021, 0, 0}, Quat::Identity()}, {}, true},
      {{{0.0019, 0, 0}, Quat::Identity()}, {}, false},
      {{Vec3::Zero(), fromRotationVector({0, 0, 0.0019 / kUnmetRadius})}, {}, false},
      {{Vec3::Zero(), fromRotationVector({0, 0, 0.0021 / kUnmetRadius})}, {}, true},
      {{Vec3::Zero(), fromRotationVector({0, 0, 0.0050 / kUnmetRadius})}, {{0, 0, 0}, {0, 0, 5 / kUnmetRadius}}, false},
      {{Vec3::Zero(), fromRotationVector({0, 0, -0.0021 / kUnmetRadius})}, {{0, 0, 0}, {0, 0, 5 / kUnmetRadius}}, true},
  };
  int number = 0;
  for (const auto& c : cases) {
    Unmet t;
    const auto id = t.addBox(Vec3::Zero());
    t.rest();
    t.pose(id, c.step, c.V);
    t.scene->advance(kTick);
    EXPECT_EQ(t.isUnmet(id), c.unmet) << "case " << number;
    ++number;
  }
}

TEST(UnmetStep, OfAPlaneTheFirstMetreCounts) {
  for (const double turn : {0.0019, 0.0021}) {
    Unmet t;
    const auto id = t.add(ShapeKind::kPlane, Vec3::Zero());
    t.rest();
    t.pose(id, {Vec3::Zero(), fromRotationVector({turn, 0, 0})});
    t.scene->advance(kTick);
    EXPECT_EQ(t.isUnmet(id), turn > 0.002) << turn;
  }
}

/** Each by what the turn makes of it: far from the axis it comes far, on it no place of it comes to be elsewhere. */
TEST(UnmetStep, AGroupsTurnBringsItsPartsByTheirLevers) {
  const double turn = 0.02;
  for (const int levels : {1, 2}) {
    Unmet t;
    auto group = t.add(ShapeKind::kGroup, Vec3::Zero());
    const auto turned = group;
    if (levels == 2) group = t.add(ShapeKind::kGroup, Vec3::Zero(), {}, {}, HD_OBJECT_ENABLED, group);
    const auto near = t.addBox({0.01, 0, 0}, group), far = t.addBox({0.2, 0, 0}, group);
    t.rest();
    t.pose(turned, {Vec3::Zero(), fromRotationVector({0, 0, turn})});
    t.scene->advance(kTick);
    EXPECT_FALSE(t.isUnmet(near)) << levels;
    EXPECT_TRUE(t.isUnmet(far)) << levels;
    t.rest();
    const Twist V{{0, 0, 0}, {0, 0, turn / kTick}};
    t.pose(turned, {Vec3::Zero(), fromRotationVector({0, 0, 2 * turn})}, V);
    t.scene->advance(kTick);
    EXPECT_FALSE(t.isUnmet(far)) << levels << ": as its velocity tells";
  }
}

/** Nor what a part does by a velocity of its own, below a group that is posed. */
TEST(UnmetStep, APartsOwnVelocityIsForeseenToo) {
  for (const double ticks : {1.0, 16.0}) {
    Unmet t;
    const auto group = t.add(ShapeKind::kGroup, Vec3::Zero());
    const auto part = t.addBox({0.2, 0, 0}, group);
    t.pose(part, {Vec3(0.2, 0, 0), Quat::Identity()}, {{3 / ticks, 0, 0}, {0, 0, 80 / ticks}});
    t.rest();
    for (int i = 0; i < 20; ++i) {
      t.pose(group, {});
      t.scene->advance(ticks * kTick);
      EXPECT_FALSE(t.isUnmet(part)) << ticks << ", tick " << i;
    }
  }
}

/** What a part's own pose takes back is no step in the world. */
TEST(UnmetStep, IsOneOfTheWorld) {
  Unmet t;
  const auto group = t.add(ShapeKind::kGroup, Vec3::Zero());
  const auto part = t.addBox(Vec3::Zero(), group);
  t.rest();
  t.pose(group, {Vec3(0.05, 0, 0), Quat::Identity()});
  t.pose(part, {Vec3(-0.05, 0, 0), Quat::Identity()});
  t.scene->advance(kTick);
  EXPECT_FALSE(t.isUnmet(part));
}

/** From rest it steps; then its poses tell how fast it goes, until it turns back. */
TEST(UnmetStep, PosesTellWhatTheNextBrings) {
  for (const double speed : {1.5, 2.5, 5.0, 9.0}) {
    Unmet t;
    const auto id = t.addBox(Vec3::Zero());
    t.rest();
    Vec3 at = Vec3::Zero();
    for (int i = 0; i < 300; ++i) {
      t.pose(id, {at += Vec3(speed * kTick, 0, 0), Quat::Identity()});
      t.scene->advance(kTick);
    }
    EXPECT_FALSE(t.isUnmet(id)) << speed;
    t.pose(id, {at - Vec3(0.0021, 0, 0), Quat::Identity()});
    t.scene->advance(kTick);
    EXPECT_TRUE(t.isUnmet(id)) << speed;
  }
}

/** Contacts look no farther ahead than some ms: slow poses bring more than that. */
TEST(UnmetStep, SlowPosesOfWhatIsFastAreUnmet) {
  for (const double speed : {0.1, 0.3}) {
    Unmet t;
    const auto id = t.addBox(Vec3::Zero());
    t.rest();
    Vec3 at = Vec3::Zero();
    for (int i = 0; i < 16 * 30; ++i) {
      if (i % 16 == 0) t.pose(id, {at += Vec3(16 * speed * kTick, 0, 0), Quat::Identity()});
      t.scene->advance(kTick);
    }
    EXPECT_EQ(t.isUnmet(id), speed > 0.2) << speed;
  }
}

TEST(UnmetStep, WhatArrivesIsToldWithItsTickAndWhatMovesIsNot) {
  TestScene t;
  Scene& scene = *t.scene;
  std::uint64_t tick = 100;
  const auto next = [&](int ticks = 1) {
    for (int i = 0; i < ticks; ++i) {
      scene.advance(kTick);
      scene.expect(kTick, ++tick);
    }
  };
  scene.expect(kTick, tick);
  const auto group = t.add(ShapeKind::kGroup, Vec3::Zero());
  const auto part = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {}, {1000, 0, 0, 0}, HD_OBJECT_ENABLED, group);
  const std::uint32_t slot = objectSlot(part);
  std::uint64_t arrivals = scene.arrivals();
  const auto arrived = [&] { return std::exchange(arrivals, scene.arrivals()) != scene.arrivals(); };
  const auto unmetFor = [&] { return std::lround(scene.sinceUnmet(slot) / kTick); };
  EXPECT_EQ(scene.arrivedIn(slot), 100u) << "also before it is there";
  next(5);
  EXPECT_TRUE(arrived());
  EXPECT_EQ(scene.arrivedIn(slot), 100u);
  EXPECT_EQ(unmetFor(), 4);
  t.pose(group, {Vec3(0.001, 0, 0), Quat::Identity()}, {Vec3(0.1, 0, 0), Vec3::Zero()});
  next(5);
  t.material(part, {2000, 0, 0, 0});
  t.flags(part, HD_OBJECT_VISIBLE, HD_OBJECT_VISIBLE);
  next();
  EXPECT_EQ(scene.arrivedIn(slot), 100u);
  EXPECT_EQ(unmetFor(), 10);
  arrived();
  next(3);
  EXPECT_FALSE(arrived());
  t.pose(group, {Vec3(1, 0, 0), Quat::Identity()});
  next();
  EXPECT_TRUE(arrived());
  EXPECT_EQ(scene.arrivedIn(slot), 114u);
  EXPECT_EQ(scene.arrivedIn(objectSlot(group)), 114u);
  EXPECT_EQ(unmetFor(), 0);
  next(3);
  EXPECT_FALSE(arrived());
  const std::function<void()> felt[] = {
      [&] {
        t.setShape(part, {static_cast<std::uint32_t>(ShapeKind::kSphere), 0, {0.2, 0, 0}});
      },
      [&] { t.flags(part, HD_OBJECT_ENABLED, HD_OBJECT_ENABLED); },
      [&] {
        t.material(part, {1000, 0, 0, 0});
      }};
  for (int i = 0; i < 3; ++i) {
    if (i == 1) t.flags(part, HD_OBJECT_ENABLED, 0);
    if (i == 2) t.material(part, {0, 0, 0, 0});
    next(4);
    EXPECT_GE(unmetFor(), 4) << i;
    arrived();
    felt[i]();
    next();
    EXPECT_EQ(unmetFor(), 1) << i;
    EXPECT_EQ(arrived(), i < 2) << i;
    EXPECT_EQ(scene.arrivedIn(slot), 114u) << i;
  }
}

}  // namespace
}  // namespace hapticd
