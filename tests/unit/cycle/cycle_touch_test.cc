// Of each object that a hand touches beginning and end are told in turns; and what is felt of each it feels of the
// hand.
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

const std::uint32_t kOne = makeObjectId(1, 1), kOther = makeObjectId(2, 1);

/** A touch of that object, or its end. */
struct Told {
  bool begins;
  std::uint32_t object;
  double force;

  bool operator==(const Told& other) const { return begins == other.begins && object == other.object; }
};

Told begin(std::uint32_t object) { return {true, object, 0}; }
Told end(std::uint32_t object) { return {false, object, 0}; }

/** Two boxes of 20 mm side by side, of which the other one is so much higher [m]. */
class CycleTouch : public ::testing::Test, protected test::SteppedCycle {
 protected:
  void build(double higher) {
    for (const std::uint32_t id : {kOne, kOther}) {
      const Vec3 place(id == kOne ? -0.01 : 0.01, 0, id == kOne ? 0 : higher);
      add(test::solid(id, ShapeKind::kBox, {1000, 0, 0, 0}, {place, Quat::Identity()}, Vec3::Constant(0.01)));
    }
  }
  std::uint32_t at(const Vec3& x) {
    SteppedCycle::at(x);
    for (std::uint32_t i = 0; i < output->events.count; ++i) {
      const ServoEvent& event = output->events.event[i];
      if (event.kind == ServoEventKind::kTouch) told_.push_back({true, event.object, event.force});
      if (event.kind == ServoEventKind::kUntouch) told_.push_back({false, event.object, event.force});
    }
    return output->device[0].contact.object;
  }

  std::vector<Told> told_;
};

TEST_F(CycleTouch, WhoGoesOnToAnotherObjectTouchesThatOne) {
  build(0);
  at({-0.005, 0, 0.012});
  EXPECT_EQ(at({-0.005, 0, 0.009}), kOne);
  for (int i = 0; i < 100; ++i) at({-0.005 + 1e-4 * i, 0, 0.009});
  EXPECT_EQ(at({0.005, 0, 0.009}), kOther);
  EXPECT_EQ(at({0.005, 0, 0.012}), 0u);
  EXPECT_EQ(at({0.005, 0, 0.009}), kOther);
  EXPECT_EQ(told_, (std::vector{begin(kOne), end(kOne), begin(kOther), end(kOther), begin(kOther)}));
}

/** A hand on the low one comes to the side of the high one, leaves the low one upward, and the other sideways. */
TEST_F(CycleTouch, OfTwoAtOnceEachIsTold) {
  build(0.01);
  at({-0.005, 0, 0.012});
  at({-0.005, 0, 0.009});
  for (int i = 1; i <= 70; ++i) at({-0.00503 + 1e-4 * i, 0, 0.009});
  EXPECT_EQ(told_, (std::vector{begin(kOne), begin(kOther)}));
  EXPECT_NEAR(told_[1].force, 0.1, 0.1) << "its own, not that of both";
  for (int i = 1; i <= 30; ++i) at({0.00197, 0, 0.009 + 1e-4 * i});
  EXPECT_EQ(told_.back(), end(kOne));
  for (int i = 1; i <= 30; ++i) at({0.00197 - 1e-4 * i, 0, 0.012});
  EXPECT_EQ(told_, (std::vector{begin(kOne), begin(kOther), end(kOne), end(kOther)}));
}

/** A floor and a wall of 5 and 8 kg, both free, and a hand that comes into their corner. */
class CycleTouchOfBodies : public ::testing::Test, protected test::SteppedCycle {
 protected:
  static constexpr double kMass[] = {5, 8};

  CycleTouchOfBodies() : SteppedCycle(test::openConfig(10)) {}
  /** Of so much of their mass, and the floor's so far aside. */
  void build(const hd_material& material, double share = 1, double aside = 0) {
    for (const std::uint32_t id : {kOne, kOther}) {  // Below z = 0, and before x = 0.
      const Vec3 place = id == kOne ? Vec3(0, 0, -0.05) : Vec3(0.05, 0, 0);
      add(test::solid(id, ShapeKind::kBox, material, {place, Quat::Identity()}, Vec3::Constant(0.05)));
      const double inertia = share * 0.01, mass = share * kMass[objectSlot(id) - 1];
      const double com = id == kOne ? aside : 0;
      put(CommandKind::kSetBody, SetBody{id, 0, mass, {com}, {inertia, inertia, inertia, 0, 0, 0}, 0});
    }
    at({-0.003, 0, 0.003});
    arm();
  }
  void go(const Vec3& p) {
    for (const std::uint32_t id : {kOne, kOther}) {  // They touch nothing else, which they are to be told.
      ToolContacts none{};
      none.device = kMaxDevices + objectSlot(id) - 1;
      none.object = id;
      answer(none);
    }
    felt_ += 1e-3 * at(p).guard.by_source[HD_SOURCE_SURFACE];
    both_ = both_ || output->device[0].contact.parts == 2;
  }
  Vec3 speed(std::uint32_t id) const { return cycle->scene().slot(objectSlot(id)).V_WO.v; }

