/** @file
 * The nearest point of few half-spaces, by the conditions of Karush, Kuhn and Tucker, which need no search.
 */
#include "rt/geometry/half_spaces.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "tests/support/seeds.h"

namespace hapticd {
namespace {

class HalfSpaces : public ::testing::TestWithParam<int> {
 protected:
  double uniform() { return random_() * 0x1p-31 - 1; }
  Vec3 inCube() {
    const double x = uniform(), y = uniform(), z = uniform();
    return {x, y, z};
  }
  std::mt19937 random_{seedOf(static_cast<std::uint32_t>(GetParam()))};
};

/** How much of each of up to three independent normals is in `way`: what is not theirs lies in what completes them. */
Eigen::VectorXd amounts(const Eigen::Matrix3Xd& normals, const Vec3& way) {
  Eigen::Matrix3d basis;
  basis.leftCols(normals.cols()) = normals;
  if (normals.cols() == 1) basis.col(1) = normals.col(0).unitOrthogonal();
  if (normals.cols() < 3) basis.col(2) = basis.col(0).cross(basis.col(1));
  return (basis.inverse() * way).head(normals.cols());
}

/** The way to the nearest point is a sum of the active planes' normals, none of them taken away. */
TEST_P(HalfSpaces, NearestPointIsInsideAndPushedByItsPlanesAlone) {
  const int count = GetParam();
  int by_size[4] = {};
  for (int i = 0; i < 4000; ++i) {
    HalfSpace planes[kMaxHalfSpaces];
    for (int k = 0; k < count; ++k) planes[k] = {inCube().normalized(), 0.5 * uniform()};
    const Vec3 from = 2 * inCube();
    Vec3 x = from;
    std::uint32_t active = 0;
    if (!nearestInside(planes, count, 1e-12, x, active)) {
      EXPECT_EQ(x, from);
      for (int k = 0; k < 50; ++k) {
        const Vec3 y = 5 * inCube();
        bool inside = true;
        for (int j = 0; j < count; ++j) inside = inside && planes[j].height(y) > 0;
        EXPECT_FALSE(inside) << "there is one";
      }
      continue;
    }
    Eigen::Matrix3Xd normals(3, 0);
    for (int k = 0; k < count; ++k) {
      EXPECT_GE(planes[k].height(x), -1e-11);
      if (!(active >> k & 1u)) continue;
      EXPECT_NEAR(planes[k].height(x), 0, 1e-11);
      normals.conservativeResize(3, normals.cols() + 1);
      normals.col(normals.cols() - 1) = planes[k].normal;
    }
    ASSERT_LE(normals.cols(), 3);
    ++by_size[normals.cols()];
    if (active == 0) {
      EXPECT_EQ(x, from);
      continue;
    }
    const Eigen::VectorXd push = amounts(normals, x - from);
    const double size = 1 + push.cwiseAbs().maxCoeff();
    EXPECT_LT((normals * push - (x - from)).norm(), 1e-9 * size);
    EXPECT_GE(push.minCoeff(), -1e-9 * size);
  }
  for (int size = 0; size <= std::min(count, 3); ++size) EXPECT_GT(by_size[size], 20) << size;
}

INSTANTIATE_TEST_SUITE_P(UpToFour, HalfSpaces, ::testing::Values(1, 2, 3, 4));

}  // namespace
}  // namespace hapticd
