// What a tool may touch soon: what is near, and of too many the nearest.
#include "rt/cycle/obstacles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "tests/support/seeds.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

struct Asked {
  Asked() { tool = world.add(ShapeKind::kSphere, {0.01, 0, 0}); }
  void ask(double speed = 0) {
    world.scene->advance(test::kTick);
    held = CollideRequest::Held{};
    held.speed = speed;
    findObstacles(*world.scene, *world.scene->find(tool), {}, held);
  }
  [[nodiscard]] bool has(std::uint32_t object) const {
    return std::any_of(held.obstacle.begin(), held.obstacle.begin() + held.count,
                       [&](const auto& obstacle) { return obstacle.slot == objectSlot(object); });
  }
  test::TestScene world;
  std::uint32_t tool;
  CollideRequest::Held held;
};

TEST(Obstacles, OfTooManyTheNearestAreAsked) {
  std::mt19937 random(seedOf(3));
  for (int round = 0; round < 20; ++round) {
    Asked a;
    // Balls of 5 mm all about, each within reach; and the floor, which the tool lies on, as the last of all.
    std::vector<std::pair<double, std::uint32_t>> apart;
    for (int i = 0; i < 40; ++i) {
      const Vec3 way = Vec3(std::normal_distribution<>()(random), std::normal_distribution<>()(random),
                            std::normal_distribution<>()(random))
                           .normalized();
      const double gap = std::uniform_real_distribution<>(0.001, 0.019)(random);
      apart.emplace_back(gap, a.world.add(ShapeKind::kSphere, {0.005, 0, 0}, {(0.015 + gap) * way, Quat::Identity()}));
    }
    apart.emplace_back(0, a.world.add(ShapeKind::kPlane, Vec3::Zero(), {{0, 0, -0.01}, Quat::Identity()}));
    a.ask();
    ASSERT_EQ(a.held.count, CollideRequest::kMostObstacles);
    std::sort(apart.begin(), apart.end());
    for (std::uint32_t i = 0; i < a.held.count; ++i) EXPECT_TRUE(a.has(apart[i].second)) << i;
  }
}

TEST(Obstacles, WhatHasNoStiffnessTakesNobodysPlace) {
  Asked a;
  for (int i = 0; i < 20; ++i) {
    (void)a.world.add(ShapeKind::kSphere, {0.005, 0, 0}, {{0.016, 0, 0}, Quat::Identity()}, {0, 0, 0, 0});
  }
  const std::uint32_t farther = a.world.add(ShapeKind::kSphere, {0.005, 0, 0}, {{0.03, 0, 0}, Quat::Identity()});
  a.ask();
  EXPECT_EQ(a.held.count, 1u);
  EXPECT_TRUE(a.has(farther));
}

TEST(Obstacles, WhatComesFastIsAskedFromFarther) {
  Asked a;
  const std::uint32_t ball = a.world.add(ShapeKind::kSphere, {0.005, 0, 0}, {{0.07, 0, 0}, Quat::Identity()});
  const std::uint32_t wall = a.world.add(ShapeKind::kPlane, Vec3::Zero(),
                                         {{-0.1, 0, 0}, Quat(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitY()))});
  a.ask();
  EXPECT_FALSE(a.has(ball)) << "55 mm of air between them";
  EXPECT_FALSE(a.has(wall)) << "90 mm";
  a.ask(4);
  EXPECT_TRUE(a.has(ball)) << "the tool is fast";
  EXPECT_FALSE(a.has(wall));
  a.ask(8);
  EXPECT_TRUE(a.has(wall));
  a.world.pose(ball, {{0.066, 0, 0}, Quat::Identity()}, {Vec3(-4, 0, 0), Vec3::Zero()});
  a.ask();
  EXPECT_TRUE(a.has(ball)) << "the ball is fast";
  EXPECT_NEAR(a.held.speed, 4, 1e-9);
}

