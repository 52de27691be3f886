// The moving parts: stops and rotation.
#include "drivers/sim/body.h"

#include <gtest/gtest.h>

namespace hapticd {
namespace {

constexpr double kStep_s = 62.5e-6;

Stops box(double half, double stiffness, double damping) {
  return {Vec3::Constant(-half), Vec3::Constant(half), stiffness, damping};
}

TEST(PointBody, StopsWithoutDampingNeitherHoldNorFeedTheBall) {
  PointBody body({0.2}, box(0.05, 5000, 0), kStep_s);
  body.place(Vec3(0, 0.01, 0), Vec3(0.3, -0.5, 0.2));
  const double start = 0.5 * 0.2 * body.velocity().squaredNorm();
  double reach = 0;
  for (int i = 0; i < 160000; ++i) {
    body.step(Vec3::Zero(), Vec3::Zero(), Vec3::Zero());
    reach = std::max(reach, body.position().cwiseAbs().maxCoeff());
  }
  EXPECT_GT(reach, 0.05);
  // 1/2 k d^2 = 1/2 m v^2 bounds the depth of the fastest axis.
  EXPECT_LT(reach, 0.05 + 0.5 * std::sqrt(0.2 / 5000) * 1.05);
  double energy = 0.5 * 0.2 * body.velocity().squaredNorm();
  for (int i = 0; i < 3; ++i) {
    const double depth = std::max(0.0, std::abs(body.position()[i]) - 0.05);
    energy += 0.5 * 5000 * depth * depth;
  }
  EXPECT_LE(energy, start * 1.0001);
  EXPECT_GE(energy, start * 0.7) << "ten seconds of bouncing lose little to the integration";
}

TEST(PointBody, StopsHoldAConstantPushAtForceOverStiffness) {
  PointBody body({0.2, 1.0}, box(0.05, 5000, 20), kStep_s);
  for (int i = 0; i < 80000; ++i) body.step(Vec3(0, 0, -4), Vec3::Zero(), Vec3::Zero());
  // The linearly implicit stop is softer by its scale: 1 + h/m (c + k h / 2).
  const double scale = 1 + kStep_s / 0.2 * (20 + 5000 * kStep_s / 2);
  EXPECT_NEAR(body.position().z(), -0.05 - 4.0 / 5000 * scale, 1e-9);
}

/** What leaves it faster than its damper lets the spring follow flies on as it did. */
TEST(PointBody, AStopNeverPulls) {
  for (const double side : {-1.0, 1.0}) {
    PointBody body({0.2}, box(0.05, 100, 50), kStep_s);
    const Vec3 v(0, -side, 0);
    body.place(Vec3(0, side * 0.0505, 0), v);
    body.step(Vec3::Zero(), Vec3::Zero(), Vec3::Zero());
    EXPECT_LT((body.velocity() - v).norm(), 1e-14) << side;
  }
}

TEST(PointBody, TheHandTakesItAlongAsFastAsItAims) {
  PointBody body({0.2, 2, 0, 0, 6}, Stops{}, kStep_s);
  const Vec3 aims(0.3, -0.1, 0.2);
  for (int i = 0; i < 16000; ++i) body.step(Vec3::Zero(), Vec3::Zero(), aims);
  EXPECT_LT((body.velocity() - 6.0 / 8 * aims).norm(), 1e-9);
  RotatingBody wrist({2e-4, 2e-3, 0, 0, 6e-3}, kStep_s);
  for (int i = 0; i < 16000; ++i) wrist.step(Vec3::Zero(), Quat::Identity(), aims);
  EXPECT_LT((wrist.velocity() - 6.0 / 8 * aims).norm(), 1e-9);
}

TEST(PointBody, TheHardestStopOfALightBodyIsStable) {
  PointBody body({0.005}, box(0.01, 100000, 1000), kStep_s);
  body.place(Vec3::Zero(), Vec3(5, 5, -5));
  for (int i = 0; i < 16000; ++i) {
    body.step(Vec3::Zero(), Vec3::Zero(), Vec3::Zero());
    ASSERT_LT(body.position().cwiseAbs().maxCoeff(), 0.012);
    ASSERT_LE(body.velocity().cwiseAbs().maxCoeff(), 5.0);
  }
}

TEST(PointBody, TheHandGivesWayByForceOverStiffness) {
  PointBody body({0.35, 0.5, 0, 400, 6}, Stops{}, kStep_s);
  const Vec3 goal(0.01, -0.02, 0.03), force(0.5, 1, -2);
  for (int i = 0; i < 80000; ++i) body.step(force, goal, Vec3::Zero());
  EXPECT_LT((body.position() - goal - force / 400).norm(), 1e-12);
}

TEST(RotatingBody, TwistAboutAFixedAxisIsTheClosedForm) {
  const double inertia = 4e-4, c = 1e-3, k = 1.5, angle0 = 0.8;
  RotatingBody body({inertia, c, 0, k, 0}, kStep_s);
  const Vec3 axis = Vec3(1, 2, -2) / 3;
  const Quat goal = fromRotationVector(Vec3(0.3, -0.2, 0.9));
  body.place(fromRotationVector(axis * angle0) * goal, Vec3::Zero());
  const double decay = c / (2 * inertia), rate = std::sqrt(k / inertia - decay * decay);
  for (int i = 1; i <= 4000; ++i) {
    body.step(Vec3::Zero(), goal, Vec3::Zero());
    const double t = i * kStep_s;
    const double angle = angle0 * std::exp(-decay * t) * (std::cos(rate * t) + decay / rate * std::sin(rate * t));
    ASSERT_LT((rotationVector(body.orientation() * goal.conjugate()) - axis * angle).norm(), 1e-10) << i;
  }
}

TEST(RotatingBody, FreeRotationKeepsAxisAndRate) {
  RotatingBody body({2e-4}, kStep_s);
  const Vec3 w(3, -1, 2);
  const Quat start = fromRotationVector(Vec3(0.1, 0.7, -0.4));
  body.place(start, w);
  for (int i = 0; i < 16000; ++i) body.step(Vec3::Zero(), Quat::Identity(), Vec3::Zero());
  EXPECT_LT((body.velocity() - w).norm(), 1e-12);
  EXPECT_LT(body.orientation().angularDistance(rotated(start, w, 1.0)), 1e-9);
}

TEST(RotatingBody, GeneralMotionConvergesWithTheStep) {
  // No closed form: halving the step must quarter the error (second order).
  const auto run = [](int per_step) {
    RotatingBody body({4e-4, 1e-3, 0, 1.5, 0}, 1e-3 / per_step);
    body.place(fromRotationVector(Vec3(0.9, 0, 0)), Vec3(0, 20, 5));
    for (int i = 0; i < 40 * per_step; ++i) body.step(Vec3(0, 0, 0.01), Quat::Identity(), Vec3::Zero());
    return body.orientation();
  };
  const Quat reference = run(1024);
  const double coarse = run(8).angularDistance(reference), fine = run(16).angularDistance(reference);
  EXPECT_LT(fine, 1e-3);
  EXPECT_GT(coarse / fine, 3.0);
  const double finer = run(64).angularDistance(reference), finest = run(128).angularDistance(reference);
  EXPECT_GT(finer / finest, 3.7) << "what is of first order, however little, shows here";
}

TEST(RotationVector, IsItsOwnInverse) {
  for (const double angle : {0.0, 1e-15, 1e-9, 1e-3, 1.0, 3.0, 3.14159}) {
    const Vec3 r = Vec3(2, -1, 2) / 3 * angle;
    EXPECT_LT((rotationVector(fromRotationVector(r)) - r).norm(), 1e-12) << angle;
    Quat other = fromRotationVector(r);
    other.coeffs() = -other.coeffs();
    EXPECT_LT((rotationVector(other) - r).norm(), 1e-12) << "both signs of a quaternion are one rotation, " << angle;
  }
}

}  // namespace
}  // namespace hapticd
