// What one that closes on another gives to what is between them, and what is left of it for later: by closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "rt/body/joint_step.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"

namespace hapticd {
namespace {

constexpr double kSqueezeDt = 1e-3, kSqueezedMass = 0.2, kSqueezedRadius = 0.02;

FreeBody ballAtRest() {
  FreeBody body(MassProperties::ofBall(kSqueezedMass, kSqueezedRadius), 0, false);
  body.body.place({Vec3(0.1, 0.2, 0.3), Quat::Identity()});
  return body;
}

/** Of the ball with what has that normal, and moves so fast along it [m/s]. */
Touch touchOf(const Vec3& n, double speed, std::uint64_t key) {
  Touch touch;
  touch.n = n;
  touch.r_a = -kSqueezedRadius * n;
  touch.moving = speed * n;
  touch.key = key;
  return touch;
}

/** Squeezes the ball out of a wedge of that angle, whose one side closes at that speed, in one tick. */
FreeBody squeezedOut(double angle, double speed, const Vec3& gravity = Vec3::Zero(), bool press_first = false) {
  FreeBody ball = ballAtRest();
  auto joint = std::make_unique<JointStep>();
  joint->begin(kSqueezeDt, gravity);
  const std::uint8_t k = joint->add(ball);
  const Touch wall = touchOf(Vec3::UnitZ(), 0, 1), press = touchOf({std::sin(angle), 0, -std::cos(angle)}, speed, 2);
  EXPECT_TRUE(joint->add(press_first ? press : wall, k, JointStep::kFixed));
  EXPECT_TRUE(joint->add(press_first ? wall : press, k, JointStep::kFixed));
  joint->solve();
  return ball;
}

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/** It slides along the side that stands, as fast as the other one tells: and what that gave, twice of what the ball
 * has, is left in its reserve, as much as that may hold. */
TEST(JointBooks, WhatIsSqueezedOutGoesAlongTheOtherSide) {
  for (const double degrees : {90.0, 60.0, 40.0, 30.0}) {
    for (const double speed : {0.01, 0.1, 1.0}) {
      const FreeBody ball = squeezedOut(radians(degrees), speed);
      const double along = speed / std::sin(radians(degrees)), energy = 0.5 * kSqueezedMass * along * along;
      EXPECT_LT((ball.body.twist().v - Vec3(along, 0, 0)).norm(), 1e-4 * along) << degrees << ", " << speed;
      EXPECT_NEAR(ball.reserve, std::min(energy, Tool::kMostReserve), 1e-3 * energy) << degrees << ", " << speed;
    }
  }
}

/** Of a narrow wedge it would go at any speed: it goes at four times that of what closes, and of weight, that goes for
 * one tick's fall at that speed too. */
TEST(JointBooks, OutOfANarrowWedgeItGoesAtMostFourTimesAsFast) {
  for (const double speed : {0.01, 0.1, 1.0}) {
    for (const double fall : {0.0, 100 * speed}) {
      const FreeBody ball = squeezedOut(radians(9), speed, {0, 0, -fall}, fall > 0);
      const double most = 4 * speed,
                   energy = 0.5 * kSqueezedMass * most * most + kSqueezedMass * fall * most * kSqueezeDt;
      EXPECT_NEAR(ball.body.kineticEnergy(), energy, 5e-3 * energy) << speed << ", " << fall;
      EXPECT_LT(ball.body.kineticEnergy(), energy) << speed << ", " << fall;
    }
  }
}

/** Two of them in each other by so much, and what either has lost before [m, J]. */
struct Overlap {
  Overlap(double deep, double reserve, const Vec3& v) : a(ballAtRest()), b(ballAtRest()) {
    a.body.place({b.body.com() + (2 * kSqueezedRadius - deep) * Vec3::UnitX(), Quat::Identity()});
    for (FreeBody* ball : {&a, &b}) {
      ball->body.setTwist({v, Vec3::Zero()});
      ball->reserve = reserve;
    }
    auto joint = std::make_unique<JointStep>();
    joint->begin(kSqueezeDt, Vec3::Zero());
    const std::uint8_t one = joint->add(a), other = joint->add(b);
    Touch touch = touchOf(Vec3::UnitX(), 0, 1);
    touch.r_b = kSqueezedRadius * touch.n;
    touch.gap = -deep;
    EXPECT_TRUE(joint->add(touch, one, other));
    joint->solve();
  }
  FreeBody a, b;
};

/** All of it, if it asks for more; and no more than is asked for. */
TEST(JointBooks, AnOverlapIsLeftAsFastAsWhatWasLostPaysFor) {
  for (const double deep : {2e-4, 1e-3}) {
    const double asked = (deep - Tool::kSlop) / Tool::kRecoverTime, energy = kSqueezedMass * asked * asked / 4;
    for (const double share : {0.0, 0.02, 0.3, 0.9, 1.5}) {
      for (const double along : {0.0, 1.0}) {
        const Overlap left(deep, share * energy / 2, {0, along, 0});
        const Vec3 v = left.a.body.twist().v, apart = v - left.b.body.twist().v;
        const double speed = asked * std::sqrt(std::min(1.0, share));
        EXPECT_NEAR(apart.x(), speed, 5e-3 * speed + 1e-9) << deep << ", " << share;
        EXPECT_LE(apart.x(), speed + 1e-9) << deep << ", " << share;
        EXPECT_NEAR(v.y(), along, 1e-9) << "it goes on as before";
        EXPECT_NEAR(left.a.reserve + left.b.reserve + kSqueezedMass * apart.x() * apart.x() / 4, share * energy,
                    1e-6 * energy);
      }
    }
  }
}

/** As long as both are asked to go apart, be it half-heartedly. */
TEST(JointBooks, WhatLeavesAnOverlapIsNotTurnedFromNowhere) {
  double turned = 0;
  forSeeds(200, [&](unsigned seed) {
    Random random(seed);
    std::array<FreeBody, 2> box{FreeBody(MassProperties::ofBox(0.3, {0.02, 0.05, 0.03}), 0, false),
                                FreeBody(MassProperties::ofBox(0.1, {0.02, 0.05, 0.03}), 0, false)};
    for (FreeBody& body : box) {
      body.body.place(random.pose(0.02));
      body.reserve = std::pow(10, random.in(-8, -6));
    }
    auto joint = std::make_unique<JointStep>();
    joint->begin(kSqueezeDt, Vec3::Zero());
    for (FreeBody& body : box) (void)joint->add(body);
    Touch touch;
    const Vec3 at = random.vector(0.03);
    touch.n = random.vector(1).normalized();
    touch.r_a = at - box[0].body.com();
    touch.r_b = at - box[1].body.com();
    touch.gap = -1e-3;
    ASSERT_TRUE(joint->add(touch, 0, 1));
    const Vec3 before = box[0].body.com(), other = box[1].body.com();
    joint->solve();
    const Vec3 p = box[0].body.mass() * box[0].body.twist().v;
    const Vec3 l = box[0].body.angularMomentum() + box[1].body.angularMomentum() + (before - other).cross(p);
    EXPECT_LE((p + box[1].body.mass() * box[1].body.twist().v).norm(), 1e-9 * p.norm() + 1e-15);
    EXPECT_LT(l.norm(), 1e-4 * box[0].body.angularMomentum().norm() + 1e-12);
    turned = std::max(turned, box[0].body.twist().w.norm());
  });
  EXPECT_GT(turned, 0.1);
}

/** A soft floor holds more than a reserve may: what it got of a ball that it gives back. */
TEST(JointBooks, ASoftFloorGivesBackWhatItGot) {
  constexpr double kFalls = 0.3, kSoft = 1e-3;  // m/s, m/N
  FreeBody ball = ballAtRest();
  ball.body.setTwist({Vec3(0, 0, -kFalls), Vec3::Zero()});
  const double floor = ball.body.com().z(), energy = ball.body.kineticEnergy();
  ASSERT_GT(energy, 4 * Tool::kMostReserve);
  auto joint = std::make_unique<JointStep>();
  double deepest = 0;
  for (int i = 0; i < 100; ++i) {
    joint->begin(kSqueezeDt, Vec3::Zero());
    const std::uint8_t k = joint->add(ball);
    Touch touch = touchOf(Vec3::UnitZ(), 0, 1);
    touch.gap = ball.body.com().z() - floor;
    touch.give = kSoft;
    ASSERT_TRUE(joint->add(touch, k, JointStep::kFixed));
    joint->solve();
    const double depth = std::max(0.0, floor - ball.body.com().z());
    ASSERT_LE(ball.body.kineticEnergy() + 0.5 * depth * depth / kSoft, energy * (1 + 1e-9)) << i;
    deepest = std::max(deepest, depth);
  }
  const double most = kFalls * std::sqrt(kSqueezedMass * kSoft);
  EXPECT_GT(deepest, 0.8 * most);
  EXPECT_GT(ball.body.com().z(), floor);
  EXPECT_GT(ball.body.twist().v.z(), 0.7 * kFalls);
}

/** It takes out of the press what its tool gets: the tool goes as fast as what pushes it. */
TEST(JointBooks, AToolInAHandIsPushedAsFastAsAPressGoes) {
  for (const double speed : {0.01, 0.1, 1.0}) {
    ToolSetup setup;
    setup.mass = MassProperties::ofBall(0.05, kSqueezedRadius);
    setup.gains = {1000, 1000, 1, 1, 1, 0.01};
    Tool tool(setup);
    tool.reset(Pose{});
    auto joint = std::make_unique<JointStep>();
    ToolStep out;
    joint->begin(kSqueezeDt, Vec3::Zero());
    const std::uint8_t t = joint->add(tool, Pose{}, out);
    ASSERT_TRUE(joint->add(touchOf(Vec3::UnitZ(), speed, 1), t, JointStep::kFixed));
    joint->solve();
    EXPECT_EQ(out.clamped, 1);
    EXPECT_NEAR(tool.body().twist().v.z(), speed, 1e-6 * speed);
    EXPECT_NEAR(out.obstacle_work.z(), kSqueezeDt * out.contact.force.z() * speed, 1e-9 * out.obstacle_work.z());
    EXPECT_NEAR(out.lost, out.obstacle_work.z() - tool.energy(), 1e-9 * out.obstacle_work.z());
  }
}

/** What a tool is told of its own touch, that a body far away waits to leave an overlap or not. */
TEST(JointBooks, WhereAnotherIslandWaitsAToolIsToldTheSame) {
  std::array<Vec3, 2> told;
  for (const bool other : {false, true}) {
    ToolSetup setup;
    setup.mass = MassProperties::ofBall(0.05, kSqueezedRadius);
    setup.gains = {1000, 1000, 1, 1, 1, 0.01};
    Tool tool(setup);
    Pose hand;
    tool.reset(hand);
    FreeBody a = ballAtRest(), b = ballAtRest();
    auto joint = std::make_unique<JointStep>();
    ToolStep out;
    joint->begin(kSqueezeDt, Vec3::Zero());
    hand.p.z() -= 1e-3;
    const std::uint8_t t = joint->add(tool, hand, out);
    Touch below = touchOf(Vec3::UnitZ(), 0.02, 1);
    below.gap = -3e-4;
    ASSERT_TRUE(joint->add(below, t, JointStep::kFixed));
    if (other) {
      const std::uint8_t one = joint->add(a), second = joint->add(b);
      Touch touch = touchOf(Vec3::UnitX(), 0, 2);
      touch.gap = -1e-3;
      ASSERT_TRUE(joint->add(touch, one, second));
    }
    joint->solve();
    EXPECT_GT(out.contact.force.z(), 0.1);
    EXPECT_EQ(out.clamped, 1);
    told[other ? 1 : 0] = out.contact.force;
  }
  EXPECT_LT((told[1] - told[0]).norm(), 1e-9 * told[0].norm()) << told[0].z() << ", " << told[1].z();
}

/** Faster than anything may go it is not told to go either; and that slows down nobody else. */
TEST(JointBooks, NothingGoesFasterThanTheBound) {
  FreeBody hit = ballAtRest(), other = ballAtRest();
  other.body.setTwist({Vec3(1, 2, 3), Vec3::Zero()});
  auto joint = std::make_unique<JointStep>();
  joint->begin(kSqueezeDt, Vec3::Zero());
  const std::uint8_t k = joint->add(hit);
  (void)joint->add(other);
  EXPECT_TRUE(joint->add(touchOf(Vec3::UnitX(), 3 * Tool::kMostSpeed, 1), k, JointStep::kFixed));
  joint->solve();
  EXPECT_LT((hit.body.twist().v - Vec3(Tool::kMostSpeed, 0, 0)).norm(), 1e-9);
  EXPECT_LT((other.body.twist().v - Vec3(1, 2, 3)).norm(), 1e-12);
}

/** Bodies that touch each other, and what moves with one velocity, about them. */
struct Island {
  std::vector<FreeBody*> bodies;
  Vec3 moving = Vec3::Zero();
  double energy = 0, reserve = 0, mass = 0;
  Vec3 momentum = Vec3::Zero();

