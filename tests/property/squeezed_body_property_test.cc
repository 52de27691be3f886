/** @file
 * Free bodies between a wall and a press that clients move: there no motion suits both, and the press is as strong as
 * it takes.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rt/base/rotation.h"
#include "tests/support/for_seeds.h"
#include "tests/support/stepped/messages.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

constexpr double kGravity = 9.81;  // m/s^2
constexpr std::uint32_t kPress = makeObjectId(4, 1), kSide = makeObjectId(5, 1);

/** It presses sidewards, or down too; the body gets no more than goes with its speed. Notes the greatest ratio. */
void aSlowPressThrowsNothing(unsigned seed, double& most_squeezed) {
  Random random(seed);
  test::ToolHouse house;
  house.aim({0, 0, 0.2});
  const double mu = random.once(2) ? 0 : random.in(0, 1);
  AddObject side = test::object(kSide, ShapeKind::kPlane, Vec3::Zero(), {-0.07, 0, 0});
  store(Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitX()), side.q);
  side.material = {1000, 0, mu, 0.7 * mu};
  house.send(CommandKind::kAddObject, side);

  const ShapeKind kinds[] = {ShapeKind::kBox, ShapeKind::kSphere, ShapeKind::kCylinder, ShapeKind::kCapsule};
  const ShapeKind kind = kinds[random.below(4)];
  const Vec3 size{random.in(0.008, 0.015), random.in(0.008, 0.015), random.in(0.008, 0.015)};
  const double mass = std::pow(10, random.in(-2.3, -0.3));
  AddObject body = test::object(test::kWall, kind, size, {-0.04, 0, 0.03});
  store(random.turn(), body.q);
  body.material = {1000, 0, mu, 0.7 * mu};
  house.send(CommandKind::kAddObject, body);
  SetBody order{};
  order.object = test::kWall;
  order.falls = 1;
  order.mass = mass;
  const Mat3 inertia = MassProperties::ofBox(mass, 2 * size).inertia_O;
  for (int i = 0; i < 3; ++i) order.inertia[i] = inertia(i, i);
  house.send(CommandKind::kSetBody, order);

  Pose X{{0.03, 0, random.in(-0.01, 0.03)}, Quat::Identity()};
  if (!random.once(3)) X.q = random.turn();
  const Vec3 thick{random.in(0.01, 0.03), random.in(0.01, 0.03), random.in(0.004, 0.02)};
  AddObject press = test::object(kPress, ShapeKind::kBox, thick, X.p);
  store(X.q, press.q);
  press.material = {1000, 0, mu, 0.7 * mu};
  house.send(CommandKind::kAddObject, press);
  house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -kGravity}});
  house.run(500);

  const RigidBody& rigid = house.servo->cycle().bodies().body(0).body;
  const auto energy = [&] { return rigid.kineticEnergy() / mass + kGravity * rigid.com().z(); };
  const double speed = std::pow(10, random.in(-2, -0.7)), from = X.p.x();
  const Vec3 v{-speed, 0, random.once(2) ? 0 : -0.3 * speed};
  double least = energy();
  for (int i = 0; X.p.x() > from - 0.09; ++i) {
    X.p += 1e-3 * v;
    house.send(CommandKind::kObjectPose, poseMessage(kPress, X, {v, Vec3::Zero()}));
    house.run(1);
    least = std::min(least, energy());
    // Four times its speed, beside what lifting it by its own size takes.
    ASSERT_LT(energy(), least + 8 * v.squaredNorm() + kGravity * 0.06)
        << "press at " << X.p.x() << ", " << speed << " m/s";
    most_squeezed = std::max(most_squeezed, rigid.twist().v.norm() / speed);
  }
}

TEST(SqueezedBodyProperty, ASlowPressThrowsNothing) {
  double most = 0;
  forSeeds(12, [&](unsigned seed) { aSlowPressThrowsNothing(seed, most); });
  EXPECT_GT(most, 1.5) << "they were squeezed out";
}

}  // namespace
}  // namespace hapticd
