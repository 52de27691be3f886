/** @file
 * Each algorithm in the box and the plug-in interface.
 */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tools/haptic-bench/algorithm/registry.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/trajectory/registry.h"
#include "tools/haptic-bench/trial/trial.h"

namespace haptic_bench {
namespace {

using ::testing::HasSubstr;

Accuracy accuracy(const std::string& algorithm, const std::string& model_spec, const std::string& trajectory_spec) {
  const Model model = makeModel(model_spec);
  const Trajectory trajectory = makeTrajectory(trajectory_spec, model, {1000});
  return judge(trajectory, runTrial(algorithm, model, trajectory, {1000}, 1).answers, 1e-3);
}

std::string refusalOf(const std::string& algorithm) {
  try {
    (void)accuracy(algorithm, "plane", "lissajous:seconds=0.1");
  } catch (const Failure& failure) {
    return failure.what();
  }
  ADD_FAILURE() << algorithm;
  return "";
}

TEST(Algorithms, OnAPlaneVoxelsPlanesAndThePlugInAreExact) {
  EXPECT_LT(accuracy("voxel:cells=32", "plane", "lissajous:seconds=2").force_mse, 1e-10);
  EXPECT_LT(accuracy("local:rate=30,latency=0.005", "plane", "lissajous:seconds=2").force_mse, 1e-12);
  EXPECT_LT(accuracy(HAPTIC_BENCH_EXAMPLE, "plane:cells=9", "lissajous:seconds=2").force_mse, 1e-12);
}

TEST(Algorithms, DampingWorksAlongTheNormalAndNeverPulls) {
  // Straight down to 1 mm, along, and up so fast that damping alone would pull: on a plane k d - b v, not below 0.
  const Model model = makeModel("plane");
  const Surface damped{1000, 4, 0, 0};
  Trajectory in;
  for (int i = 0; i <= 400; ++i) {
    const double t = 1e-3 * i, along = 0.05 * t;
    const double z = i < 200 ? 1e-3 - 1e-5 * i : std::min(-1e-3 + 3e-4 * std::max(0, i - 380), 1e-3);
    in.samples.push_back({t, Vec3(0.003 + along, 0.001, z), Vec3::Zero(), Vec3::Zero()});
  }
  double slowest = 0, least = 1;
  for (const char* algorithm : {"ours", "god-object", "nearest", "voxel:cells=32", "local:rate=1000,latency=0"}) {
    const Outcome outcome = runTrial(algorithm, model, in, damped, 1);
    for (std::size_t i = 1; i < in.samples.size(); ++i) {
      const double z = in.samples[i].hip.z(), v = (z - in.samples[i - 1].hip.z()) / 1e-3;
      // A local model slows a hand by no more than it pushes.
      const double damping = std::max(4 * v, algorithm[0] == 'l' ? 1000 * z : -1.0);
      const double force = z < -1e-9 ? std::max(0.0, -1000 * z - damping) : 0;
      if (std::abs(z) < 1e-9) continue;  // Rounding says whether it touches.
      ASSERT_LT((outcome.answers[i].force - Vec3(0, 0, force)).norm(), 2e-4) << algorithm << " " << i;
      if (z < -1e-9) slowest = std::max(slowest, force), least = std::min(least, force);
    }
  }
  EXPECT_NEAR(slowest, 1.04, 0.01);
  EXPECT_EQ(least, 0) << "deep, and let go";
}

TEST(Algorithms, OnASlopeTheForceIsTheDepthAlongItsNormal) {
  const Model model = makeModel("plane:turn_x=0.4,turn_y=0.3");
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Vec3(0.8, 0.6, 0)));
  Trajectory in;
  for (int i = 0; i < 300; ++i) {
    const Vec3 foot = turn * Vec3(2e-5 * i, 0.003 - 1e-5 * i, 0);
    in.samples.push_back({1e-3 * i, foot + turn * Vec3(0, 0, 1.05e-3 - 1e-5 * i), foot, Vec3::Zero()});
  }
  for (const char* algorithm : {"ours", "god-object", "nearest", "voxel:cells=32", "local:rate=1000,latency=0"}) {
    const Outcome outcome = runTrial(algorithm, model, in, {1000}, 1);
    for (std::size_t i = 0; i < in.samples.size(); ++i) {
      const Answer& answer = outcome.answers[i];
      const bool within = i > 105;
      if (i == 105) continue;  // On the surface, but for rounding.
      const Vec3 foot = in.samples[i].proxy, hip = in.samples[i].hip;
      ASSERT_EQ(answer.touches, within) << algorithm << " " << i;
      ASSERT_LT((answer.force - (within ? 1000 * (foot - hip) : Vec3(Vec3::Zero()))).norm(), 1e-4) << algorithm << i;
      ASSERT_LT((answer.proxy - (within ? foot : hip)).norm(), 1e-7) << algorithm << " " << i;
    }
  }
}

