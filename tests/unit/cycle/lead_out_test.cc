// The way out of what a body was put into, of contacts that a test makes up: which, how far in a tick, and when none.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "rt/collide/feature.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr double kLeadDt = 1e-3;
constexpr std::uint32_t kLed = makeObjectId(1, 1);

/** A plane of something, and the body's point that is so far above it. */
struct ToldPlane {
  std::uint32_t slot;
  Vec3 p, n;
  double gap;
  bool whole = false;  ///< Of all of both.

  [[nodiscard]] double below(const ToldPlane& other) const { return -gap + n.dot(p - other.p); }
};

/** A body without weight that may be in two things, either of which may move, too; its hand is far away. */
class LedBody : public test::SteppedCycle {
 public:
  explicit LedBody(std::uint32_t other = 0) : SteppedCycle(test::openConfig(10)), other_(other) {
    for (const std::uint32_t slot : {1u, 2u, 3u})
      add(test::solid(makeObjectId(slot, 1), ShapeKind::kBox, {1000, 0, 0, 0}, {}, Vec3::Constant(0.01)));
    loosen(kLed);
    if (other != 0) loosen(makeObjectId(other, 1));
    do go({});
    while (cycle->bodies().wasPut(0));
  }
  void loosen(std::uint32_t id) { put(CommandKind::kSetBody, SetBody{id, 0, 0.1, {}, {1e-5, 1e-5, 1e-5, 0, 0, 0}, 0}); }
  /** A tick later; where the body went in it. The other one knows of these. */
  Vec3 go(const std::vector<ToldPlane>& all, const std::vector<ToldPlane>& others = {}) {
    const Vec3 before = body().com();
    tell(0, kLed, all);
    if (other_ != 0) tell(1, makeObjectId(other_, 1), others);
    (void)at({0, 0, 1});
    return body().com() - before;
  }
  const RigidBody& body(std::uint8_t k = 0) const { return cycle->bodies().body(k).body; }

 private:
  void tell(std::uint8_t k, std::uint32_t id, const std::vector<ToldPlane>& all) {
    ToolContacts contacts{};
    contacts.device = kMaxDevices + k;
    contacts.object = id;
    for (const ToldPlane& told : all) {
      ToolContacts::Point& point = contacts.point[contacts.count++];
      const Vec3 p = told.p - body(k).com();
      for (int i = 0; i < 3; ++i) {
        point.p_A[i] = static_cast<float>(p[i]);
        point.n_B[i] = static_cast<float>(told.n[i]);
      }
      point.offset = static_cast<float>(told.n.dot(told.p) - told.gap);
      point.key = told.slot << 24 | ((told.whole ? kWayOut : contacts.count) + 1);
    }
    answer(contacts);
  }
  std::uint32_t other_;
};

/** As slowly as tools leave an overlap. */
double ledBy(double deep) { return kLeadDt * std::min(Tool::kRecoverSpeed, (deep - Tool::kSlop) / Tool::kRecoverTime); }

TEST(LeadOut, ItGoesStraightOutEverMoreSlowlyAndStops) {
  LedBody body;
  const Vec3 n = Vec3(1, -2, 3).normalized();
  double deep = 0.004;
  int ticks = 0;
  for (; deep > 1.1e-5 && ticks < 1000; ++ticks) {
    const double way = ledBy(deep);
    ASSERT_LT((body.go({{2, Vec3::Zero(), n, -deep, true}}) - way * n).norm(), 1e-9) << ticks;
    deep -= way;
  }
  EXPECT_GT(ticks, 50);
  EXPECT_TRUE(body.go({{2, Vec3::Zero(), n, -1e-5, true}}).isZero(0)) << "it is out";
}

/** So many in a row may find nothing, whether it goes or waits for something that is in its way. */
TEST(LeadOut, MissedAnswersEndNothing) {
  for (const bool waits : {false, true}) {
    for (std::uint32_t missed = 1; missed <= FreeBodies::kMostMissed + 1; ++missed) {
      LedBody body;
      const ToldPlane in{2, Vec3::Zero(), Vec3::UnitX(), -0.05, true}, bar{3, Vec3::Zero(), -Vec3::UnitX(), 0};
      for (int i = 0; i < 120; ++i) {  // Until nobody takes it for just put there.
        ASSERT_EQ(body.go(waits ? std::vector{in, bar} : std::vector{in}).isZero(0), waits) << i;
      }
      for (std::uint32_t i = 0; i < missed; ++i) EXPECT_TRUE(body.go({}).isZero(0));
      EXPECT_EQ(body.go({in}).isZero(0), missed > FreeBodies::kMostMissed) << missed << ", waits: " << waits;
    }
  }
}

