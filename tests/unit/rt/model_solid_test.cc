#include "rt/render/model_solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/random.h"

namespace hapticd {
namespace {

constexpr double kRounding = 0.5e-3;

struct Solid {
  float plane[HD_HALFSPACES][4] = {};
  std::uint32_t count = 0;

  void add(const Vec3& n, double d) {
    for (int i = 0; i < 3; ++i) plane[count][i] = static_cast<float>(n.normalized()[i]);
    plane[count++][3] = static_cast<float>(d);
  }
  [[nodiscard]] Vec3 n(std::uint32_t i) const { return {plane[i][0], plane[i][1], plane[i][2]}; }
  [[nodiscard]] double slack(std::uint32_t i, const Vec3& x) const { return plane[i][3] - n(i).dot(x); }
};

Solid randomSolid(Random& random) {
  Solid s;
  const int count = 1 + random.below(HD_HALFSPACES);
  while (static_cast<int>(s.count) < count) {
    const Vec3 n = random.vector(1);
    if (n.norm() > 0.1) s.add(n, random.in(0, 0.01));
  }
  return s;
}

/** Minimum of sum(l s) + r/2 (|l|^2 - 1) over the simplex, by thousands of Frank-Wolfe steps: slow and different. */
double bruteDepth(const Solid& s, const Vec3& x) {
  std::vector<double> l(s.count, 1.0 / s.count);
  for (int step = 0; step < 20000; ++step) {
    std::size_t best = 0, worst = 0;
    const auto gradient = [&](std::size_t i) { return s.slack(i, x) + kRounding * l[i]; };
    for (std::size_t i = 0; i < s.count; ++i) {
      if (gradient(i) < gradient(best)) best = i;
      if (l[i] > 0 && (l[worst] == 0 || gradient(i) > gradient(worst))) worst = i;
    }
    const double move = std::min(l[worst], (gradient(worst) - gradient(best)) / (2 * kRounding));
    if (move < 1e-15) break;
    l[best] += move;
    l[worst] -= move;
  }
  double depth = -0.5 * kRounding;
  for (std::size_t i = 0; i < s.count; ++i) depth += l[i] * s.slack(i, x) + 0.5 * kRounding * l[i] * l[i];
  return depth;
}

TEST(SolidDepth, OneFaceAwayFromEdgesIsExact) {
  Solid box;
  for (int axis = 0; axis < 3; ++axis) {
    box.add(Vec3::Unit(axis), 0.01);
    box.add(-Vec3::Unit(axis), 0.01);
  }
  const SolidDepth s = solidDepth(box.plane, box.count, kRounding, {0.008, 0.001, -0.002});
  EXPECT_NEAR(s.depth, 0.002, 1e-9);
  EXPECT_LT((s.normal - Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT(solidDepth(box.plane, box.count, kRounding, {0.0101, 0, 0}).depth, 0);
}

TEST(SolidDepth, EdgeIsAFillet) {
  Solid wedge;
  wedge.add(Vec3::UnitX(), 0);
  wedge.add(Vec3::UnitY(), 0);
  const SolidDepth s = solidDepth(wedge.plane, 2, kRounding, {-0.002, -0.002, 0});
  EXPECT_NEAR(s.depth, 0.002 - kRounding / 4, 1e-12);
  EXPECT_LT((s.normal - Vec3(0.5, 0.5, 0)).norm(), 1e-12);
}

TEST(SolidDepth, AgreesWithBruteForce) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Solid s = randomSolid(random);
    const Vec3 x = random.vector(0.004);
    ASSERT_NEAR(solidDepth(s.plane, s.count, kRounding, x).depth, bruteDepth(s, x), 1e-9) << "solid " << i;
  }
}

TEST(SolidDepth, NormalIsTheGradientAndNeverJumps) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Solid s = randomSolid(random);
    const Vec3 x = random.vector(0.004);
    const SolidDepth at = solidDepth(s.plane, s.count, kRounding, x);
    const double h = 1e-8;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 dx = h * Vec3::Unit(axis);
      const double slope = (solidDepth(s.plane, s.count, kRounding, x + dx).depth -
                            solidDepth(s.plane, s.count, kRounding, x - dx).depth) /
                           (2 * h);
      ASSERT_NEAR(slope, -at.normal[axis], 1e-3) << "solid " << i;
    }
    const Vec3 step = random.vector(1e-5);
    const SolidDepth moved = solidDepth(s.plane, s.count, kRounding, x + step);
    ASSERT_LE((moved.normal - at.normal).norm(), step.norm() * s.count / kRounding + 1e-12);
  }
}

