/** @file
 * A triangle that moves past a point: when and where, against halving the interval.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "rt/geometry/sweep/moving_triangles.h"
#include "rt/geometry/sweep/sweep.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"

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

/** Of a tick that moves as much as it may, first what is far away, then a crowd about the point. */
double costOfCrowd(std::uint32_t crowd) {
  test::TestMesh mesh;
  for (std::uint32_t i = 0; i <= crowd; ++i) {
    const Vec3 middle = i == 0 ? Vec3(5, 0, 0) : Vec3(0, 0, 1e-4);
    const auto a = mesh.addVertex(middle + Vec3(-0.01, -0.01, -1e-3)),
               b = mesh.addVertex(middle + Vec3(0.01, -0.01, 0));
    mesh.addTriangle(a, b, mesh.addVertex(middle + Vec3(0, 0.01, i == 0 ? 0.4 : 0)));  // A jump widens the search.
  }
  const MeshView& view = *mesh.view();
  std::vector<TriangleMove> moves(Scene::kMaxTriangleMoves - crowd);
  for (std::uint32_t t = 0; t < view.triangle_count; ++t) {
    TriangleMove move{&view, t, 2, {}, {}};
    for (int c = 0; c < 3; ++c) std::copy_n(mesh.vertices[mesh.triangles[t][c]].data(), 3, move.before[c]);
    std::copy_n(move.before[2], 3, move.after);
    move.before[2][2] = move.before[1][2];
    if (move.before[0][0] > 1)
      std::fill_n(moves.begin(), Scene::kMaxTriangleMoves - crowd, move);
    else
      moves.push_back(move);
  }
  double least = 1;
  for (int i = 0; i < 60; ++i) {
    timespec begin{}, end{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
    const MovingTriangles moving(view, moves, Vec3::Zero(), {false, 0, 1e-6});
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    least = std::min(least, double(end.tv_sec - begin.tv_sec) + 1e-9 * double(end.tv_nsec - begin.tv_nsec));
  }
  return least;
}

/** Each of the reaches that might leave room was tried, up to eleven: 11 times the cost, now 4. */
TEST(TriangleMove, WhereThereIsNoRoomForAllTheyAreGoneThroughAFewTimesMore) {
  const double room = costOfCrowd(MovingTriangles::kMost - 28), none = costOfCrowd(MovingTriangles::kMost + 72);
  EXPECT_LT(none, 8 * room);
}

}  // namespace
}  // namespace hapticd
