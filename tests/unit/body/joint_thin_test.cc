// Touches of a face that its corners imply are left out of a step; what they do not imply stays.
#include <gtest/gtest.h>

#include <memory>

#include "rt/body/joint_step.h"

namespace hapticd {
namespace {

/** A box of 0.1 kg that lies on what does not move: a step of it, with a touch changed by `change`. */
class JointThin : public ::testing::Test {
 public:
  template <class Change>
  void step(Change&& change) {
    body = FreeBody(MassProperties::ofBox(0.1, 2 * half), 0, true);
    body.body.place({{0, 0, half.z()}, Quat::Identity()});
    joint->begin(1e-3, {0, 0, -9.81});
    const std::uint8_t mover = joint->add(body);
    for (int i = 0; i < kAlong * kAlong; ++i) {
      Touch touch;
      const int row = i / kAlong, column = i % kAlong;
      const Vec3 at(2.0 * column / (kAlong - 1) - 1, 2.0 * row / (kAlong - 1) - 1, -1);
      touch.r_a = half.cwiseProduct(at);
      touch.friction = 0.4;
      touch.key = static_cast<std::uint64_t>(i) + 1;
      change(i, touch);
      ASSERT_TRUE(joint->add(touch, mover, JointStep::kFixed));
    }
    joint->solve();
  }
  [[nodiscard]] std::uint32_t kept() const { return JointStep::kMaxJointTouches - joint->room(); }

  static constexpr int kAlong = 5;  ///< Touches along each side of its bottom.
  static constexpr int kMiddle = kAlong * kAlong / 2;
  inline static const Vec3 half{0.02, 0.03, 0.01};
  FreeBody body{MassProperties{}, 0, true};
  std::unique_ptr<JointStep> joint = std::make_unique<JointStep>();
};

TEST_F(JointThin, TheCornersOfAFaceHoldIt) {
  step([](int, Touch&) {});
  EXPECT_EQ(kept(), 4U);
  EXPECT_LT(body.body.twist().v.norm(), 1e-6);
  EXPECT_LT(body.body.twist().w.norm(), 1e-5);
}

TEST_F(JointThin, WhatIsDeeperThanTheCornersImplyStays) {
  step([](int i, Touch& touch) { touch.gap = i == kMiddle ? -50e-6 : 0; });
  EXPECT_EQ(kept(), 5U);
  EXPECT_LE(body.body.twist().v.z(), Tool::kRecoverSpeed);
  EXPECT_GE(body.body.twist().v.z(), 0);
  // With all apart but that one only it says where the box ends.
  step([](int i, Touch& touch) { touch.gap = i == kMiddle ? 2e-6 : 60e-6; });
  EXPECT_EQ(kept(), 5U);
  EXPECT_NEAR(body.body.twist().v.z(), -2e-3, 1e-6);
}

/** A tilted face: its gaps differ, and are those of a plane. */
TEST_F(JointThin, GapsOfATiltedFaceAreThoseOfItsCorners) {
  step([](int, Touch& touch) { touch.gap = 1e-3 * (touch.r_a.x() + half.x()); });
  EXPECT_EQ(kept(), 4U);
  EXPECT_GT(velocityAt(body.body.twist(), {-half.x(), 0, -half.z()}).z(), -1e-5) << "the edge that lies on it";
}

/** An edge in the ground need only open, so that it says less of the middle than how deep it is. */
TEST_F(JointThin, AnEdgeInTheGroundDoesNotHoldTheMiddle) {
  step([](int, Touch& touch) { touch.gap = 1e-3 * touch.r_a.x() / half.x(); });
  EXPECT_GT(kept(), 4U);
  EXPECT_GT(velocityAt(body.body.twist(), {0, 0, -half.z()}).z(), -1e-5);
}

TEST_F(JointThin, TouchesOfOtherThingsOtherFacesAndOtherMaterialsStay) {
  const auto middle = [](int i) { return i == kMiddle; };
  step([&](int i, Touch& touch) { touch.friction = middle(i) ? 0.5 : 0.4; });
  EXPECT_EQ(kept(), 5U) << "friction";
  step([&](int i, Touch& touch) { touch.key |= middle(i) ? 7ULL << 24 : 0; });
  EXPECT_EQ(kept(), 5U) << "another obstacle";
  step([&](int i, Touch& touch) { touch.n = middle(i) ? Vec3(0.01, 0, 1).normalized() : Vec3::UnitZ(); });
  EXPECT_EQ(kept(), 5U) << "another face";
  step([&](int i, Touch& touch) { touch.give = middle(i) ? 1e-3 : 0; });
  EXPECT_EQ(kept(), 5U) << "a spring, which bears its part";
  step([&](int i, Touch& touch) { touch.moving.z() = middle(i) ? 0.01 : 0; });
  EXPECT_EQ(kept(), 5U) << "it comes up there";
  EXPECT_NEAR(body.body.twist().v.z(), 0.01, 1e-3);
}

}  // namespace
}  // namespace hapticd