  Vec3 felt_ = Vec3::Zero();  ///< By the hand, in all [N s].
  bool both_ = false;
};

/** Each is driven along its own normal, by its part of what presses the hand. */
TEST_F(CycleTouchOfBodies, BetweenTwoEachGetsItsOwnPart) {
  build({800, 0, 0, 0});
  for (int i = 0; i < 60; ++i) go(Vec3(-0.003, 0, 0.003) + 1e-4 * i * Vec3(1, 0, -1));
  go({-0.003, 0, 0.003});
  ASSERT_TRUE(both_);
  ASSERT_LT(felt_.x(), -0.01);
  ASSERT_GT(felt_.z(), 0.01);
  EXPECT_LT((speed(kOne) - Vec3(0, 0, -felt_.z() / kMass[0])).norm(), 1e-2 * felt_.z() / kMass[0]);
  EXPECT_LT((speed(kOther) - Vec3(-felt_.x() / kMass[1], 0, 0)).norm(), -1e-2 * felt_.x() / kMass[1]);
}

/** Of friction and damping too, the one along the corner, both take together what the hand is given. */
TEST_F(CycleTouchOfBodies, BetweenTwoNoMomentumIsLost) {
  build({800, 2, 0.5, 0.4});
  for (int i = 0; i < 40; ++i) go(Vec3(-0.003, 0, 0.003) + 1e-4 * i * Vec3(1, 0, -1));
  for (int i = 0; i < 20; ++i) go({0.001, 1e-4 * i, -0.001});
  go({-0.003, 0.002, 0.003});
  ASSERT_TRUE(both_);
  ASSERT_LT(felt_.y(), -1e-3);
  const Vec3 given = kMass[0] * speed(kOne) + kMass[1] * speed(kOther);
  EXPECT_LT((given + felt_).norm(), 1e-9 * felt_.norm()) << given.transpose() << " of " << felt_.transpose();
}

/** What is so light that an impulse of theirs would throw it gets no more than the springs hold, however it moves. */
TEST_F(CycleTouchOfBodies, BetweenTwoLightOnesGetWhatTheSpringsHold) {
  constexpr double kLight = 1e-5;
  build({800, 0, 0, 0}, kLight);
  for (const double rises : {0.0, 0.3, -0.3}) {
    at({-0.003, 0, 0.01});
    for (const std::uint32_t id : {kOne, kOther}) {
      const Pose place{id == kOne ? Vec3(0, 0, -0.05) : Vec3(0.05, 0, 0), Quat::Identity()};
      put(CommandKind::kObjectPose, poseMessage(id, place, {{0, 0, id == kOne ? rises : 0}, Vec3::Zero()}));
    }
    both_ = false;
    go({0.001, 0.01, -0.001});
    ASSERT_TRUE(both_) << rises;
    double given = -0.5 * kLight * kMass[0] * rises * rises;
    const FreeBodies& bodies = cycle->bodies();
    const RigidBody& one = bodies.body(bodies.find(objectSlot(kOne))).body;
    const RigidBody& other = bodies.body(bodies.find(objectSlot(kOther))).body;
    given += one.kineticEnergy() + other.kineticEnergy();
    const double stored = output->device[0].contact.stored;
    ASSERT_GT(stored, 1e-5);
    EXPECT_NEAR(given, stored, 1e-9 * stored) << rises;
    EXPECT_LT(one.twist().v.z(), rises) << "away from the hand";
    EXPECT_GT(other.twist().v.x(), 0) << rises;
  }
}

