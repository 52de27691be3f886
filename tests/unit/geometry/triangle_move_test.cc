/** @file
 * A triangle that moves past a point: when and where, against halving the interval.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rt/geometry/sweep/sweep.h"
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
  constexpr double kSkin = 1e-12;
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
    const bool overtaken = overtakes(move, 1, kSkin, y);
    if (w.minCoeff() > 0) {
      ++taken;
      ASSERT_TRUE(overtaken) << i;
      ASSERT_NEAR(m.height(y, 1), kSkin, 1e-12) << i;
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
TEST(TriangleMove, WhatIsBehindByAHairIsOvertakenFromTheSideThatIsKnown) {
  constexpr double kSkin = 1e-13;
  TriangleMove move{};
  const float corners[3][3] = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  std::copy(&corners[0][0], &corners[0][0] + 9, &move.before[0][0]);
  move.corner = 2;
  move.after[1] = 1;
  const auto overtaken = [&](float rises, int side, double height, Vec3& x) {
    move.after[2] = rises;
    x = Vec3(0, 0, height);
    return overtakes(move, side, kSkin, x);
  };
  const auto above = [&](const Vec3& x) {
    const Vec3 normal = Vec3(2, 0, 0).cross(Vec3(1, 2, move.after[2])).normalized();
    return normal.dot(x - Vec3(0, -1, 0));
  };
  Vec3 x;
  for (const double height : {0.9, 0.0, -0.9, -3.9, -1e6}) {  // The last has been pushed through it.
    ASSERT_TRUE(overtaken(1e-3F, 1, height * kSkin, x)) << height;
    ASSERT_NEAR(above(x), kSkin, 1e-15) << height;
    ASSERT_TRUE(overtaken(-1e-3F, -1, -height * kSkin, x)) << height;
    ASSERT_NEAR(above(x), -kSkin, 1e-15) << height;
  }
  EXPECT_FALSE(overtaken(1e-3F, -1, -kSkin, x));  // It goes away.
  EXPECT_FALSE(overtaken(-1e-3F, 1, -3 * kSkin, x));
  EXPECT_EQ(x, Vec3(0, 0, -3 * kSkin));
}

}  // namespace
}  // namespace hapticd
