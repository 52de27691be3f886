// A tool's contacts with the scene where the time or the work for them is not enough.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rt/collide/scene_contacts.h"
#include "tests/unit/contact/question.h"

namespace hapticd {
namespace {

using test::kPlateEntry;
using test::kToolEntry;
using test::Question;

TEST(SceneContacts, ABudgetOfNothingIsKeptAndTold) {
  Question q;
  q.held.shape = Shape{ShapeKind::kBox, Vec3(0.01, 0.01, 0.01)};
  q.held.obstacle[0].shape = Shape{ShapeKind::kPlane};
  q.held.X_WO.p = Vec3(0, 0, 0.0099);
  ContactModel model;
  q.contacts->find(q.held, 0, {20, 0, nullptr}, model, q.report);
  EXPECT_TRUE(q.report.exhausted);
  EXPECT_LE(q.report.work, 21u);
  EXPECT_GT(q.report.dropped, 100u);
  // Again and again: it gets round, and what touched is tried first.
  for (int i = 0; i < 40; ++i) q.contacts->find(q.held, 0, {20, 0, nullptr}, model, q.report);
  EXPECT_GT(model.count, 3u);
}

TEST(SceneContacts, ABudgetThatIsTooSmallGetsRoundAllThatTouches) {
  // The 81 points of a box's face lie on the floor, and some twenty can be tried a time.
  Question q;
  q.held.shape = Shape{ShapeKind::kBox, Vec3(0.01, 0.01, 0.01)};
  q.held.obstacle[0].shape = Shape{ShapeKind::kPlane};
  q.held.X_WO.p = Vec3(0, 0, 0.0099);
  std::set<std::uint32_t> seen;
  for (int i = 0; i < 200; ++i) {
    ContactModel model;
    q.contacts->find(q.held, 0, {20, 0, nullptr}, model, q.report);
    EXPECT_LE(q.report.work, 20u);
    for (std::uint32_t k = 0; k < model.count; ++k) seen.insert(model.point[k].key);
  }
  EXPECT_EQ(seen.size(), 81u);
}

/** Notes how much work is done from one look at it to the next; is past any deadline at the look that it is told. */
struct WatchedClock final : Clock {
  std::int64_t now() HD_RT override {
    most = std::max(most, report->work - last);
    last = report->work;
    return ++looks < late_at ? 1 : 1'000'000'000;
  }
  void sleepUntil(std::int64_t) HD_RT override {}
  const DetectorReport* report = nullptr;
  std::uint32_t last = 0, most = 0;
  int looks = 0, late_at = 1 << 30;
};

TEST(SceneContacts, TheClockIsReadByWorkNotByPoints) {
  // 800 points in the middle of a fine ball: all its triangles are as far.
  Question q;
  test::TestMesh tool = test::sphereMesh(0.0003, 20), hollow = test::sphereMesh(0.008, 50);
  q.held.shape = Shape{ShapeKind::kMesh, Vec3::Zero(), tool.view(), 40};
  q.held.obstacle[0].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), hollow.view(), 41};
  WatchedClock clock;
  clock.report = &q.report;
  ContactModel model;
  q.contacts->find(q.held, 0, {400'000, 1000, &clock}, model, q.report);
  EXPECT_GT(q.report.work, 200'000u) << "it is much work";
  EXPECT_LE(clock.most, 256 + SceneContacts::kWorkOfOne + 64);
  clock.last = clock.looks = 0;
  clock.late_at = 10;
  q.contacts->find(q.held, 0, {400'000, 1000, &clock}, model, q.report);
  EXPECT_LE(q.report.work, 10 * (256 + SceneContacts::kWorkOfOne + 64));
  EXPECT_TRUE(q.report.exhausted);
  EXPECT_GT(q.report.dropped, 0u);
}

TEST(SceneContacts, AnAnswerWithoutTimeKeepsWhatTouchedForAWhile) {
  for (const bool by_field : {true, false}) {
    Question q;
    test::TestMesh ball = test::sphereMesh(0.01, 20), plate = test::boxMesh({0.02, 0.02, 0.005});
    q.held.shape.mesh = ball.view();
    q.held.obstacle[0].shape.mesh = plate.view();
    if (!by_field) q.volumes.publish(kPlateEntry, nullptr);
    q.held.X_WO.p = Vec3(0.003, 0.001, 0.014);
    WatchedClock clock;
    clock.report = &q.report;
    ContactModel model;
    const auto ask = [&](bool in_time) {
      clock.last = clock.looks = 0;
      clock.late_at = in_time ? 1 << 30 : 1;
      q.contacts->find(q.held, 0, {400'000, 1000, &clock}, model, q.report);
      return model.count;
    };
    ASSERT_GT(ask(true), 0u);
    EXPECT_FALSE(q.report.exhausted);
    q.held.X_WO.p.z() -= 0.0002;  // Meanwhile it sinks.
    for (int i = 0; i < 50; ++i) {
      ASSERT_GT(ask(false), 0u) << i;
      EXPECT_TRUE(q.report.exhausted);
      EXPECT_NEAR(q.deepest(model), 0.0012, 5e-5);
    }
    EXPECT_EQ(ask(false), 0u) << "not for ever";
    ASSERT_GT(ask(true), 0u);
    ASSERT_GT(ask(false), 0u);
    q.held.obstacle[0].shape.number = 3;
    EXPECT_EQ(ask(false), 0u) << "another object is there now";
    ASSERT_GT(ask(true), 0u);
    q.held.X_WO.p.z() = 0.019;
    EXPECT_EQ(ask(false), 0u) << "it has left it";
    q.held.X_WO.p.z() = 0.014;
    ASSERT_GT(ask(true), 0u);
    q.held.count = 0;
    EXPECT_EQ(ask(false), 0u) << "it has gone";
  }
}

/** Of a deadline of 1000 it is 900 once the budget has been shared out: the part for what touched is over, the rest is
 * not. */
struct SpentClock final : Clock {
  std::int64_t now() HD_RT override { return ++looks > 1 ? 900 : 1; }
  void sleepUntil(std::int64_t) HD_RT override {}
  int looks = 0;
};

TEST(SceneContacts, WhatTouchedHasItsTurnInTheTimeThatTheOthersLeft) {
  Question q;
  q.held.shape = Shape{ShapeKind::kBox, Vec3(0.01, 0.01, 0.01)};
  q.held.obstacle[0].shape = Shape{ShapeKind::kPlane};
  const std::uint32_t all = q.ask({0, 0, 0.0099}).count;
  ASSERT_GT(all, 3u);
  SpentClock clock;
  ContactModel none;
  q.contacts->find(q.held, 0, {400'000, 1000, &clock}, none, q.report);
  EXPECT_EQ(none.count, all);
  EXPECT_EQ(q.report.dropped, 0u);
}

TEST(SceneContacts, WhatAnEdgeTouchesIsKeptWhereTheTimeForEdgesIsOverAndThatForPointsIsNot) {
  // Two bars across each other, edge on edge: no point of the tool is near.
  Question q;
  const Quat on_edge(Eigen::AngleAxisd(EIGEN_PI / 4, Vec3::UnitX()));
  q.held.shape = q.held.obstacle[0].shape = Shape{ShapeKind::kBox, Vec3(0.05, 0.01, 0.01)};
  q.held.obstacle[0].X_WO.q = on_edge;
  q.held.X_WO = {{0, 0, 2 * std::sqrt(2) * 0.01 - 0.0005},
                 Quat(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitZ())) * on_edge};
  q.held.X_WO.p.x() = 0.0007;
  ContactModel model;
  q.contacts->find(q.held, 0, {1'000'000, 0, nullptr}, model, q.report);
  ASSERT_GT(model.count, 0u);
  SpentClock clock;
  q.contacts->find(q.held, 0, {400'000, 1000, &clock}, model, q.report);
  EXPECT_TRUE(q.report.exhausted);
  ASSERT_GT(model.count, 0u);
  EXPECT_NEAR(q.deepest(model), 0.0005, 1e-5);
}

TEST(SceneContacts, APointThatIsKnownToHaveLeftIsNotKeptWhereTheTimeForEdgesWasNotEnough) {
  Question q;  // On a table, and then over its end.
  q.held.shape = Shape{ShapeKind::kBox, Vec3(0.01, 0.01, 0.01)};
  q.held.obstacle[0].shape = Shape{ShapeKind::kBox, Vec3(0.02, 0.02, 0.01)};
  q.held.obstacle[0].X_WO.p = Vec3(0, 0, -0.01);
  ContactModel model;
  const auto farthest = [&](double x, const WorkBudget& budget) {
    q.held.X_WO.p = Vec3(x, 0.0003, 0.0099);
    q.contacts->find(q.held, 0, budget, model, q.report);
    double most = -1;
    for (std::uint32_t i = 0; i < model.count; ++i) {
      const Touch touch = model.touch(i, q.held.X_WO, Vec3::Zero(), q.held.obstacle[0].X_WO, Twist{});
      most = std::max(most, touch.r_a.x());
    }
    return most;
  };
  ASSERT_NEAR(farthest(0.0095, {1'000'000, 0, nullptr}), 0.0195, 1e-4);
  SpentClock clock;
  const double most = farthest(0.015, {400'000, 1000, &clock});
  EXPECT_EQ(q.report.dropped, 0u);
  EXPECT_TRUE(q.report.exhausted);
  EXPECT_GT(most, 0.005) << "it lies on the rest";
  EXPECT_LT(most, 0.0201);
}

TEST(SceneContacts, WhatLiesAheadIsKeptTooWhereTheTimeWasNotEnoughToLook) {
  Question q;
  q.held.V_WO.v.z() = -2;
  q.held.speed = 2;
  q.held.X_WO.p = Vec3(0.003, 0.001, 0.005 + 0.01 + 0.004);
  WatchedClock clock;
  clock.report = &q.report;
  ContactModel model;
  for (const int looks_in_time : {1000, 1, 0}) {  // All, only where it is, not even there.
    clock.last = clock.looks = 0;
    clock.late_at = looks_in_time + 1;
    q.contacts->find(q.held, 0.003, {400'000, 1000, &clock}, model, q.report);
    ASSERT_GT(model.count, 0u) << looks_in_time;
    EXPECT_NEAR(q.deepest(model), -0.004, 5e-5);
    EXPECT_EQ(q.report.exhausted, looks_in_time < 2);
  }
}

TEST(SceneContacts, WhatWasCutShortComesFirstTheNextTime) {
  // Four plates about a ball, all touched; there is time for one at a time.
  Question q;
  q.held.count = 4;
  for (int k = 0; k < 4; ++k) {
    q.held.obstacle[k] = q.held.obstacle[0];
    q.held.obstacle[k].slot = 7 + static_cast<std::uint32_t>(k);
    const Quat turn(Eigen::AngleAxisd(k * EIGEN_PI / 2, Vec3::UnitX()));
    q.held.obstacle[k].X_WO = {turn * Vec3(0, 0, -0.0149), turn};
  }
  WatchedClock clock;
  clock.report = &q.report;
  ContactModel model;
  std::set<std::uint32_t> touched;
  for (int i = 0; i < 4; ++i) {
    clock.last = clock.looks = 0;
    clock.late_at = 2;  // One look for the first, and the next finds it late.
    q.contacts->find(q.held, 0, {400'000, 1000, &clock}, model, q.report);
    for (std::uint32_t c = 0; c < model.count; ++c) touched.insert(model.point[c].body());
    EXPECT_EQ(touched.size(), static_cast<std::size_t>(i) + 1);
  }
  std::set<std::uint32_t> now;
  for (std::uint32_t c = 0; c < model.count; ++c) now.insert(model.point[c].body());
  EXPECT_EQ(now.size(), 4u) << "those looked at before are kept meanwhile";
}

TEST(SceneContacts, HowDeepAPointIsIsNotForgottenWhereTheWorkWasNotEnough) {
  // In the middle of a fine ball any triangle may be the nearest: more than a point may look at.
  Question q;
  test::TestMesh ball = test::sphereMesh(0.03, 100);
  q.held.shape = Shape{ShapeKind::kSphere, Vec3(0.002, 0, 0)};
  q.held.obstacle[0].shape = Shape{ShapeKind::kMesh, Vec3::Zero(), ball.view(), 40};
  for (int mm = 32; mm >= 0; mm -= 4) (void)q.ask({0, 0, 1e-3 * mm});
  EXPECT_EQ(q.report.dropped, 1u) << "else the test shows nothing";
  const ContactModel model = q.ask({0, 0, 0.02});
  ASSERT_EQ(model.count, 1u);
  EXPECT_NEAR(q.deepest(model), 0.012, 1e-4);
}

}  // namespace
}  // namespace hapticd