/** Nor does it lose the motion that it has. */
TEST(LeadOut, ItGoesOnAsItDidBeside) {
  LedBody body;
  const Twist V{{0, 0.05, 0}, {1, 0, 0}};
  body.put(CommandKind::kObjectPose, poseMessage(kLed, {}, V));
  const Vec3 way = body.go({{2, Vec3::Zero(), Vec3::UnitX(), -0.004, true}});
  EXPECT_LT((way - ledBy(0.004) * Vec3::UnitX() - kLeadDt * V.v).norm(), 1e-9);
  EXPECT_LT((body.body().twist().v - V.v).norm() + (body.body().twist().w - V.w).norm(), 1e-9);
}

TEST(LeadOut, WhatIsNotFeltHoldsNobody) {
  LedBody body;
  body.put(CommandKind::kObjectMaterial, hd_object_material{makeObjectId(2, 1), 0, {}});
  EXPECT_TRUE(body.go({{2, Vec3::Zero(), Vec3::UnitX(), -0.004, true}}).isZero(0));
}

/** The same tick, by all that it is told of: the least way out of each, of the longest of these; nothing, if that goes
 * against what is near. */
Vec3 wayOut(const std::vector<ToldPlane>& all) {
  const ToldPlane* chosen = nullptr;
  double longest = 0;
  for (const std::uint32_t slot : {2u, 3u}) {
    const ToldPlane* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const ToldPlane& plane : all) {
      if (plane.slot != slot || plane.gap > -1.02e-5) continue;
      double way = -plane.gap;
      for (const ToldPlane& point : all) {
        if (point.slot == slot && point.gap < 0) way = std::max(way, plane.below(point));
      }
      if (way < least) best = &plane;
      least = std::min(least, way);
    }
    if (best == nullptr || least <= longest) continue;
    chosen = best;
    longest = least;
  }
  if (chosen == nullptr) return Vec3::Zero();
  for (const ToldPlane& other : all) {
    const bool left = other.slot == chosen->slot && chosen->below(other) >= 0;
    if (!left && other.gap < FreeBodies::kTouching && other.n.dot(chosen->n) < -0.3) return Vec3::Zero();
  }
  return ledBy(longest) * chosen->n;
}

TEST(LeadOut, TheLeastWayOutOfWhatTakesTheLongest) {
  int led = 0, barred = 0;
  forSeeds(1500, [&](unsigned seed) {
    Random random(seed);
    LedBody body;
    std::vector<ToldPlane> all;
    for (const std::uint32_t slot : {2u, 3u}) {
      const Vec3 up = random.vector(1);
      const bool whole = random.once(3);
      for (int i = whole ? 1 : random.below(4); i > 0; --i) {
        const Vec3 n = (up + random.vector(0.8)).normalized();
        all.push_back({slot, random.vector(0.002), n, random.in(-2e-3, whole ? 0 : 5e-4), whole});
      }
    }
    const Vec3 expected = wayOut(all), way = body.go(all);
    ASSERT_LT((way - expected).norm(), 1e-9) << way.transpose() << " for " << expected.transpose();
    led += !expected.isZero(0);
    barred += expected.isZero(0);
  });
  EXPECT_GT(led, drawn(500));
  EXPECT_GT(barred, drawn(300));
}

/** Where all of both is known, points of it do not count. */
TEST(LeadOut, WhatIsKnownAsAWholeIsLeftByThatAlone) {
  LedBody body;
  const ToldPlane whole{2, Vec3::Zero(), Vec3::UnitX(), -0.002, true}, less{2, {0.001, 0, 0}, Vec3::UnitY(), -0.001};
  const ToldPlane against{2, {0.001, 0, 0}, -Vec3::UnitX(), -5e-5};
  EXPECT_LT((body.go({less, whole, against}) - ledBy(0.002) * Vec3::UnitX()).norm(), 1e-9);
}

