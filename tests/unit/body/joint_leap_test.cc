// All touches solved at once, against the same equations written out.
#include "rt/body/joint_leap.h"

#include <gtest/gtest.h>

#include <memory>

namespace hapticd {
namespace {

constexpr double kDt = 1e-3;

/** Straight below the middle of A, which stands on B or on the floor. */
Touch below(double friction) {
  Touch touch;
  touch.n = Vec3::UnitZ();
  touch.r_a = {0, 0, -0.02};
  touch.r_b = {0, 0, 0.02};
  touch.friction = friction;
  return touch;
}

TEST(JointLeap, HandsAWholeLoadDownAPile) {
  // A on B on the floor, both falling at 1 m/s. With K of both touches and e = K_ii / 100: (K + e) d = b.
  const double light = 0.01, heavy = 10;
  const Mobility a = Mobility::free(heavy, 1e-3 * Mat3::Identity()), b = Mobility::free(light, 1e-6 * Mat3::Identity());
  const std::array<Touch, 2> touch{below(0.5), below(0.5)};
  std::array<ConstraintRow, 2> row;
  prepareRow(a, b, touch[0], kDt, row[0]);
  prepareRow(b, Mobility{}, touch[1], kDt, row[1]);
  const std::array<Vec3, 2> lacks{Vec3::Zero(), Vec3::UnitX()};
  std::array<Vec3, 2> lambda{Vec3(1e-9, 0, 0), Vec3(1e-9, 0, 0)};

  auto leap = std::make_unique<JointLeap>();
  leap->setMover(0, a);
  leap->setMover(1, b);
  leap->setTouch(0, touch[0], row[0], 0, 1);
  leap->setTouch(1, touch[1], row[1], 1, JointLeap::kMovers);
  leap->solve(2, touch, row, lacks, lambda);

  Eigen::Matrix2d K;
  K << 1 / light + 1 / heavy, -1 / light, -1 / light, 1 / light;
  K.diagonal() *= 1 + JointLeap::kSoft;
  const Eigen::Vector2d d = K.inverse() * Eigen::Vector2d(0, 1);
  EXPECT_NEAR(lambda[0][0], d[0], 1e-6 * d[0]);
  EXPECT_NEAR(lambda[1][0], d[1], 1e-6 * d[1]);
  EXPECT_GT(lambda[0][0], 30 * light) << "a sweep hands on the light one's share";
}

TEST(JointLeap, ChangesNothingWhereItHasNoAnswer) {
  Mobility rail;  // Moves up and down alone: nothing to find across.
  rail.vp(2, 2) = 1;
  const Touch touch = below(0.5);
  ConstraintRow row;
  prepareRow(rail, Mobility{}, touch, kDt, row);
  Vec3 lambda(0.1, 0, 0);
  const Vec3 lacks(1, 0, 0);
  auto leap = std::make_unique<JointLeap>();
  leap->setMover(0, rail);
  leap->setTouch(0, touch, row, 0, JointLeap::kMovers);
  leap->solve(1, {&touch, 1}, {&row, 1}, {&lacks, 1}, {&lambda, 1});
  EXPECT_EQ(lambda, Vec3(0.1, 0, 0));
}

}  // namespace
}  // namespace hapticd
