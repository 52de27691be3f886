/** @file
 * The simulated hands of haptic-bench grasp: what they do to cubes and bars, by closed forms.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tools/haptic-bench/grasp/goals.h"

namespace haptic_bench::grasp {
namespace {

/** Ten people's intelligence and hours of television, the textbook's example: rho is -29/165. Ties share their ranks.
 */
TEST(BenchGrasp, RankCorrelationIsSpearmans) {
  const std::vector<double> iq{106, 100, 86, 101, 99, 103, 97, 113, 112, 110},
      hours{7, 27, 2, 50, 28, 29, 20, 12, 6, 17};
  EXPECT_NEAR(spearman(iq, hours), -29.0 / 165, 1e-12);
  EXPECT_NEAR(spearman(iq, iq), 1, 1e-12);
  // Ranks 1.5 1.5 3 against 1 2 3: covariance 1.5, variances 1.5 and 2.
  EXPECT_NEAR(spearman({4, 4, 9}, {0, 1, 2}), std::sqrt(0.75), 1e-12);
  EXPECT_TRUE(std::isnan(spearman({1, 1}, {0, 1})));
}

TEST(BenchGrasp, AnUnsteadyFingerIsOffAsMuchAsAsked) {
  std::mt19937_64 random(7);
  const Unrest unrest(2e-4, random);
  double sum = 0, squares = 0;
  const int ticks = 1'000'000;
  for (int i = 0; i < ticks; ++i) {
    const double off = unrest.at(i * kPeriod_s);
    sum += off;
    squares += off * off;
  }
  EXPECT_NEAR(std::sqrt(squares / ticks), 2e-4, 2e-6);
  EXPECT_NEAR(sum / ticks, 0, 1e-6);
}

/** A steady hand presses as springs in series do, and the cube slips at m g / (2 mu_s). */
TEST(BenchGrasp, ACubeSlipsWhereTheConeEnds) {
  for (const double stiffness : {500.0, 2000.0}) {
    Block block;
    block.mass = 0.2;
    block.material = {stiffness, 1, 0.8, 0.6};
    Hand steady;
    steady.unsteady = 0;
    Rig rig(block, steady);
    rig.grasp(3);
    EXPECT_NEAR(rig.grip(), 3, 0.15) << "but for the device's dry friction, 0.1 N";
    EXPECT_LT(rig.slid(), 1e-6);
    double last = 0;
    while (!rig.slips()) {
      last = rig.grip();
      rig.want(rig.wanted() - 1e-6);
      rig.tick();
    }
    EXPECT_NEAR(last, block.slips(), 0.02 * block.slips()) << stiffness;
  }
}

/** A light cube on stiff springs: while nothing was viscous along the surface it rocked ever more, and slid by
 * millimetres from a grip four times as firm as it needs. */
TEST(BenchGrasp, AFirmGripHoldsALightStiffCube) {
  Block block;
  block.mass = 0.1;
  block.material = {2000, 1, 0.4, 0.3};
  Hand hand;
  hand.unsteady = 3e-4;
  hand.seed = 3;
  Rig rig(block, hand);
  rig.grasp(5.8);
  for (int i = 0; i < 10'000; ++i) rig.tick();
  EXPECT_LT(rig.slid(), 1e-4);
}

/** On both sides of L_0 = arm, coupled and not: docs/grasping.md. */
TEST(BenchGrasp, ABarYieldsWhereTheClosedFormSays) {
  for (const bool coupled : {true, false}) {
    for (const double part : {0.5, 2.0}) {
      const Release one = letGo(coupled, kSandpaperArm, part * kSandpaperArm);
      EXPECT_NEAR(one.yields, one.closed, 0.02 * one.closed) << coupled << part;
      if (!coupled && part < 1) {
        EXPECT_LT(one.turned_5, 0.05);
      }
      if (!coupled && part > 1) {
        EXPECT_LT(one.slid_30, 1e-4);
      }
    }
  }
}

/** Which goals, counted from 0. */
std::string missed(const std::vector<Goal>& goals) {
  std::string which;
  for (std::size_t i = 0; i < goals.size(); ++i) which += goals[i].met ? "" : std::to_string(i);
  return which;
}

TEST(BenchGrasp, GoalsAreMissedByWrongHands) {
  std::vector<Cube> cubes;
  for (const double mass : {0.1, 0.2, 0.4}) {
    for (const double stiffness : {500.0, 1000.0, 2000.0}) {
      for (const double friction : {0.4, 0.8}) {
        Cube& cube = cubes.emplace_back(Cube{mass, friction, stiffness, mass * kGravity / 2 / friction});
        cube.holds.push_back({cube.slips, cube.slips + stiffness * 2e-4});
      }
    }
  }
  const auto holdAs = [&](const auto& grip) {
    std::vector<Cube> others = cubes;
    for (Cube& cube : others) cube.holds.front().held = grip(cube);
    return missed(judge(others));
  };
  EXPECT_EQ(missed(judge(cubes)), "");
  EXPECT_EQ(holdAs([](const Cube&) { return 5.0; }), "13")
      << "all alike: no correlation, nor margins that the stiffness makes";
  EXPECT_EQ(holdAs([](const Cube& c) { return c.slips * (1 + c.mass) + 1e-6 * c.stiffness; }), "2");
  EXPECT_EQ(holdAs([](const Cube& c) { return c.slips + 1 - 2e-4 * c.stiffness; }), "13");
  cubes.front().holds.front().fell *= 1.3;
  EXPECT_EQ(missed(judge(cubes)), "0");
}

TEST(BenchGrasp, GoalsAreMissedByWrongBars) {
  const double none = std::nan("");
  const std::vector<Release> good{{true, 6e-3, 6e-3, 1, 1.01, 2e-3, 5e-3, 0.5},
                                  {true, 6e-3, 1e-2, 1, 0.99, 1e-3, 2e-3, 0.9},
                                  {false, 6e-3, 3e-3, 1, 1, none, none, 0.01},
                                  {false, 6e-3, 1e-2, 1, 1, 0, 0, none}};
  const auto with = [&](std::size_t i, double Release::*member, double value) {
    std::vector<Release> all = good;
    all[i].*member = value;
    return missed(judge(all));
  };
  EXPECT_EQ(missed(judge(good)), "");
  EXPECT_EQ(with(0, &Release::yields, 1.03), "0");
  EXPECT_EQ(with(2, &Release::turned_5, 0.2), "1");
  EXPECT_EQ(with(3, &Release::slid_10, 1e-3), "1");
  EXPECT_EQ(with(1, &Release::slid_10, 3e-3), "2");

  std::vector<Alignment> aligned{{true, 0.02, 0.5, {{0.1, 1, -0.05, 0, false}}},
                                 {false, 0.02, 0.5, {{0.1, 1, 0.1, 0, false}}}};
  EXPECT_EQ(missed(judge(aligned)), "");
  aligned[0].attempts[0].off = -0.2;
  EXPECT_EQ(missed(judge(aligned)), "0");
  aligned[1].attempts[0] = {0.1, 1, -0.5, 0.03, true};
  EXPECT_EQ(missed(judge(aligned)), "1");
}

}  // namespace
}  // namespace haptic_bench::grasp