/** Of a soft finger between two: the twist is of that which it touched first, and the other gets its push alone. */
TEST_F(CycleTouchOfBodies, BetweenTwoTheTwistOfAFingerTurnsThatWhichItTouchedFirst) {
  build({800, 0, 0.5, 0.4});
  SetFinger finger{};
  finger.law = static_cast<std::uint32_t>(PadLaw::kLinear);
  finger.radius = finger.arm = 5e-3;
  finger.stiffness = 0.1;
  finger.shows_moment = 1;
  put(CommandKind::kSetFinger, finger);
  double turned = 0;
  for (int i = 0; i < 60; ++i) {
    const FreeBodies& bodies = cycle->bodies();
    std::array<Twist, 2> before;
    std::array<Vec3, 2> com;
    const std::array<std::uint32_t, 2> id{kOne, kOther};
    for (std::size_t k = 0; k < 2; ++k) {
      const RigidBody& body = bodies.body(bodies.find(objectSlot(id[k]))).body;
      before[k] = body.twist();
      com[k] = body.com();
    }
    input->device[0].q = Quat(Eigen::AngleAxisd(1e-3 * i, Vec3::UnitZ()));
    go(Vec3(-0.003, 0, 0.003) + 8e-5 * i * Vec3(1, 0, -1) + Vec3(0, 0, i < 30 ? -0.001 : 0));
    const SurfaceContact& contact = output->device[0].contact;
    if (contact.parts != 2) continue;
    for (std::size_t k = 0; k < 2; ++k) {
      const RigidBody& body = bodies.body(bodies.find(objectSlot(id[k]))).body;
      const ContactPart& part = contact.part[contact.part[0].object == id[k] ? 0 : 1];
      const Vec3 pushed = kMass[k] * (body.twist().v - before[k].v);
      const Vec3 twisted = 0.01 * (body.twist().w - before[k].w) - (part.point - com[k]).cross(pushed);
      const Vec3 moment = output->device[0].command.torque;
      const Vec3 wanted = id[k] == contact.object ? Vec3(-1e-3 * moment) : Vec3(Vec3::Zero());
      EXPECT_LT((twisted - wanted).norm(), 1e-9) << i << " of " << id[k];
      turned = std::max(turned, wanted.norm());
    }
  }
  EXPECT_GT(turned, 1e-6);
}

/** What sticks to one is as viscous across as the material is, but stops it within a tick at the most where it is
 * touched, which turns it too; and it carries a hand that is not where it is touched by its turning. */
TEST_F(CycleTouchOfBodies, WhatSticksToALightOneStopsItAndNoMore) {
  constexpr double kLight = 1e-3;
  build({800, 5, 5, 5}, kLight, -0.01);
  int seen = 0;
  double carried = 0;
  for (int i = 0; i < 30; ++i) {
    go({-0.03, 2e-5 * i, -5e-5 * i});
    const DeviceOutput& out = output->device[0];
    const SurfaceContact& c = out.contact;
    if (c.object != kOne || c.parts != 0 || c.slip) continue;
    const FreeBodies& bodies = cycle->bodies();
    const Vec3 r = c.point - bodies.body(bodies.find(objectSlot(kOne))).body.com();
    Vec3 across = c.at_hip - out.velocity.v;
    across -= across.dot(c.normal) * c.normal;
    const double w = 1 / (kLight * kMass[0]) + r.cross(across.normalized()).squaredNorm() / (kLight * 0.01);
    const double b = 1 / (1e-3 * w);
    ASSERT_LT(b, c.damping_gain) << "else that of material and device";
    const Vec3 viscous = c.force - c.stiffness * c.pull - c.damping * c.normal;
    EXPECT_LT((viscous - b * across).norm(), 1e-2 * b * across.norm()) << i;
    seen += across.norm() > 5e-3;
    const Vec3 by_turning = c.at_hip - c.velocity;
    EXPECT_LT((c.apart - c.force.cwiseProduct(by_turning)).norm(), 1e-12) << i;
    carried = std::max(carried, viscous.cwiseProduct(by_turning).norm());
  }
  EXPECT_GE(seen, 3);
  EXPECT_GT(carried, 1e-7);
}

/** Springs and friction alone: on a body that stands, since nobody tells what it touches. */
TEST_F(CycleTouchOfBodies, WhatNothingMovesIsNotViscousAcross) {
  build({800, 5, 5, 5}, 1e-3);
  const int told = static_cast<int>(1.5 * FreeBodies::kStale / 1e-3);
  for (int i = 0; i < told; ++i) at({-0.03, 0, 0.003});
  double seen = 0;
  for (int i = 0; i < 30; ++i) {
    const SurfaceContact& c = at({-0.03, 2e-5 * i, -5e-5 * i}).contact;
    if (c.object != kOne || c.slip) continue;
    EXPECT_LT((c.force - c.stiffness * c.pull - c.damping * c.normal).norm(), 1e-12) << i;
    seen = std::max(seen, c.force.y());
  }
  EXPECT_LT(speed(kOne).norm(), 1e-12);
  EXPECT_LT(seen, 0.5);
}

}  // namespace
}  // namespace hapticd
