// WoodenHaptics and Polhem arms against closed forms of their own: interior angles of the linkage, numeric derivatives,
// potential energy.
#include "drivers/woodyhid/woody_kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/woodyhid/woodyhid_parameters.h"
#include "tests/support/seeds.h"

namespace hapticd {
namespace {

struct Poses : testing::TestWithParam<std::string_view> {
  const WoodyModel& model = *findWoodyModel(GetParam());
  std::mt19937 random{seedOf(7)};

  /** Angles that the real arm takes, some 17 degrees about the middle. */
  Vec3 angles() {
    std::uniform_real_distribution<double> about(-0.3, 0.3);
    const Vec3 middle = model.linkage == WoodyLinkage::kSerial ? Vec3(0, 0.6, 1.3) : Vec3(0.2, 1.3, 3.1);
    return middle + Vec3(about(random), about(random), about(random));
  }
};

/** Height of each link's centre times its weight, by trigonometry alone [J]. */
double potential(const WoodyModel& m, const Vec3& t) {
  const auto height = [](const LinkMass& g, double angle) {
    return g.along * std::sin(angle) + g.across * std::cos(angle);
  };
  double mgh = 0;
  if (m.linkage == WoodyLinkage::kSerial) {
    mgh += m.masses[0].mass * (m.La + m.masses[0].along * std::cos(t[1]));
    mgh += m.masses[1].mass * (m.La + m.Lb * std::cos(t[1]) - m.masses[1].along * std::cos(t[2]));
  } else {
    const double pitch = solveWoodyArm(m, t).pitch;
    const double elbow_r = m.bars.L0 / 2 + m.bars.L1 * std::cos(t[1]), elbow_z = m.bars.L1 * std::sin(t[1]);
    const double crank_r = -m.bars.L0 / 2 + m.bars.L2 * std::cos(t[2]), crank_z = m.bars.L2 * std::sin(t[2]);
    const double bar =
        std::atan2(elbow_z - m.bars.L4 * std::sin(pitch) - crank_z, elbow_r - m.bars.L4 * std::cos(pitch) - crank_r);
    mgh += m.masses[0].mass * height(m.masses[0], t[1]);
    mgh += m.masses[1].mass * height(m.masses[1], t[2]);
    mgh += m.masses[2].mass * (crank_z + height(m.masses[2], bar));
    mgh += m.masses[3].mass * (elbow_z + height(m.masses[3], pitch));
  }
  return 9.81 * mgh;
}

TEST_P(Poses, JacobianIsTheDerivativeOfThePlace) {
  constexpr double kStep = 1e-6;
  for (int n = 0; n < 200; ++n) {
    const Vec3 t = angles();
    const WoodyArm arm = solveWoodyArm(model, t);
    ASSERT_TRUE(arm.reachable) << t.transpose();
    for (int i = 0; i < 3; ++i) {
      const Vec3 step = kStep * Vec3::Unit(i);
      const Vec3 slope = (solveWoodyArm(model, t + step).p - solveWoodyArm(model, t - step).p) / (2 * kStep);
      ASSERT_NEAR((slope - arm.jacobian.col(i)).norm(), 0, 1e-8) << t.transpose() << " joint " << i;
    }
  }
}

TEST_P(Poses, CarryingTheLinksIsTheSlopeOfTheirPotentialEnergy) {
  constexpr double kStep = 1e-6;
  for (int n = 0; n < 200; ++n) {
    const Vec3 t = angles();
    const WoodyArm arm = solveWoodyArm(model, t);
    for (int i = 0; i < 3; ++i) {
      const Vec3 step = kStep * Vec3::Unit(i);
      const double slope = (potential(model, t + step) - potential(model, t - step)) / (2 * kStep);
      ASSERT_NEAR(arm.gravity_torque[i], slope, 1e-7) << t.transpose() << " joint " << i;
    }
    // As a force at the tip it does the same, and no more than the arm can weigh there.
    const Vec3 force = forceForTorque(arm, arm.gravity_torque, 100);
    ASSERT_NEAR((arm.jacobian.transpose() * force - arm.gravity_torque).norm(), 0, 1e-9);
    EXPECT_LE(forceForTorque(arm, arm.gravity_torque, 0.5).norm(), 0.5 + 1e-12);
  }
}

TEST_P(Poses, CurrentsDoTheWorkOfTheForce) {
  std::uniform_real_distribution<double> newton(-1.5, 1.5);
  for (int n = 0; n < 200; ++n) {
    const Vec3 t = angles();
    const WoodyArm arm = solveWoodyArm(model, t);
    const Vec3 force(newton(random), newton(random), newton(random));
    const WoodyCurrents out = woodyCurrents(model, arm, force, 30);
    EXPECT_FALSE(out.saturated);
    // Counts that the motors go on by while the tip moves a little with A, B and C: power in is power out.
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      std::array<std::int32_t, 6> one{};
      one[k] = 1;
      const double per_count = woodyAngles(model, one)[i];                // rad of the body
      const double motor = 2 * 3.14159265358979 / model.counts_per_turn;  // rad of the motor
      const double torque = out.mA[k] * 1e-3 * model.torque_constant[i] * motor / per_count;
      EXPECT_NEAR(torque, (arm.jacobian.transpose() * force)[i], 1.1e-3 * model.torque_constant[i] * 30);
    }
  }
}

TEST_P(Poses, SaturationKeepsTheDirection) {
  for (int n = 0; n < 100; ++n) {
    const WoodyArm arm = solveWoodyArm(model, angles());
    const Vec3 force(40, -25, 60);
    const WoodyCurrents free = woodyCurrents(model, arm, force * 0.01, 30);
    const WoodyCurrents cut = woodyCurrents(model, arm, force * 100, 3);
    EXPECT_TRUE(cut.saturated);
    const Vec3 a(free.mA[0], free.mA[1], free.mA[2]), b(cut.mA[0], cut.mA[1], cut.mA[2]);
    EXPECT_LE(b.cwiseAbs().maxCoeff(), 3000);
    EXPECT_GE(b.cwiseAbs().maxCoeff(), 2998);
    EXPECT_NEAR((a.normalized() - b.normalized()).norm(), 0, 3 / a.norm());
  }
}

TEST_P(Poses, NonsenseGivesNothing) {
  const double nan = std::nan("");
  const WoodyArm none = solveWoodyArm(model, Vec3(0, nan, 0));
  EXPECT_FALSE(none.reachable);
  EXPECT_EQ(woodyCurrents(model, none, Vec3(1, 1, 1), 3).mA, (std::array<std::int16_t, 3>{}));
  const WoodyArm arm = solveWoodyArm(model, angles());
  EXPECT_EQ(woodyCurrents(model, arm, Vec3(nan, 0, 0), 3).mA, (std::array<std::int16_t, 3>{}));
  EXPECT_TRUE(forceForTorque(WoodyArm{}, Vec3(1, 1, 1), 5).isZero(0));
}

std::vector<std::string_view> names() {
  std::vector<std::string_view> all;
  for (const WoodyModel& model : woodyModels()) all.push_back(model.name);
  return all;
}
TEST_P(Poses, EveryCornerOfTheWorkspaceIsReached) {
  const auto setup = resolveWoody({"woodyhid", std::string(model.name), {}});
  ASSERT_TRUE(setup.ok());
  const DeviceInfo& info = setup->info;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 wanted;
    for (int i = 0; i < 3; ++i) wanted[i] = (corner >> i & 1) != 0 ? info.workspace_upper[i] : info.workspace_lower[i];
    Vec3 at = model.linkage == WoodyLinkage::kSerial ? Vec3(0, 0.6, 1.3) : Vec3(0, 1.0, 2.7);
    WoodyArm arm = solveWoodyArm(model, at);
    for (int step = 0; step < 200 && arm.reachable && (wanted - arm.p).norm() > 1e-9; ++step) {
      at += clampNorm(arm.jacobian.fullPivLu().solve(wanted - arm.p), 0.2);
      arm = solveWoodyArm(model, at);
    }
    ASSERT_TRUE(arm.reachable);
    EXPECT_LT((wanted - arm.p).norm(), 1e-9) << "corner " << wanted.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Woody, Poses, testing::ValuesIn(names()),
                         [](const auto& each) { return std::string(each.param); });

TEST(WoodySerial, IsWhereTheDrawingSaysItIs) {
  const WoodyModel& m = *findWoodyModel("woodenhaptics_v2015");
  // B upright, C level: an upright L.
  const WoodyArm arm = solveWoodyArm(m, woodyAngles(m, {0, 0, 9000, 0, 0, 0}));  // 9000 counts: 3 pi / 4 of body C
  EXPECT_NEAR(arm.pitch, 3 * 3.14159265358979 / 4 - 3.14159265358979 / 2, 1e-12);
  const WoodyArm level = solveWoodyArm(m, woodyAngles(m, {0, 0, 6000, 0, 0, 0}));  // the pose of calibration
  EXPECT_NEAR((level.p - Vec3(0.245 - 0.220, 0, 0.080 + 0.205 - 0.080)).norm(), 0, 1e-12);
  EXPECT_NEAR(level.pitch, 0, 1e-12);
  // A turned by a quarter to the left of the base: x goes to y.
  const WoodyArm turned = solveWoodyArm(m, Vec3(3.14159265358979 / 2, 0, 3.14159265358979 / 2));
  EXPECT_NEAR((turned.p + m.origin - Vec3(0, 0.245, 0.285)).norm(), 0, 1e-12);
  // The weight pulls down, so what carries it pushes up.
  EXPECT_GT(
      forceForTorque(solveWoodyArm(m, Vec3(0, 0.6, 1.3)), solveWoodyArm(m, Vec3(0, 0.6, 1.3)).gravity_torque, 9).z(),
      0.3);
}

TEST(WoodyFiveBar, ClosesAsTheBarsAreLong) {
  const WoodyModel& m = *findWoodyModel("polhem_v3");
  const FiveBarLinks& L = m.bars;
  for (double b = 0.7; b < 1.9; b += 0.1) {
    for (double c = b + 1.4; c < b + 2.2; c += 0.1) {
      const WoodyArm arm = solveWoodyArm(m, Vec3(0, b, c));
      ASSERT_TRUE(arm.reachable);
      const Vec3 elbow(L.L0 / 2 + L.L1 * std::cos(b), 0, L.L1 * std::sin(b));
      const Vec3 crank(-L.L0 / 2 + L.L2 * std::cos(c), 0, L.L2 * std::sin(c));
      const Vec3 u(std::cos(arm.pitch), 0, std::sin(arm.pitch));
      EXPECT_NEAR((elbow - L.L4 * u - crank).norm(), L.L3, 1e-12);
      EXPECT_NEAR((elbow + L.L5 * u - arm.p - m.origin).norm(), 0, 1e-12);
      // The same pitch by the angles at the elbow (law of cosines), which also says which of the two closures it is.
      const Vec3 p = elbow - Vec3(-L.L0 / 2, 0, 0), w = elbow - crank;
      const double at_link = std::acos((L.L1 * L.L1 + p.squaredNorm() - L.L0 * L.L0) / (2 * L.L1 * p.norm()));
      const double at_crank = std::acos((p.squaredNorm() + w.squaredNorm() - L.L2 * L.L2) / (2 * p.norm() * w.norm()));
      const double at_bar = std::acos((w.squaredNorm() + L.L4 * L.L4 - L.L3 * L.L3) / (2 * w.norm() * L.L4));
      EXPECT_NEAR(std::remainder(arm.pitch - (b - at_link - at_crank - at_bar), 2 * 3.14159265358979323846), 0, 1e-9)
          << b << " " << c;
    }
  }
  EXPECT_FALSE(solveWoodyArm(m, Vec3(0, 2.4, 3.0)).reachable);  // torn apart
}

TEST(WoodyFiveBar, IsWithinItsWorkspaceWhereItIsCalibrated) {
  const WoodyModel& m = *findWoodyModel("polhem_v3");
  std::array<std::int32_t, 6> counts{};
  for (std::size_t i = 0; i < 6; ++i) counts[i] = m.calibration[i];
  const WoodyArm arm = solveWoodyArm(m, woodyAngles(m, counts));
  ASSERT_TRUE(arm.reachable);
  EXPECT_LT(arm.p.norm(), 0.4);
}

TEST(WoodyGimbal, TurnsAboutTheAxesOfTheStylus) {
  const WoodyModel& m = *findWoodyModel("polhem_v1");
  const auto turned = [&](std::array<std::int32_t, 6> counts) { return woodyOrientation(m, Vec3::Zero(), 0, counts); };
  EXPECT_NEAR((turned({}) * Vec3::UnitX() - Vec3::UnitX()).norm(), 0, 1e-12);
  EXPECT_NEAR((turned({0, 0, 0, 256, 0, 0}) * Vec3::UnitY() + Vec3::UnitZ()).norm(), 0, 1e-12);  // -90 deg about x
  EXPECT_NEAR((turned({0, 0, 0, 0, 256, 0}) * Vec3::UnitX() - Vec3::UnitZ()).norm(), 0, 1e-12);  // -90 deg about y
  // The forearm up by 90 degrees: the stylus looks up.
  EXPECT_NEAR((woodyOrientation(m, Vec3::Zero(), 1.5707963267948966, {}) * Vec3::UnitX() - Vec3::UnitZ()).norm(), 0,
              1e-12);
  EXPECT_TRUE(
      woodyOrientation(*findWoodyModel("vintage"), Vec3(1, 1, 1), 1, {1, 2, 3, 4, 5, 6}).isApprox(Quat::Identity()));
}

}  // namespace
}  // namespace hapticd
