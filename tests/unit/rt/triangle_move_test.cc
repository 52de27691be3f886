/** @file
 * A triangle that moves past a point: when and where, against halving the interval.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rt/geometry/sweep.h"
#include "tests/support/random.h"

namespace hapticd {
namespace {

/** One corner on a straight way, by definition. */
struct Moving {
  Vec3 v[3], way;
  int corner;

  [[nodiscard]] Vec3 at(int k, double t) const { return k == corner ? Vec3(v[k] + t * way) : v[k]; }
  [[nodiscard]] Vec3 normal(double t) const { return (at(1, t) - at(0, t)).cross(at(2, t) - at(0, t)).normalized(); }
  [[nodiscard]] double area(double t) const { return (at(1, t) - at(0, t)).cross(at(2, t) - at(0, t)).norm(); }
  [[nodiscard]] double height(const Vec3& x, double t) const { return normal(t).dot(x - at(0, t)); }
  /** Barycentric, of x seen along the normal. */
  [[nodiscard]] Vec3 weights(const Vec3& x, double t) const {
    Vec3 w;
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = at((k + 1) % 3, t), b = at((k + 2) % 3, t);
      const Vec3 n = (at(1, t) - at(0, t)).cross(at(2, t) - at(0, t));
      w[k] = (b - a).cross(x - a).dot(n) / n.squaredNorm();
    }
    return w;
  }
};

TEST(TriangleMove, TakesAlongWhatItPassesHoweverItGrows) {
  Random random(1);
  constexpr double kTolerance = 1e-12;
  int taken = 0, left = 0;
  for (int i = 0; i < 100000; ++i) {
    Moving m;
    for (Vec3& v : m.v) v = asFloat(random.vector(1));
    m.corner = random.below(3);
    m.way = asFloat(Vec3(m.v[m.corner] + random.vector(std::pow(10, random.in(-3, 1))))) - m.v[m.corner];
    const Vec3 x = random.vector(1);
    if (m.area(0) < 0.1 || m.area(1) < 0.1) continue;  // Needles are another test's.
    const double before = m.height(x, 0), after = m.height(x, 1);
    if (before < 1e-6 || after > -1e-6) continue;
    double low = 0, high = 1;
    for (int k = 0; k < 60; ++k) {
      const double t = 0.5 * (low + high);
      (m.height(x, t) > 0 ? low : high) = t;
    }
    const Vec3 w = m.weights(x, low);
    if (std::abs(w.minCoeff()) < 1e-6) continue;
    TriangleMove move{};
    for (int k = 0; k < 3; ++k) {
      for (int c = 0; c < 3; ++c) move.before[k][c] = static_cast<float>(m.v[k][c]);
    }
    for (int c = 0; c < 3; ++c) move.after[c] = static_cast<float>(m.at(m.corner, 1)[c]);
    move.corner = static_cast<std::uint32_t>(m.corner);
    Vec3 y = x;
    const bool overtaken = overtakes(move, {}, kTolerance, y, y) == Overtaking::kDone;
    if (w.minCoeff() > 0) {
      ++taken;
      ASSERT_TRUE(overtaken) << i;
      ASSERT_NEAR(m.height(y, 1), kTolerance, 1e-12) << i;
      ASSERT_LT((m.weights(y, 1) - w).norm(), 1e-6) << i;  // On with the same point of the surface.
    } else {
      ++left;
      ASSERT_FALSE(overtaken) << i;
      ASSERT_EQ(y, x);
    }
  }
  EXPECT_GT(taken, 300);
  EXPECT_GT(left, 300);
}

/** As in a crease, where one face has pushed a point behind the other before that one moves on. */
TEST(TriangleMove, WhatIsBehindByLessThanAHairIsOvertakenIfItsSideIsKnown) {
  constexpr double kTolerance = 1e-14;
  TriangleMove move{};
  const float corners[3][3] = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  std::copy(&corners[0][0], &corners[0][0] + 9, &move.before[0][0]);
  move.corner = 2;
  move.after[1] = 1;
  move.after[2] = 1e-3F;
  const auto overtaken = [&](double height, int on, Vec3& x) {
    x = Vec3(0, 0, height);
    return overtakes(move, {false, on}, kTolerance, x, x);
  };
  Vec3 x;
  EXPECT_EQ(overtaken(-0.9 * kTolerance, 0, x), Overtaking::kDone);
  EXPECT_EQ(overtaken(-30 * kTolerance, 0, x), Overtaking::kUnsure);
  EXPECT_EQ(x.z(), -30 * kTolerance);
  EXPECT_FALSE(isInFront(move, x, kTolerance));
  EXPECT_EQ(overtaken(-30 * kTolerance, 1, x), Overtaking::kDone);
  const Vec3 normal = Vec3(2, 0, 0).cross(Vec3(1, 2, 1e-3F)).normalized();
  EXPECT_NEAR(normal.dot(x - Vec3(0, -1, 0)), kTolerance, 1e-15);
  EXPECT_EQ(overtaken(-100 * kTolerance, 1, x), Overtaking::kNone);  // Behind it, beyond doubt.
  EXPECT_TRUE(isInFront(move, Vec3(0.1, 0, 1e-3), kTolerance));
  move.after[2] = -1e-3F;
  EXPECT_EQ(overtaken(-30 * kTolerance, 1, x), Overtaking::kNone);  // It goes away.
}

}  // namespace
}  // namespace hapticd
