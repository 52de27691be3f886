#include "rt/render/model/model_solid.h"

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
  Random random(seedOf(1));
  for (int i = 0; i < 300; ++i) {
    const Solid s = randomSolid(random);
    const Vec3 x = random.vector(0.004);
    ASSERT_NEAR(solidDepth(s.plane, s.count, kRounding, x).depth, bruteDepth(s, x), 1e-9) << "solid " << i;
  }
}

TEST(SolidDepth, NormalIsTheGradientAndNeverJumps) {
  Random random(seedOf(2));
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

/** The exact projection on the intersection of the outsides, way = sum(push[k] n_k). */
struct ExactWay {
  bool exists = false;
  Vec3 way = Vec3::Zero();
  double push = 0;  ///< |(push[0], push[1], ...)| [m]
};

/** By every set of up to three planes: cubic. */
ExactWay bruteWayOut(const Solid& s, const Vec3& x) {
  ExactWay best;
  const auto offer = [&](const Vec3& e, double push) {
    for (std::uint32_t i = 0; i < s.count; ++i) {
      if (s.slack(i, x + e) > 1e-9) return;
    }
    if (!best.exists || e.norm() < best.way.norm()) best = {true, e, push};
  };
  offer(Vec3::Zero(), 0);
  for (std::uint32_t i = 0; i < s.count; ++i) {
    offer(s.slack(i, x) * s.n(i), std::abs(s.slack(i, x)));
    for (std::uint32_t j = 0; j < i; ++j) {
      Eigen::Matrix<double, 3, 2> A;
      A << s.n(i), s.n(j);
      const Eigen::Matrix2d G = A.transpose() * A;
      if (std::abs(G.determinant()) > 1e-9) {
        const Eigen::Vector2d push = G.inverse() * Eigen::Vector2d(s.slack(i, x), s.slack(j, x));
        offer(A * push, push.norm());
      }
      for (std::uint32_t k = 0; k < j; ++k) {
        Mat3 B;
        B << s.n(i), s.n(j), s.n(k);
        if (std::abs(B.determinant()) > 1e-9) {
          const Vec3 e = B.transpose().inverse() * Vec3(s.slack(i, x), s.slack(j, x), s.slack(k, x));
          offer(e, (B.inverse() * e).norm());
        }
      }
    }
  }
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
  // With r_k = softness l_k >= 0 what is left of plane k, and L_k >= 0 the exact pushes: |e - exact|^2 =
  // sum((L_k - l_k) n_k).(exact - e) <= sum((L_k - l_k) r_k) <= softness |L|^2 / 4, whatever the planes.
  Random random(seedOf(3));
  int compared = 0;
  int close = 0;
  for (int i = 0; i < 3000; ++i) {
    Solid s;
    const int count = 1 + i % 6;
    while (static_cast<int>(s.count) < count) {
      const Vec3 n = random.vector(1) + Vec3(0, 0, 0.9);
      if (n.norm() > 0.3) s.add(n, random.in(-0.002, 0.002));
    }
    const Vec3 x = random.vector(0.004);
    const ExactWay exact = bruteWayOut(s, x);
    if (!exact.exists) continue;
    const Vec3 e = wayOut(s.plane, s.count, x) / (1 + kCornerSoftness);
    ASSERT_LE((e - exact.way).norm(), 0.5 * std::sqrt(kCornerSoftness) * exact.push + 1e-8) << "case " << i;
    ASSERT_LE(e.norm(), exact.way.norm() + 1e-8) << "case " << i;
    ++compared;
    if ((e - exact.way).norm() < 1e-3 * exact.way.norm() + 1e-8) ++close;
  }
  EXPECT_GT(compared, 1500);
  EXPECT_GT(close, compared * 98 / 100);
}

/** How far e is from the least cost of the header [m], to first order. */
double missBy(const Solid& s, const Vec3& x, const Vec3& e) {
  Vec3 gradient = kCornerSoftness * e;
  Mat3 hessian = kCornerSoftness * Mat3::Identity();
  for (std::uint32_t k = 0; k < s.count; ++k) {
    if (s.slack(k, x + e) <= 0) continue;
    gradient -= s.slack(k, x + e) * s.n(k);
    hessian += s.n(k) * s.n(k).transpose();
  }
  return hessian.llt().solve(gradient).norm();
}

TEST(WayOut, IsTheExactMinimum) {
  // Also where no outside is left, and in grooves so narrow that their planes nearly face each other.
  Random random(seedOf(4));
  for (int i = 0; i < 20000; ++i) {
    Solid s = randomSolid(random);
    if (i % 2 == 1) {
      const std::uint32_t count = s.count;
      s.count = 0;
      while (s.count < count) {
        s.add(Vec3(random.once(2) ? 1 : -1, 0, 0) + random.vector(0.02), random.in(-0.002, 0.002));
      }
    }
    const Vec3 x = random.vector(0.01);
    ASSERT_LT(missBy(s, x, wayOut(s.plane, s.count, x) / (1 + kCornerSoftness)), 1e-9) << "case " << i;
  }
}

TEST(WayOut, NeverMovesFurtherThanTheTool) {
  Random random(seedOf(5));
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
