// The curve through the points of a path, and the search for its nearest place.
#include "rt/effect/path.h"

#include <gtest/gtest.h>

#include "tests/support/for_seeds.h"

namespace hapticd {
namespace {

EffectParameters pathOf(const std::vector<Vec3>& points) {
  EffectParameters out{};
  out.points = static_cast<std::uint32_t>(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) out.path[i][axis] = static_cast<float>(points[i][axis]);
  }
  return out;
}

/** Catmull and Rom's span from b to c by its matrix form, as textbooks print it. */
Vec3 textbook(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double t) {
  return 0.5 * (2 * b + t * (c - a) + t * t * (2 * a - 5 * b + 4 * c - d) + t * t * t * (3 * b - a - 3 * c + d));
}

TEST(Path, OfTwoPointsIsALine) {
  const EffectParameters path = pathOf({{0, 0, 0}, {0.03, 0, 0}});
  PathPlace place;
  ASSERT_TRUE(nearestOnPath(path, {0.013, 0.004, 0}, 0.01, place));
  EXPECT_LT((place.point - Vec3(0.013, 0, 0)).norm(), 1e-9);
  EXPECT_LT((place.tangent - Vec3::UnitX()).norm(), 1e-9);
  ASSERT_TRUE(nearestOnPath(path, {0.034, 0.003, 0}, 0.01, place)) << "beyond its end, 5 mm away";
  EXPECT_LT((place.point - Vec3(0.03, 0, 0)).norm(), 1e-9);
  EXPECT_FALSE(nearestOnPath(path, {0.01, 0.011, 0}, 0.01, place));
}

TEST(Path, IsFoundWhereTheTextbooksCurveIsNearest) {
  forSeeds(100, [](unsigned seed) {
    Random random(seed);
    std::vector<Vec3> points;
    const bool closed = random.once(3);
    const int count = 3 + random.below(9);
    for (int i = 0; i < count; ++i) points.push_back(asFloat(Vec3(random.vector(0.05))));
    if (closed) points.push_back(points.front());
    const EffectParameters path = pathOf(points);
    const auto last = points.size() - 1;
    const auto at = [&](std::ptrdiff_t i) -> Vec3 {
      const auto n = static_cast<std::ptrdiff_t>(last);
      if (i < 0) return closed ? points[last - 1] : Vec3(2 * points[0] - points[1]);
      if (i > n) return closed ? points[1] : Vec3(2 * points[last] - points[last - 1]);
      return points[static_cast<std::size_t>(i)];
    };
    for (int ask = 0; ask < 20; ++ask) {
      const Vec3 x = random.vector(0.07);
      double truth = INFINITY;
      for (std::size_t i = 0; i < last; ++i) {
        const auto k = static_cast<std::ptrdiff_t>(i);
        for (int s = 0; s <= 400; ++s)
          truth = std::min(truth, (x - textbook(at(k - 1), at(k), at(k + 1), at(k + 2), s / 400.0)).norm());
      }
      PathPlace place;
      ASSERT_TRUE(nearestOnPath(path, x, 1, place));
      // Chords of an eighth of a span, of points up to 0.17 m apart: within their sagitta.
      EXPECT_NEAR((x - place.point).norm(), truth, 2e-3);
      PathPlace same;
      ASSERT_EQ(nearestOnPath(path, x, (x - place.point).norm() + 1e-9, same), true) << "reach does not change it";
      EXPECT_EQ(same.point, place.point);
      EXPECT_FALSE(nearestOnPath(path, x, (x - place.point).norm() - 1e-9, same));
    }
    for (const Vec3& point : points) {
      PathPlace place;
      ASSERT_TRUE(nearestOnPath(path, point, 1e-3, place)) << "it goes through its points";
      EXPECT_LT((place.point - point).norm(), 1e-9);
    }
  });
}

TEST(Path, IsThereBeyondItsEndHoweverCloseTheHandIs) {
  forSeeds(2000, [](unsigned seed) {
    Random random(seed);
    const Vec3 end = asFloat(Vec3(random.vector(100)));
    const EffectParameters path = pathOf({end - random.vector(1), end - random.vector(0.01), end});
    Vec3 control[4];
    spanOfPath(path, path.points - 2, control);
    const Vec3 beyond = (control[3] - control[2]).normalized();
    PathPlace place;
    for (double distance = 1e-3; distance > 1e-12; distance *= 0.3)
      ASSERT_TRUE(nearestOnPath(path, end + distance * beyond, 1, place)) << distance << " m beyond the end";
  });
}

TEST(Path, ThatEndsWhereItBeginsIsSmoothThere) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(0.03 * std::cos(i * M_PI / 4), 0.03 * std::sin(i * M_PI / 4), 0);
  corners.push_back(corners.front());
  const EffectParameters ring = pathOf(corners);
  for (int degree = 0; degree < 360; ++degree) {
    const double angle = degree * M_PI / 180;
    PathPlace place;
    ASSERT_TRUE(nearestOnPath(ring, 0.031 * Vec3(std::cos(angle), std::sin(angle), 0), 0.01, place));
    EXPECT_NEAR(place.point.norm(), 0.03, 3e-4) << "eight spans are a circle but for a hundredth";
    EXPECT_LT(std::abs(place.tangent.dot(place.point.normalized())), 0.1) << degree;
  }
}

TEST(Path, OfPointsThatAreOneIsThatPoint) {
  const EffectParameters path = pathOf({{0.01, 0, 0}, {0.01, 0, 0}, {0.01, 0, 0}});
  PathPlace place;
  ASSERT_TRUE(nearestOnPath(path, {0.012, 0, 0}, 0.01, place));
  EXPECT_LT((place.point - Vec3(0.01, 0, 0)).norm(), 1e-9);
  EXPECT_EQ(place.tangent, Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace hapticd
