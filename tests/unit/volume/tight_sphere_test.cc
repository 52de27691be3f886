// The tight spheres of the octree's nodes against every ball through two, three or four corners.
#include "rt/volume/tight_sphere.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <vector>

namespace hapticd {
namespace {

struct Ball {
  Vec3 center;
  double squared;
};

/** The smallest ball through all the points, in the flat that they span; none if they are dependent. */
std::optional<Ball> through(const std::vector<Vec3>& p) {
  const auto n = static_cast<Eigen::Index>(p.size()) - 1;
  Eigen::MatrixXd edges(3, n);
  for (Eigen::Index i = 0; i < n; ++i) edges.col(i) = p[static_cast<std::size_t>(i) + 1] - p[0];
  const Eigen::MatrixXd gram = edges.transpose() * edges;
  Eigen::MatrixXd inverse;
  bool invertible = false;
  if (n == 1) {
    invertible = gram(0, 0) > 0;
    inverse = gram.cwiseInverse();
  } else if (n == 2) {
    Eigen::Matrix2d out;
    Eigen::Matrix2d(gram).computeInverseWithCheck(out, invertible, 1e-9);
    inverse = out;
  } else {
    Mat3 out;
    Mat3(gram).computeInverseWithCheck(out, invertible, 1e-9);
    inverse = out;
  }
  if (!invertible) return {};
  const Vec3 to_center = edges * (inverse * (0.5 * gram.diagonal()));
  return Ball{p[0] + to_center, to_center.squaredNorm()};
}

/** The corners of the occupied children that are no others' mean: all that a ball must hold. */
std::vector<Vec3> cornersOf(unsigned mask) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 27; ++i) {
    const Vec3 x(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    bool used = false;
    for (unsigned child = 0; child < 8; ++child) {
      bool of = (mask >> child & 1) != 0;
      for (unsigned k = 0; k < 3; ++k) of &= x[k] == 0 || (x[k] > 0) == ((child >> k & 1) != 0);
      used |= of;
    }
    if (used) corners.push_back(x);
  }
  return corners;
}

double leastBall(unsigned mask) {
  const std::vector<Vec3> p = cornersOf(mask);
  double least = 3;
  const auto offer = [&](const std::vector<Vec3>& on) {
    const auto ball = through(on);
    if (!ball || ball->squared >= least) return;
    for (const Vec3& x : p)
      if ((x - ball->center).squaredNorm() > ball->squared + 1e-9) return;
    least = ball->squared;
  };
  for (std::size_t a = 0; a < p.size(); ++a)
    for (std::size_t b = a + 1; b < p.size(); ++b) {
      offer({p[a], p[b]});
      for (std::size_t c = b + 1; c < p.size(); ++c) {
        offer({p[a], p[b], p[c]});
        // Four points decide a ball only if no three do; masks with a ball of radius sqrt(3) need not look.
        if (least < 3) continue;
        for (std::size_t d = c + 1; d < p.size() && mask < 32; ++d) offer({p[a], p[b], p[c], p[d]});
      }
    }
  return least;
}

TEST(TightSphere, isTheLeastBallOfEachMask) {
  for (unsigned mask = 1; mask < 256; ++mask) {
    const TightSphere& sphere = tightSphere(static_cast<std::uint8_t>(mask));
    EXPECT_NEAR(sphere.radius * sphere.radius, leastBall(mask), 1e-6) << "mask " << mask;
    for (const Vec3& x : cornersOf(mask))
      EXPECT_LE((x - Vec3(sphere.center[0], sphere.center[1], sphere.center[2])).norm(), sphere.radius + 1e-6);
  }
}

TEST(TightSphere, has78MasksBelowTheFullSphereInFourClasses) {
  std::map<int, int> classes;  // r^2 in twelfths
  for (unsigned mask = 1; mask < 256; ++mask) {
    const double radius = tightSphere(static_cast<std::uint8_t>(mask)).radius;
    ++classes[static_cast<int>(std::lround(12 * radius * radius))];
  }
  const std::map<int, int> expected{{9, 8}, {18, 12}, {27, 42}, {32, 16}, {36, 177}};
  EXPECT_EQ(classes, expected);
}

}  // namespace
}  // namespace hapticd