TEST(Algorithms, WhatLiesOnTheSurfaceHasItsNormalAndNotThatOfRounding) {
  const Model model = makeModel("plane");
  Surface ball{1000};
  ball.radius = 0.001;  // 1 N at 1000 N/m press its centre down to the surface.
  const Trajectory in = makeTrajectory("lissajous:seconds=2", model, ball);
  EXPECT_LT(judge(in, runTrial("nearest", model, in, ball, 1).answers, 1e-3).force_mse, 1e-20);
  EXPECT_LT(accuracy("local", "plane", "lissajous:seconds=2,force=0").force_mse, 1e-20);
}

TEST(Algorithms, LocalPlanesErrByTheCurvatureTheyCannotKnow) {
  // At v t behind, a sphere of radius R (about the hand at R - d) lies (v t)^2 / 2 R below its tangent plane.
  const char* spiral = "spiral:turns=2,seconds=4";
  const double slow = accuracy("local:rate=10,latency=0,blend=0", "sphere:stacks=64", spiral).force_mse;
  const double fast = accuracy("local:rate=100,latency=0,blend=0", "sphere:stacks=64", spiral).force_mse;
  const double late = accuracy("local:rate=100,latency=0.05,blend=0", "sphere:stacks=64", spiral).force_mse;
  EXPECT_GT(slow, 20 * fast);
  EXPECT_GT(late, 5 * fast);
}

TEST(Algorithms, LocalPlanesAreSentAtTheirRateHoweverLateTheyCome) {
  // 20 ms late, a plane is 20 ms old at 1000 Hz and up to 40 at 50 Hz; the error of the force goes with the age.
  const char* spiral = "spiral:turns=2,seconds=4";
  const double slow = accuracy("local:rate=50,latency=0.02,blend=0", "sphere:stacks=64", spiral).force_mse;
  const double fast = accuracy("local:rate=1000,latency=0.02,blend=0", "sphere:stacks=64", spiral).force_mse;
  EXPECT_LT(fast, 0.7 * slow);
  EXPECT_GT(fast, 0.1 * slow) << "it is late all the same";
}

TEST(Algorithms, VoxelsBecomeExactAsTheyShrink) {
  const double coarse = accuracy("voxel:cells=16", "sphere:stacks=16", "spiral:seconds=2").force_mse;
  const double fine = accuracy("voxel:cells=64", "sphere:stacks=16", "spiral:seconds=2").force_mse;
  const double exact = accuracy("nearest", "sphere:stacks=16", "spiral:seconds=2").force_mse;
  EXPECT_NEAR(fine, exact, 0.25 * exact);
  EXPECT_GT(std::abs(coarse - exact), std::abs(fine - exact));
}

TEST(PlugIns, OfAnotherVersionAreRefusedBeforeAnythingIsCalled) {
  EXPECT_THAT(refusalOf(HAPTIC_BENCH_OTHER_VERSION), HasSubstr("version 2, this haptic-bench has 1"));
  EXPECT_THAT(refusalOf("/dev/null"), HasSubstr("/dev/null"));
  EXPECT_THAT(refusalOf(HAPTIC_BENCH_EXAMPLE ":x=1"), HasSubstr("it takes no options")) << "its own words";
  EXPECT_THAT(refusalOf("libc.so.6"), HasSubstr("no such algorithm")) << "a path has a slash";
}

}  // namespace
}  // namespace haptic_bench