/** Projection on the intersection of the outsides, by every set of up to three planes. Exact, cubic. */
Vec3 bruteWayOut(const Solid& s, const Vec3& x, bool& exists) {
  Vec3 best = Vec3::Zero();
  double least = 1e300;
  const auto offer = [&](const Vec3& e) {
    for (std::uint32_t i = 0; i < s.count; ++i) {
      if (s.slack(i, x + e) > 1e-9) return;
    }
    if (e.norm() < least) {
      least = e.norm();
      best = e;
    }
  };
  offer(Vec3::Zero());
  for (std::uint32_t i = 0; i < s.count; ++i) {
    offer(s.slack(i, x) * s.n(i));
    for (std::uint32_t j = 0; j < i; ++j) {
      Eigen::Matrix<double, 3, 2> A;
      A << s.n(i), s.n(j);
      const Eigen::Matrix2d G = A.transpose() * A;
      if (std::abs(G.determinant()) > 1e-9) offer(A * G.inverse() * Eigen::Vector2d(s.slack(i, x), s.slack(j, x)));
      for (std::uint32_t k = 0; k < j; ++k) {
        Mat3 B;
        B << s.n(i), s.n(j), s.n(k);
        if (std::abs(B.determinant()) > 1e-9) {
          offer(B.transpose().inverse() * Vec3(s.slack(i, x), s.slack(j, x), s.slack(k, x)));
        }
      }
    }
  }
  exists = least < 1e299;
  return best;
}

TEST(WayOut, SquareCornerIsExact) {
  Solid corner;
  for (int axis = 0; axis < 3; ++axis) corner.add(Vec3::Unit(axis), 0);
  EXPECT_LT((wayOut(corner.plane, 3, {-1e-3, -2e-3, -3e-3}) - Vec3(1e-3, 2e-3, 3e-3)).norm(), 1e-12);
  EXPECT_LT((wayOut(corner.plane, 3, {-1e-3, 2e-3, 3e-3}) - Vec3(1e-3, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(wayOut(corner.plane, 3, {1e-3, 2e-3, 3e-3}), Vec3(0, 0, 0));
}

TEST(WayOut, AgreesWithEverySetOfPlanes) {
  // The softness lets the proxy sink a little. From the cost at the exact answer: |e| <= |exact| and no plane is left
  // deeper than sqrt(kCornerSoftness) |exact|; in corners that are not steep the two are the same to a tenth.
  Random random(3);
  int compared = 0;
  for (int i = 0; i < 3000; ++i) {
    Solid s;
    const int count = 1 + i % 6;
    while (static_cast<int>(s.count) < count) {
      const Vec3 n = random.vector(1) + Vec3(0, 0, 0.9);
      if (n.norm() > 0.3) s.add(n, random.in(-0.002, 0.002));
    }
    const Vec3 x = random.vector(0.004);
    bool exists = false;
    const Vec3 brute = bruteWayOut(s, x, exists);
    if (!exists) continue;
    const Vec3 e = wayOut(s.plane, s.count, x) / (1 + kCornerSoftness);
    double deepest = 0;
    for (std::uint32_t k = 0; k < s.count; ++k) {
      deepest = std::max(deepest, s.slack(k, x));
      ASSERT_LE(s.slack(k, x + e), std::sqrt(kCornerSoftness) * brute.norm() + 1e-8) << "case " << i;
    }
    ASSERT_LE(e.norm(), brute.norm() + 1e-8) << "case " << i;
    if (brute.norm() > 1.5 * deepest) continue;
    ++compared;
    ASSERT_LT((wayOut(s.plane, s.count, x) - brute).norm(), 0.1 * brute.norm() + 1e-9) << "case " << i;
  }
  EXPECT_GT(compared, 1500);
}

TEST(WayOut, IsTheExactMinimum) {
  // No step in any direction lowers the cost of the header, also where no outside is left.
  Random random(4);
  for (int i = 0; i < 3000; ++i) {
    const Solid s = randomSolid(random);
    const Vec3 x = random.vector(0.01);
    const Vec3 e = wayOut(s.plane, s.count, x) / (1 + kCornerSoftness);
    Vec3 gradient = kCornerSoftness * e;
    for (std::uint32_t k = 0; k < s.count; ++k) gradient -= std::max(0.0, s.slack(k, x + e)) * s.n(k);
    ASSERT_LT(gradient.norm(), 1e-12) << "case " << i;
  }
}

TEST(WayOut, NeverMovesFurtherThanTheTool) {
  Random random(5);
  for (int i = 0; i < 5000; ++i) {
    const Solid s = randomSolid(random);
    const Vec3 x = random.vector(0.01);
    const Vec3 step = random.vector(2e-4);
    const Vec3 change = wayOut(s.plane, s.count, x + step) - wayOut(s.plane, s.count, x);
    ASSERT_LE(change.norm(), (1 + kCornerSoftness) * step.norm() + 1e-12);
  }
}

}  // namespace
}  // namespace hapticd
