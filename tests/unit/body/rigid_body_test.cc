#include "rt/body/rigid_body.h"

#include <gtest/gtest.h>

#include "rt/base/rotation.h"

namespace hapticd {
namespace {

MassProperties brick() {
  MassProperties out = MassProperties::ofBox(0.3, {0.01, 0.04, 0.1});
  const Mat3 R = fromRotationVector({0.3, -0.5, 0.8}).toRotationMatrix();  // its frame is not its principal one
  out.inertia_O = R * out.inertia_O * R.transpose();
  out.com_O = Vec3(0.01, -0.02, 0.03);
  return out;
}

RigidBody tumbling() {
  RigidBody body(brick());
  body.place({{0.1, 0.2, 0.3}, fromRotationVector({1, 2, -1})});
  body.setTwist({{0.5, -0.2, 0.1}, {3, 20, -8}});
  return body;
}

TEST(RigidBody, InertiaIsTheOneGivenTurned) {
  const RigidBody body = tumbling();
  const Mat3 R = body.orientation().toRotationMatrix();
  EXPECT_LT((body.inertia() - R * brick().inertia_O * R.transpose()).cwiseAbs().maxCoeff(), 1e-18);
  EXPECT_LT((body.pose() * brick().com_O - body.com()).norm(), 1e-15);
  const Vec3 w = body.twist().w;
  EXPECT_NEAR(body.kineticEnergy(), 0.5 * (0.3 * body.twist().v.squaredNorm() + w.dot(body.inertia() * w)), 1e-15);
}

TEST(RigidBody, TumblesWithItsAngularMomentumAndNoMoreEnergy) {
  RigidBody body = tumbling();
  const double start = body.kineticEnergy();
  const Vec3 momentum = body.angularMomentum();
  for (int i = 0; i < 20000; ++i) {
    const double before = body.kineticEnergy();
    body.drift(1e-3);
    ASSERT_LE(body.kineticEnergy(), before * (1 + 1e-14));
  }
  // What the clamp takes over twenty seconds of 20 rad/s is what the method's bounded error swings through.
  EXPECT_GT(body.kineticEnergy(), 0.99 * start);
  EXPECT_LT((body.angularMomentum().normalized() - momentum.normalized()).norm(), 1e-10);
}

TEST(RigidBody, SymmetricTopPrecessesAsTheClosedForm) {
  // Free symmetric top: in the body w turns about the axis of symmetry at (I3 - I1) / I1 w3.
  MassProperties top;
  top.inertia_O = Vec3(2e-4, 2e-4, 3e-4).asDiagonal();
  for (const double dt : {1e-3, 2.5e-4}) {
    RigidBody body(top);
    body.place(Pose{});
    body.setTwist({Vec3::Zero(), {1, 0, 6}});
    const int steps = static_cast<int>(1 / dt + 0.5);
    for (int i = 0; i < steps; ++i) body.drift(dt);
    const Vec3 w_O = body.orientation().conjugate() * body.twist().w;
    const double angle = 0.5 * 6;
    EXPECT_NEAR(w_O.x(), std::cos(angle), 30 * dt * dt * 36);
    EXPECT_NEAR(w_O.y(), std::sin(angle), 30 * dt * dt * 36);
    EXPECT_NEAR(w_O.z(), 6, 1e-6);  // the clamp takes some of the bounded swing
  }
}

TEST(RigidBody, ErrorFallsWithTheSquareOfTheStep) {
  const auto after = [](double dt) {
    RigidBody body = tumbling();
    const int steps = static_cast<int>(0.2 / dt + 0.5);
    for (int i = 0; i < steps; ++i) body.drift(dt);
    return body.orientation();
  };
  const Quat truth = after(1e-5);
  const double coarse = truth.angularDistance(after(2e-3));
  const double fine = truth.angularDistance(after(1e-3));
  EXPECT_GT(coarse / fine, 3.3);
  EXPECT_LT(coarse / fine, 4.8);
}

TEST(MassProperties, ImpossibleOnesAreTold) {
  EXPECT_TRUE(brick().valid());
  MassProperties bad = brick();
  bad.mass = 0;
  EXPECT_FALSE(bad.valid());
  bad = brick();
  bad.inertia_O = Vec3(1, 1, 3).asDiagonal();
  EXPECT_FALSE(bad.valid()) << "no body has a moment above the sum of the others";
  bad = brick();
  bad.inertia_O(0, 1) += 1e-3;
  EXPECT_FALSE(bad.valid());
}

}  // namespace
}  // namespace hapticd