/** Then it does not turn back, though that is shorter now; and goes on where another way is as long. */
TEST(LeadOut, OnceItGoesOneWayNoneLeadsBack) {
  const Vec3 x = Vec3::UnitX();
  const auto along = [](double degrees) {
    return Vec3(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180), 0);
  };
  for (const bool back : {false, true}) {
    LedBody body;
    EXPECT_GT(body.go({{2, Vec3::Zero(), x, -0.002, true}}).x(), 9e-5);
    const Vec3 other = along(back ? 125 : 115);
    const Vec3 way = body.go({{2, Vec3::Zero(), other, -0.001, true}});
    EXPECT_LT((way - (back ? 0 : 1) * ledBy(0.001) * other).norm(), 1e-9) << back;
  }
  for (const bool onward : {false, true}) {  // Of two ways out of one thing, the first of which is the longer.
    LedBody body;
    EXPECT_GT(body.go({{2, Vec3::Zero(), x, -0.002, true}}).x(), 9e-5);
    const Vec3 longer = along(onward ? 55 : 65), shorter = along(-65);
    const Vec3 way = body.go({{2, {0, 0, 0}, longer, -0.0006}, {2, {0, 0, 0}, shorter, -0.0004}});
    EXPECT_GT(way.normalized().dot(onward ? longer : shorter), 1 - 1e-6) << onward;
  }
}

/** For so long by its own turns; then it stays, though the way is free. */
TEST(LeadOut, ItIsTriedForThreeSeconds) {
  for (const bool late : {false, true}) {
    LedBody body;
    const ToldPlane deep{2, Vec3::Zero(), Vec3::UnitX(), -0.002, true}, bar{3, Vec3::Zero(), -Vec3::UnitX(), 5e-5};
    const int ticks = static_cast<int>((FreeBodies::kLeadOut + (late ? 0.3 : -0.1)) / kLeadDt);
    for (int i = 0; i < ticks; ++i) ASSERT_TRUE(body.go({deep, bar}).isZero(0));
    EXPECT_EQ(body.go({deep}).isZero(0), late);
  }
}

/** What moves may come nearer in a tick, as it does: it is waited for from farther away. */
TEST(LeadOut, ItComesNoNearerToAnotherThanBothGoInATick) {
  const double next = FreeBodies::kTouching + 2 * kLeadDt * Tool::kRecoverSpeed;
  for (const bool moves : {false, true}) {
    for (const double gap : {0.9, 1.1}) {  // Of what lets it go.
      LedBody body(moves ? 3 : 0);
      const double least = moves ? next : FreeBodies::kTouching;
      const ToldPlane deep{2, Vec3::Zero(), Vec3::UnitX(), -0.002, true};
      EXPECT_EQ(body.go({deep, {3, Vec3::Zero(), -Vec3::UnitX(), gap * least}}).isZero(0), gap < 1) << moves;
    }
  }
}

/** Who knows of it is led one way, the other back; of little, that load would explain, neither. */
TEST(LeadOut, WhatAnotherKnowsLeadsBothApart) {
  forSeeds(200, [](unsigned seed) {
    Random random(seed);
    LedBody body(2);
    const Vec3 up = random.vector(1);
    std::vector<ToldPlane> known;
    const bool little = random.once(4);
    for (int i = 1 + random.below(3); i > 0; --i) {
      const Vec3 p = little ? Vec3::Zero() : random.vector(0.001), n = (up + random.vector(0.3)).normalized();
      known.push_back({1, p, n, little ? -9e-5 : random.in(-2e-3, -3e-4)});
    }
    const bool by_other = random.once(2);
    std::vector<ToldPlane> mine;  // The same, as the body itself knows it.
    for (const ToldPlane& told : known) mine.push_back({2, told.p - told.gap * told.n, -told.n, told.gap});
    const Vec3 before = body.body(1).com(), way = by_other ? body.go({}, known) : body.go(mine);
    const Vec3 back = body.body(1).com() - before;
    if (little) {
      EXPECT_TRUE(way.isZero(0) && back.isZero(0));
      return;
    }
    const ToldPlane* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const ToldPlane& plane : by_other ? known : mine) {
      double deep = -plane.gap;
      for (const ToldPlane& point : by_other ? known : mine) deep = std::max(deep, plane.below(point));
      if (deep < least) best = &plane;
      least = std::min(least, deep);
    }
    const double first = ledBy(least), all = first + ledBy(least - first);
    const Vec3 n = by_other ? Vec3(-best->n) : best->n;
    EXPECT_LT((way - back - all * n).norm(), 1e-8) << way.transpose() << " and " << back.transpose();
    EXPECT_GT(way.dot(n), 0.4 * all);
    EXPECT_LT(back.dot(n), -0.4 * all);
  });
}

}  // namespace
}  // namespace hapticd
