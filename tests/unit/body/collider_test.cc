// What the collide thread counts of its own answers.
#include "rt/collide/collider.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

/** Time passes whenever it is asked for. */
class Rushing final : public Clock {
 public:
  std::int64_t now() HD_RT override { return t_ns_ += Collider::kPeriodNs; }
  void sleepUntil(std::int64_t) HD_RT override {}

 private:
  std::int64_t t_ns_ = 0;
};

/** A box in a hand, and one that moves freely, each just above a floor. */
CollideRequest question() {
  CollideRequest request;
  for (const std::size_t i : {std::size_t{0}, std::size_t{kMaxDevices}}) {
    CollideRequest::Held& held = request.held[i];
    held.object = makeObjectId(static_cast<std::uint32_t>(2 + i), 1);
    held.shape.kind = ShapeKind::kBox;
    held.shape.size = Vec3(0.01, 0.01, 0.01);
    held.X_WO.p.z() = 0.0101;
    held.count = 1;
    held.obstacle[0].slot = 1;
    held.obstacle[0].shape.kind = ShapeKind::kPlane;
  }
  return request;
}

TEST(Collider, CountsEachAnswerAndThoseThatFindNoRoom) {
  const auto collider = std::make_unique<Collider>();
  int kept = 0;
  for (int i = 0; i < 100; ++i) {
    collider->questions.put(question());
    collider->step(nullptr);
  }
  for (Command answer; collider->answers.pop(answer);) ++kept;
  EXPECT_EQ(collider->counters.queries.load(), 200u);
  EXPECT_GT(kept, 0);
  EXPECT_EQ(collider->counters.unsent.load(), 200u - static_cast<unsigned>(kept));
  EXPECT_EQ(collider->counters.exhausted.load(), 0u);
  EXPECT_GT(collider->counters.contacts[0].load(), 0u);
}

TEST(Collider, CountsAnswersForWhichThereWasNoTime) {
  const auto collider = std::make_unique<Collider>();
  Rushing clock;
  collider->questions.put(question());
  collider->step(&clock);
  EXPECT_EQ(collider->counters.queries.load(), 2u);
  EXPECT_EQ(collider->counters.exhausted.load(), 2u);
  EXPECT_EQ(collider->counters.unsent.load(), 0u);
}

/** Nor has it been pressed through: a body let go there was pulled through the sheet, back to where it was taken up. */
TEST(Collider, WhatAHandHasCarriedToTheOtherSideOfASheetIsOnThatSide) {
  test::TestMesh sheet = test::heightMesh(0.05, 8, [](double, double) { return 0.0; });
  for (const bool in_a_hand : {false, true}) {
    const auto collider = std::make_unique<Collider>();
    CollideRequest request;
    CollideRequest::Held& body = request.held[kMaxDevices];
    body.shape = Shape{ShapeKind::kSphere, Vec3(0.002, 0, 0)};
    body.count = 1;
    body.obstacle[0].slot = 7;
    body.obstacle[0].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), sheet.view(), 40};
    double up = 0;
    const auto ask = [&](std::uint32_t object, double z) {
      body.object = object;
      body.X_WO.p = {0.001, 0.001, z};
      collider->questions.put(request);
      collider->step(nullptr);
      for (Command answer; collider->answers.pop(answer);) up = answer.as<ToolContacts>().point[0].n_B[2];
    };
    ask(makeObjectId(9, 1), 0.003);
    EXPECT_GT(up, 0.99);
    if (in_a_hand) ask(0, 0);
    ask(makeObjectId(9, 1), -0.003);
    EXPECT_NEAR(up, in_a_hand ? -1 : 1, 0.01);
  }
}

}  // namespace
}  // namespace hapticd
