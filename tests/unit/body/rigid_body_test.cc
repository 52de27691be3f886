#include "rt/body/rigid_body.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

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
  EXPECT_GT(body.kineticEnergy(), (1 - 1e-10) * start);
  EXPECT_LT((body.angularMomentum() - momentum).norm(), 1e-10 * momentum.norm());
}

/** About each axis, the one in the middle too, as fast as bodies may be: a minute takes nothing of the motion. */
TEST(RigidBody, KeepsMomentumAndEnergyForAMinuteAtEverySpeed) {
  for (const double speed : {1.0, 20.0, 60.0, 150.0, 390.0}) {
    for (const Vec3& about : {Vec3(1, 0.01, 0), Vec3(0.01, 1, 0), Vec3(0, 0.01, 1), Vec3(0.5, 0.6, 0.6)}) {
      RigidBody body(MassProperties::ofBox(0.2, {0.06, 0.04, 0.02}));
      body.place(Pose{});
      body.setTwist({Vec3::Zero(), speed * about});
      const double energy = body.kineticEnergy();
      const Vec3 momentum = body.angularMomentum();
      for (int i = 0; i < 60000; ++i) body.drift(1e-3);
      EXPECT_LE(body.kineticEnergy(), energy * (1 + 1e-9)) << speed;
      EXPECT_GT(body.kineticEnergy(), energy * (1 - 1e-9)) << speed;
      EXPECT_LT((body.angularMomentum() - momentum).norm(), 1e-9 * momentum.norm()) << speed;
    }
  }
}

/** Dzhanibekov: how often a body turns over that spins about its middle axis is a complete elliptic integral. */
TEST(RigidBody, TurnsOverAsOftenAsTheClosedForm) {
  const MassProperties brick = MassProperties::ofBox(0.2, {0.06, 0.04, 0.02});
  const Vec3 moments = brick.inertia_O.diagonal();  // least about x, greatest about z
  RigidBody body(brick);
  body.place(Pose{});
  const Vec3 start(0.2, 20, 0);
  body.setTwist({Vec3::Zero(), start});
  const double twice_energy = 2 * body.kineticEnergy();
  const double squared = body.angularMomentum().squaredNorm();
  // Landau and Lifshitz, Mechanics, section 37: L^2 > 2 E I2 or not says about which axis it goes round.
  double i1 = moments.x(), i3 = moments.z();
  if (squared < twice_energy * moments.y()) std::swap(i1, i3);
  const double i2 = moments.y();
  const double k2 = (i2 - i1) * (twice_energy * i3 - squared) / ((i3 - i2) * (squared - twice_energy * i1));
  const double rate = std::sqrt((i3 - i2) * (squared - twice_energy * i1) / (i1 * i2 * i3));
  const double period = 4 * std::comp_ellint_1(std::sqrt(k2)) / rate;
  std::vector<double> crossed;
  double before = start.y();
  for (int i = 1; i <= 60000; ++i) {
    body.drift(1e-3);
    const double now = (body.orientation().conjugate() * body.twist().w).y();
    if (before < 0 && now >= 0) crossed.push_back((i - now / (now - before)) * 1e-3);
    before = now;
  }
  ASSERT_GT(crossed.size(), 5U);
  EXPECT_NEAR((crossed.back() - crossed.front()) / static_cast<double>(crossed.size() - 1), period, 1e-3 * period);
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
    EXPECT_NEAR(w_O.z(), 6, 1e-6);
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

/** Of a solid within a box of that half length along each axis, about its middle, of 100^3 cells. */
template <class Inside>
Mat3 counted(const Inside& inside, double mass, const Vec3& half) {
  constexpr int kCells = 100;
  const auto at = [](int i) { return (2 * i + 1.0) / kCells - 1; };
  Mat3 sum = Mat3::Zero();
  int count = 0;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      for (int k = 0; k < kCells; ++k) {
        const Vec3 x = half.cwiseProduct(Vec3(at(i), at(j), at(k)));
        if (!inside(x)) continue;
        sum += x.squaredNorm() * Mat3::Identity() - x * x.transpose();
        ++count;
      }
    }
  }
  return sum * (mass / count);
}

TEST(MassProperties, OfACylinderAndACapsuleAreThoseOfTheSolid) {
  for (const auto& [r, l] : {std::pair{0.02, 0.05}, {0.03, 0.004}}) {
    const auto round = [r = r](const Vec3& x) { return x.head<2>().squaredNorm() < r * r; };
    const MassProperties cylinder = MassProperties::ofCylinder(0.3, r, l),
                         capsule = MassProperties::ofCapsule(0.3, r, l);
    const Mat3 I = counted(round, 0.3, Vec3(r, r, l));
    EXPECT_TRUE(cylinder.inertia_O.isApprox(I, 4e-3)) << cylinder.inertia_O << "\n\n" << I;
    const auto capped = [r = r, l = l](const Vec3& x) {
      return (x - Vec3(0, 0, std::clamp(x.z(), -l, l))).squaredNorm() < r * r;
    };
    const Mat3 J = counted(capped, 0.3, Vec3(r, r, l + r));
    EXPECT_TRUE(capsule.inertia_O.isApprox(J, 4e-3)) << capsule.inertia_O << "\n\n" << J;
    EXPECT_EQ(cylinder.mass, 0.3);
    EXPECT_EQ(capsule.mass, 0.3);
    EXPECT_TRUE(cylinder.valid() && capsule.valid());
  }
  EXPECT_TRUE(MassProperties::ofCapsule(0.3, 0.02, 0).inertia_O.isApprox(MassProperties::ofBall(0.3, 0.02).inertia_O));
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
