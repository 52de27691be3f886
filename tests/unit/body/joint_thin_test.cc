// Touches of a face that its corners imply are left out of a step; what they do not imply stays.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "rt/body/joint_step.h"
#include "tests/support/for_seeds.h"

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

/** A box that lies on two, each on half of it; of each pair some touches tell who lies on whom the other way round. */
TEST_F(JointThin, FacesOfTwoBodiesAreTheSameFromEitherSide) {
  std::vector<FreeBody> boxes;
  for (const double x : {0.0, -0.02, 0.02}) {
    FreeBody box(MassProperties::ofBox(0.1, {0.04, 0.06, 0.02}), 0, true);
    box.body.place({{x, 0, x == 0 ? 0.03 : 0.01}, Quat::Identity()});
    boxes.push_back(box);
  }
  joint->begin(1e-3, Vec3::Zero());
  for (FreeBody& box : boxes) (void)joint->add(box);
  for (const std::uint8_t below : {1, 2}) {
    for (int i = 0; i < 9; ++i) {
      const Vec3 at((below == 1 ? -0.02 : 0) + 0.01 * (i % 3), 0.03 * (i / 3 - 1), 0.02);
      Touch touch;
      touch.key = static_cast<std::uint64_t>(9 * below + i);
      touch.r_a = at - boxes[0].body.com();
      touch.r_b = at - boxes[below].body.com();
      if (i % 2 == 0) {
        ASSERT_TRUE(joint->add(touch, 0, below));
      } else {
        std::swap(touch.r_a, touch.r_b);
        touch.n = -touch.n;
        ASSERT_TRUE(joint->add(touch, below, 0));
      }
    }
  }
  joint->solve();
  EXPECT_EQ(kept(), 8U) << "the four corners of each";
}

/** Brute force: whatever was left out, no touch closes by more than it may, on faces of any shape that come at any
 * slant. */
TEST_F(JointThin, NoTouchIsForgotten) {
  int left_out = 0;
  forSeeds(300, [&](unsigned seed) {
    Random random(seed);
    const Mat3 turn = random.turn().toRotationMatrix();
    body = FreeBody(MassProperties::ofBox(0.1, 2 * half), 0, true);
    body.body.place({random.vector(0.05), Quat(turn)});
    body.body.setTwist({turn * Vec3(random.in(-0.1, 0.1), random.in(-0.1, 0.1), random.in(-0.4, 0)), random.vector(3)});
    joint->begin(1e-3, turn * Vec3(0, 0, -9.81));
    const std::uint8_t mover = joint->add(body);
    std::vector<Touch> touches;
    const double x = random.in(-4e-3, 4e-3), y = random.in(-4e-3, 4e-3);  // The slant.
    const bool grid = random.once(2);                                     // Many along one line, and some twice.
    for (int i = 0, n = 3 + static_cast<int>(random.below(12)); i < n; ++i) {
      Vec3 at(random.in(-1, 1), random.in(-1, 1), -1);
      if (grid) at = {std::round(2 * at.x()) / 2, std::round(2 * at.y()) / 2, -1};
      at = half.cwiseProduct(at);
      Touch touch;
      touch.r_a = turn * at;
      touch.n = turn.col(2);
      touch.gap = std::max(0.0, 1e-4 + x * at.x() + y * at.y() - (random.once(6) ? random.in(0, 1e-4) : 0));
      touch.key = static_cast<std::uint64_t>(i) + 1;
      touches.push_back(touch);
      ASSERT_TRUE(joint->add(touch, mover, JointStep::kFixed));
    }
    joint->solve();
    left_out += static_cast<int>(touches.size() - kept());
    for (const Touch& touch : touches) {
      const double closes = -1e-3 * velocityAt(body.body.twist(), touch.r_a).dot(touch.n);
      ASSERT_LE(closes, touch.gap + 1.001e-6 + 1e-3 * joint->residual())
          << "of " << touches.size() << " touches " << kept() << " were kept";
    }
  });
  if (drawsAll()) {
    EXPECT_GT(left_out, 300) << "else the test shows nothing";
  }
}

/** A client moves one of two parts of the lower box along the face: it rubs otherwise than the rest, from either side.
 */
TEST_F(JointThin, PartsOfABodyThatAreMovedOtherwiseStay) {
  for (const bool turned : {false, true}) {
    for (const double speed : {0.0, 0.1}) {
      std::vector<FreeBody> boxes;
      for (const double z : {0.03, 0.01}) {
        FreeBody box(MassProperties::ofBox(0.1, {0.04, 0.06, 0.02}), 0, true);
        box.body.place({{0, 0, z}, Quat::Identity()});
        boxes.push_back(box);
      }
      joint->begin(1e-3, Vec3::Zero());
      for (FreeBody& box : boxes) (void)joint->add(box);
      for (int i = 0; i < 9; ++i) {
        const bool middle = i == 4;
        const Vec3 at(0.02 * (i % 3 - 1), 0.03 * (i / 3 - 1), 0.02);
        Touch touch;
        touch.key = static_cast<std::uint64_t>(i + 1) | (middle ? 1ULL << 24 : 0);
        touch.friction = 0.4;
        touch.r_a = at - boxes[0].body.com();
        touch.r_b = at - boxes[1].body.com();
        if (middle) touch.moving.x() = speed;
        if (middle && turned) {
          std::swap(touch.r_a, touch.r_b);
          touch.n = -touch.n;
          touch.moving = -touch.moving;
          ASSERT_TRUE(joint->add(touch, 1, 0));
        } else {
          ASSERT_TRUE(joint->add(touch, 0, 1));
        }
      }
      joint->solve();
      EXPECT_EQ(kept(), speed > 0 ? 5U : 4U) << turned;
    }
  }
}

TEST_F(JointThin, TouchesOfOtherThingsOtherFacesAndOtherMaterialsStay) {
  const auto middle = [](int i) { return i == kMiddle; };
  step([&](int i, Touch& touch) { touch.friction = middle(i) ? 0.5 : 0.4; });
  EXPECT_EQ(kept(), 5U) << "friction";
  step([&](int i, Touch& touch) { touch.key |= middle(i) ? 1ULL << 24 : 0; });
  EXPECT_EQ(kept(), 5U) << "another obstacle";
  step([&](int i, Touch& touch) { touch.key |= middle(i) ? 1ULL << 23 : 0; });
  EXPECT_EQ(kept(), 4U) << "another part of the same one";
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