  void sum() {
    energy = reserve = mass = 0;
    momentum.setZero();
    for (const FreeBody* body : bodies) {
      energy += body->body.kineticEnergy();
      reserve += body->reserve;
      mass += body->body.mass();
      momentum += body->body.mass() * body->body.twist().v;
    }
  }
};

/** In overlaps that are left, which is waited with where the books do not allow it, and in jams. What moves gives its
 * velocity times the momentum that it gave, or four times its speed at most; no energy goes but into the reserves. */
TEST(JointBooks, EachIslandHasWhatItHadAndWhatItWasGiven) {
  int settled = 0, squeezed = 0;
  auto joint = std::make_unique<JointStep>();
  forSeeds(4000, [&](unsigned seed) {
    Random random(seed);
    std::vector<FreeBody> bodies;
    bodies.reserve(8);
    std::array<Island, 3> islands;
    for (Island& island : islands) {
      island.moving = random.once(4) ? Vec3::Zero() : random.vector(random.once(3) ? 0.01 : 0.1);
      for (int i = 1 + random.below(2); i > 0; --i) {
        FreeBody& body = bodies.emplace_back(MassProperties::ofBox(random.in(0.05, 1), {0.02, 0.05, 0.03}), 0, false);
        body.body.place({random.vector(0.05), random.turn()});
        if (random.once(2)) body.body.setTwist({random.vector(0.05), random.vector(0.5)});
        body.reserve = random.once(2) ? 0 : random.in(0, 1e-4);
        island.bodies.push_back(&body);
      }
    }
    joint->begin(kSqueezeDt, Vec3::Zero());
    std::uint8_t first = 0;
    for (Island& island : islands) {
      for (FreeBody* body : island.bodies) (void)joint->add(*body);
      const auto touch = [&](std::uint8_t a, std::uint8_t b) {
        Touch out;
        out.n = random.vector(1).normalized();
        out.r_a = random.vector(0.05);
        out.r_b = random.vector(0.05);
        out.gap = random.in(-5e-4, 2e-4);
        out.friction = random.once(2) ? 0 : random.in(0, 1);
        if (b == JointStep::kFixed) out.moving = island.moving;
        ASSERT_TRUE(joint->add(out, a, b));
      };
      if (island.bodies.size() > 1) touch(first + 1, first);
      const int about = random.below(4);
      for (int i = 0; i < about; ++i)
        touch(static_cast<std::uint8_t>(first + i % static_cast<int>(island.bodies.size())), JointStep::kFixed);
      first = static_cast<std::uint8_t>(first + island.bodies.size());
      island.sum();
    }
    joint->solve();
    for (Island& island : islands) {
      const Island before = island;
      island.sum();
      const double by_push = island.moving.dot(island.momentum - before.momentum);
      const double most = std::max(0.0, 8 * island.mass * island.moving.squaredNorm() - before.energy);
      const double given = island.energy > 0 ? std::min(by_push, most) : 0;  // What was stopped was given nothing.
      const double had = before.energy + before.reserve, has = island.energy + island.reserve;
      const double room = Tool::kMostReserve * static_cast<double>(island.bodies.size());
      const double rounding = 1e-6 * (had + std::abs(by_push)) + 1e-13;
      for (const FreeBody* body : island.bodies) ASSERT_GE(body->reserve, 0);
      // Where all velocities were scaled down nobody outside knows what was given.
      if (island.reserve < 0.01 * (std::abs(island.energy - before.energy) + had)) continue;
      ASSERT_LE(has, had + given + rounding) << given;
      if (island.reserve > 0.999 * room) continue;
      ASSERT_NEAR(has, had + given, rounding) << given;
      ++settled;
      squeezed += by_push > most;
    }
  });
  EXPECT_GT(settled, drawn(2000));
  EXPECT_GT(squeezed, drawn(20));
}

/** What no number tells stops those that it touches, and nobody else. */
TEST(JointBooks, WhatIsNoNumberStopsItsOwnIslandOnly) {
  for (const double broken : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    FreeBody hit = ballAtRest(), free = ballAtRest();
    hit.body.setTwist({Vec3(1, 0, 0), Vec3::Zero()});
    free.body.setTwist({Vec3(0, 1, 0), Vec3::Zero()});
    auto joint = std::make_unique<JointStep>();
    joint->begin(kSqueezeDt, Vec3::Zero());
    const std::uint8_t k = joint->add(hit);
    (void)joint->add(free);
    ASSERT_TRUE(joint->add(touchOf(-Vec3::UnitX(), broken, 1), k, JointStep::kFixed));
    joint->solve();
    EXPECT_TRUE(hit.body.twist().v.isZero(0) && hit.body.twist().w.isZero(0)) << broken;
    EXPECT_TRUE(isFinite(hit.body.com())) << broken;
    EXPECT_TRUE(std::isfinite(hit.reserve)) << broken;
    EXPECT_EQ(free.body.twist().v, Vec3(0, 1, 0)) << broken;
  }
}

}  // namespace
}  // namespace hapticd
