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

/** A floor and a wall, both free: each is driven along its own normal, by its part of what presses the hand. */
TEST(CycleTouchOfBodies, BetweenTwoEachGetsItsOwnPart) {
  test::SteppedCycle hand(test::openConfig(10));
  constexpr double kMass[] = {5, 8};
  for (const std::uint32_t id : {kOne, kOther}) {  // Below z = 0, and before x = 0.
    const Vec3 place = id == kOne ? Vec3(0, 0, -0.05) : Vec3(0.05, 0, 0);
    hand.add(test::solid(id, ShapeKind::kBox, {800, 0, 0, 0}, {place, Quat::Identity()}, Vec3::Constant(0.05)));
    const double inertia = 0.01;
    hand.put(CommandKind::kSetBody,
             SetBody{id, 0, kMass[objectSlot(id) - 1], {}, {inertia, inertia, inertia, 0, 0, 0}, 0});
  }
  hand.at({-0.003, 0, 0.003});
  hand.arm();
  Vec3 felt = Vec3::Zero();
  bool both = false;
  const auto go = [&](const Vec3& p) {
    for (const std::uint32_t id : {kOne, kOther}) {  // They touch nothing else, which they are to be told.
      ToolContacts none{};
      none.device = kMaxDevices + objectSlot(id) - 1;
      none.object = id;
      hand.put(CommandKind::kToolContacts, none);
    }
    felt += 1e-3 * hand.at(p).guard.by_source[HD_SOURCE_SURFACE];
    both = both || hand.output->device[0].contact.parts == 2;
  };
  for (int i = 0; i < 60; ++i) go(Vec3(-0.003, 0, 0.003) + 1e-4 * i * Vec3(1, 0, -1));
  go({-0.003, 0, 0.003});
  ASSERT_TRUE(both);
  ASSERT_LT(felt.x(), -0.01);
  ASSERT_GT(felt.z(), 0.01);
  const auto speed = [&](std::uint32_t id) { return hand.cycle->scene().slot(objectSlot(id)).V_WO.v; };
  EXPECT_LT((speed(kOne) - Vec3(0, 0, -felt.z() / kMass[0])).norm(), 1e-2 * felt.z() / kMass[0]);
  EXPECT_LT((speed(kOther) - Vec3(-felt.x() / kMass[1], 0, 0)).norm(), -1e-2 * felt.x() / kMass[1]);
}

}  // namespace
}  // namespace hapticd