TEST(Obstacles, WhatTurnsFastUnderTheToolIsAskedFromFartherToo) {
  Asked a;
  const std::uint32_t ball = a.world.add(ShapeKind::kSphere, {0.005, 0, 0}, {{0.066, 0, 0}, Quat::Identity()});
  // About the line to the tool, whose middle it leaves alone: at its rim, 1 cm from there, it is fast.
  a.world.pose(ball, {{0.066, 0, 0}, Quat::Identity()}, {Vec3::Zero(), Vec3(400, 0, 0)});
  a.ask();
  EXPECT_TRUE(a.has(ball));
  EXPECT_NEAR(a.held.speed, 4, 1e-9);
}

TEST(Obstacles, EachQuestionBeginsAnew) {
  Asked a;
  for (int i = 0; i < 3; ++i) (void)a.world.add(ShapeKind::kSphere, {0.005, 0, 0}, {{0.02, 0, 0}, Quat::Identity()});
  a.ask();
  ASSERT_EQ(a.held.count, 3u);
  findObstacles(*a.world.scene, *a.world.scene->find(a.tool), {}, a.held);
  EXPECT_EQ(a.held.count, 3u);
}

TEST(Obstacles, AQuestionIsCopiedAsFarAsItGoes) {
  auto from = std::make_unique<CollideRequest>(), to = std::make_unique<CollideRequest>();
  Asked a;
  for (int i = 0; i < 3; ++i) (void)a.world.add(ShapeKind::kSphere, {0.005, 0, 0}, {{0.02, 0, 0}, Quat::Identity()});
  a.ask(0.5);
  a.held.object = 7;
  from->held[2] = a.held;
  from->held[2].V_WO.w.x() = 3;
  from->orders = 5;
  to->held[3].object = 9;
  to->held[2].count = 16;
  *to = *from;
  EXPECT_EQ(to->orders, 5u);
  EXPECT_EQ(to->held[3].object, 0u) << "what is gone is gone";
  const CollideRequest::Held &x = from->held[2], &y = to->held[2];
  EXPECT_EQ(y.object, 7u);
  EXPECT_EQ(y.shape.size, x.shape.size);
  EXPECT_EQ(y.X_WO.p, x.X_WO.p);
  EXPECT_EQ(y.V_WO.w, x.V_WO.w);
  EXPECT_EQ(y.speed, 0.5);
  ASSERT_EQ(y.count, 3u);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(y.obstacle[i].slot, x.obstacle[i].slot);
    EXPECT_EQ(y.obstacle[i].shape.number, x.obstacle[i].shape.number);
    EXPECT_EQ(y.obstacle[i].X_WO.p, x.obstacle[i].X_WO.p);
  }
}

TEST(Obstacles, NoPointOfAToolIsFasterThanIsSaid) {
  // A centre of mass beside the shape: a hammer held as a ball.
  test::TestScene world;
  const std::uint32_t id = world.add(ShapeKind::kSphere, {0.01, 0, 0}, {{0.1, 0.2, 0.3}, Quat(0.5, 0.5, -0.5, 0.5)});
  world.scene->advance(test::kTick);
  const SceneObject& object = *world.scene->find(id);
  MassProperties mass = MassProperties::ofBall(0.1, 0.01);
  mass.com_O = Vec3(0.03, -0.02, 0.01);
  RigidBody body(mass);
  body.place(object.X_WO);
  std::mt19937 random(seedOf(4));
  std::normal_distribution<> n;
  double nearest = 0;
  for (int i = 0; i < 2000; ++i) {
    if (i % 20 == 0)
      body.setTwist({0.3 * Vec3(n(random), n(random), n(random)), 20 * Vec3(n(random), n(random), n(random))});
    const Vec3 x = object.center_W + 0.01 * Vec3(n(random), n(random), n(random)).normalized();
    const Twist& V = body.twist();
    const double speed = (V.v + V.w.cross(x - body.com())).norm();
    const double bound = speedBound(body, object);
    ASSERT_LE(speed, bound * (1 + 1e-12));
    nearest = std::max(nearest, speed / bound);
  }
  EXPECT_GT(nearest, 0.9) << "nor is it said to be much faster";
}

}  // namespace
}  // namespace hapticd
