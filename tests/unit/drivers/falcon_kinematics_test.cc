#include "drivers/falcon/falcon_kinematics.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/seeds.h"

namespace hapticd::falcon {
namespace {

/** Places in the workspace, the same each time. */
std::vector<Vec3> places(int count) {
  std::mt19937 random(seedOf(11));
  std::uniform_real_distribution<double> across(-0.04, 0.04), out(0.09, 0.165);
  std::vector<Vec3> all;
  while (static_cast<int>(all.size()) < count) {
    const Vec3 p(across(random), across(random), out(random));
    if (legsAt(p)) all.push_back(p);
  }
  return all;
}

Vec3 anglesAt(const Vec3& p) {
  const auto legs = legsAt(p);
  return {(*legs)[0].t1, (*legs)[1].t1, (*legs)[2].t1};
}

// The three equations of a leg in Stamper's thesis, with sizes written out anew.
TEST(FalconKinematics, LegsCloseTheirLoops) {
  const double azimuth[] = {105, -15, -135};
  for (const Vec3& p : places(500)) {
    const auto legs = *legsAt(p);
    for (int i = 0; i < 3; ++i) {
      const Leg& leg = legs[static_cast<std::size_t>(i)];
      const double phi = azimuth[i] * M_PI / 180;
      const double u = p.x() * std::cos(phi) + p.y() * std::sin(phi) - 0.0400;
      const double v = -p.x() * std::sin(phi) + p.y() * std::cos(phi) + 0.02309;
      const double r = 2 * 0.01125 + 0.1025 * std::sin(leg.t3);
      EXPECT_NEAR(u, 0.060 * std::cos(leg.t1) - 0.01443 + r * std::cos(leg.t2), 1e-12);
      EXPECT_NEAR(v, 0.1025 * std::cos(leg.t3) + 0.025, 1e-12);
      EXPECT_NEAR(p.z(), 0.060 * std::sin(leg.t1) + r * std::sin(leg.t2), 1e-12);
    }
  }
}

// Counts and heights on the axis, worked out independently.
TEST(FalconKinematics, OnTheAxisHeightsGoWithCounts) {
  struct Row {
    double counts, z;
  };
  for (const Row& row : {Row{-900, .0935}, Row{-600, .1062}, Row{-300, .1202}, Row{0, .1346}, Row{300, .1484},
                         Row{600, .1608}, Row{900, .1708}, Row{1200, .1781}}) {
    const auto grip = gripAt(Vec3::Constant(armAngle(row.counts)), kMiddle);
    ASSERT_TRUE(grip.has_value()) << row.counts;
    EXPECT_NEAR(grip->p.z(), row.z, 6e-5);
    EXPECT_LT(grip->p.head<2>().norm(), 1e-9) << "by symmetry";
  }
}

// libnifalcon stops when the angles fit to 0.01 rad, which is 0.65 mm, and keeps them as float.
TEST(FalconKinematics, FindsThePlaceOfAnyAnglesExactly) {
  Vec3 guess = kMiddle;
  for (const Vec3& p : places(3000)) {
    const auto cold = gripAt(anglesAt(p), kMiddle);
    ASSERT_TRUE(cold.has_value()) << p.transpose();
    EXPECT_LT((cold->p - p).norm(), 1e-10);
    const auto warm = gripAt(anglesAt(p), guess);
    ASSERT_TRUE(warm.has_value()) << p.transpose() << " from " << guess.transpose();
    EXPECT_LT((warm->p - p).norm(), 1e-10);
    guess = p;
  }
}

// After a pause in the exchange the last place may be anywhere; these are near an edge, from which full steps fail.
TEST(FalconKinematics, FindsThePlaceFromACornerToo) {
  const std::pair<Vec3, Vec3> ways[] = {
      {{-0.038311493114793684, -0.038521771580446555, 0.16424829108574554}, {0.0207548, 0.0053764, 0.1308298}},
      {{-0.037941223775460442, -0.038242509925757597, 0.16440561613316865}, {-0.0158394, 0.0169696, 0.1145142}},
      {{-0.039700339484190439, -0.039021545850588507, 0.16333839733943215}, {-0.0399193, -0.0286480, 0.1001414}}};
  for (const auto& [from, to] : ways) {
    const auto grip = gripAt(anglesAt(to), from);
    ASSERT_TRUE(grip.has_value()) << to.transpose();
    EXPECT_LT((grip->p - to).norm(), 1e-10);
  }
  // Out to 5 cm one in 100 000 is missed; of full steps alone one in 1000 was.
  std::mt19937 random(seedOf(23));
  std::uniform_real_distribution<double> across(-0.05, 0.05), out(0.08, 0.17);
  Vec3 guess = kMiddle;
  int tried = 0, missed = 0;
  while (tried < 10000) {
    const Vec3 p(across(random), across(random), out(random));
    if (!legsAt(p)) continue;
    ++tried;
    missed += gripAt(anglesAt(p), guess) ? 0 : 1;
    guess = p;
  }
  EXPECT_LE(missed, 2);
}

// libnifalcon's last column has sin^2 t2 for sin t2 sin t3, and is off by up to a quarter.
TEST(FalconKinematics, TheJacobianIsTheDerivative) {
  constexpr double kStep = 1e-6;
  for (const Vec3& p : places(500)) {
    const Mat3 exact = jacobian(*legsAt(p));
    Mat3 numeric;
    for (int axis = 0; axis < 3; ++axis) {
      // Of fourth order: where an arm is nearly stretched its angle goes like a square root.
      const Vec3 step = kStep * Vec3::Unit(axis);
      const Vec3 near = anglesAt(p + step) - anglesAt(p - step);
      const Vec3 wide = anglesAt(p + 2 * step) - anglesAt(p - 2 * step);
      numeric.col(axis) = (8 * near - wide) / (12 * kStep);
    }
    EXPECT_LT((exact - numeric).norm(), 1e-7 * numeric.norm()) << p.transpose();
  }
}

TEST(FalconKinematics, TorquesDoTheWorkOfTheForce) {
  std::mt19937 random(seedOf(3));
  std::normal_distribution<double> normal;
  for (const Vec3& p : places(200)) {
    const Vec3 force(normal(random), normal(random), normal(random));
    const Vec3 move = 1e-7 * Vec3(normal(random), normal(random), normal(random));
    const auto torques = torquesFor(jacobian(*legsAt(p)), force);
    ASSERT_TRUE(torques.has_value());
    const double work = torques->dot(anglesAt(p + move / 2) - anglesAt(p - move / 2));
    EXPECT_NEAR(work, force.dot(move), 1e-5 * force.norm() * move.norm());
  }
}

// libnifalcon compares with 30 N m, which no motor of it has: nothing is ever limited.
TEST(FalconKinematics, TorquesAreLimitedTogether) {
  Vec3 torques(100, -8190, 4000);
  EXPECT_TRUE(limitTogether(torques, 4095));
  EXPECT_LT((torques - Vec3(50, -4095, 2000)).norm(), 1e-9);
  EXPECT_FALSE(limitTogether(torques, 4095));
}

TEST(FalconKinematics, WhatCannotBeIsNowhere) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(gripAt({nan, 0.6, 0.6}, kMiddle));
  EXPECT_FALSE(gripAt({0.6, 0.6, 0.6}, {0, nan, 0.1}));
  EXPECT_FALSE(gripAt(Vec3(armAngle(6000), armAngle(0), armAngle(0)), kMiddle));
  EXPECT_FALSE(legsAt({0.2, 0, 0.12}));
  EXPECT_FALSE(legsAt({0, 0, 0.3}));
  EXPECT_FALSE(legsAt({nan, 0, 0.12}));
  EXPECT_FALSE(torquesFor(Mat3::Zero(), Vec3::UnitX()));
  EXPECT_FALSE(torquesFor(Mat3::Identity() * 100, Vec3(nan, 0, 0)));
}

// Any sixteen-bit counts whatever: an answer or none, always in bounded steps and never a wrong place.
TEST(FalconKinematics, AnyCountsWhatever) {
  std::mt19937 random(seedOf(17));
  int found = 0;
  for (int i = 0; i < 3000; ++i) {
    Vec3 t1;
    for (int axis = 0; axis < 3; ++axis) {
      const auto counts = static_cast<std::int16_t>(random());
      t1[axis] = armAngle(i % 2 == 0 ? counts : counts / 16);
    }
    const auto grip = gripAt(t1, kMiddle);
    if (!grip) continue;
    ++found;
    EXPECT_LT((anglesAt(grip->p) - t1).norm(), 1e-10 * grip->dt1_dp.norm() + 1e-12);  // to 1e-10 m
  }
  EXPECT_GT(found, 100);
}

}  // namespace
}  // namespace hapticd::falcon
