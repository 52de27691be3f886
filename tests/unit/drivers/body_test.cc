// The moving parts: stops and rotation.
#include "drivers/sim/body.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/support/random.h"
#include "tests/support/seeds.h"

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
  for (const auto& [stiffness, damping] : {std::array{5000.0, 20.0}, {5000.0, 1000.0}, {1e5, 0.0}, {1e5, 1000.0}}) {
    for (const double side : {-1.0, 1.0}) {
      PointBody body({0.02, 1.0}, box(0.05, stiffness, damping), kStep_s);
      for (int i = 0; i < 80000; ++i) body.step(Vec3(0, 0, 4 * side), Vec3::Zero(), Vec3::Zero());
      EXPECT_NEAR(std::abs(body.position().z()), 0.05 + 4 / stiffness, 1e-9) << stiffness << ' ' << damping;
    }
  }
}

/** With the hand on the other side: each bears its part. */
TEST(PointBody, StopAndHandHoldAPushTogether) {
  PointBody body({0.05, 0, 0, 500, 5}, box(0.05, 2000, 200), kStep_s);
  for (int i = 0; i < 80000; ++i) body.step(Vec3(40, 0, 0), Vec3(0.01, 0, 0), Vec3::Zero());
  EXPECT_NEAR(body.position().x(), (500 * 0.01 + 2000 * 0.05 + 40) / 2500, 1e-9);
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

/** Thrown at stops, with a hand that aims beyond them: no more energy is ever there than at the start. */
TEST(PointBody, StopsAndHandNeverFeedIt) {
  Random random(seedOf(1));
  for (int i = 0; i < 300; ++i) {
    const double m = std::pow(10, random.in(-2.3, 0)), k = std::pow(10, random.in(0, 3.3)), half = 0.02;
    const double stiff = std::pow(10, random.in(2, 5)), damping = random.once(3) ? 0 : std::pow(10, random.in(-1, 3));
    const double coulomb = random.once(2) ? 0 : random.in(0, 2);
    PointBody body({m, random.in(0, 3), coulomb, k, random.in(0, 20)}, box(half, stiff, damping), kStep_s);
    body.place(random.vector(half), random.vector(3));
    const Vec3 goal = random.vector(2 * half);
    const auto energy = [&] {
      double held = 0.5 * m * body.velocity().squaredNorm() + 0.5 * k * (body.position() - goal).squaredNorm();
      for (int axis = 0; axis < 3; ++axis)
        held += 0.5 * stiff * std::pow(std::max(0.0, std::abs(body.position()[axis]) - half), 2);
      return held;
    };
    const double start = energy();
    for (int step = 0; step < 2000; ++step) {
      body.step(Vec3::Zero(), goal, Vec3::Zero());
      ASSERT_LE(energy(), start * 1.01) << i << " at " << step << ": " << m << ' ' << k << ' ' << stiff << ' '
                                        << damping;
    }
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
