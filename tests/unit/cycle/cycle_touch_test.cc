// Of each object that a hand touches beginning and end are told in turns.
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

}  // namespace
}  // namespace hapticd
