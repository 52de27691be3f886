/** @file
 * haptic-bench cost: what it counts is the same with all vector instructions; its rounds are summed up one by one.
 */
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "daemon/builder/build.h"
#include "rt/geometry/tree/boxes.h"
#include "tools/haptic-bench/cost/bumpy_sphere.h"
#include "tools/haptic-bench/cost/mesh_cost.h"
#include "tools/haptic-bench/cost/servo_stage.h"

namespace haptic_bench {
namespace {

CostOptions shortStroke() {
  CostOptions options;
  options.seconds = 0.3;
  return options;
}

TEST(Cost, AllVectorPathsLookAtTheSame) {
  using hapticd::VectorPath;
  const VectorPath best = hapticd::vectorPath();
  std::vector<Looked> looked;
  for (const VectorPath path : {VectorPath::kPortable, VectorPath::kAvx2}) {
    if (!hapticd::choosePath(path)) continue;
    MeshCost mesh(16'000, shortStroke());
    mesh.round();
    for (const double radius_mm : {0.0, 1.0}) looked.push_back(mesh.count(radius_mm));
  }
  hapticd::choosePath(best);
  for (std::size_t i = 2; i < looked.size(); ++i) {
    EXPECT_EQ(looked[i].sweeps, looked[i - 2].sweeps);
    EXPECT_EQ(looked[i].visited, looked[i - 2].visited);
    EXPECT_EQ(looked[i].gathered, looked[i - 2].gathered);
  }
  EXPECT_EQ(looked[0].sweeps.size(), 300u);
}

TEST(Cost, EveryRoundIsMeasuredFromBuildingOn) {
  MeshCost mesh(1'000, shortStroke());
  for (int i = 0; i < 3; ++i) mesh.round();
  EXPECT_EQ(mesh.builds().rounds.size(), 3u);
  EXPECT_EQ(mesh.chases().rounds.size(), 3u);
  ASSERT_EQ(mesh.times().size(), 7u);
  EXPECT_EQ(mesh.times()[3].name(), "servo 1 mm");
  for (const TickTimes& times : mesh.times()) {
    EXPECT_EQ(times.medians().size(), 300u);
    for (const Series& s : times.series()) EXPECT_EQ(s.rounds.size(), 3u) << s.name;
  }
}

TEST(Cost, WhatInterruptsATickIsNotItsCost) {
  TickTimes times("tick");
  int strokes = 0;
  const auto busy = [](double us) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double, std::micro>(us);
    while (std::chrono::steady_clock::now() < end) {
    }
  };
  times.take(
      100, [&] { ++strokes; },
      [&](std::size_t i) {
        busy(i == 7 && strokes == 1 ? 200'000 : i == 9 && strokes == 2 ? 200'000 : i == 50 ? 2000 : 1);
      });
  EXPECT_EQ(strokes, 2);
  for (const Series& s : times.series()) {
    if (s.name != "tick max") continue;
    EXPECT_GE(s.rounds[0], 1.9e6) << "dear each time";
    EXPECT_LT(s.rounds[0], 160e6) << "dear once";
  }
  EXPECT_LT(times.medians()[7], 160e6) << "of the first stroke, which warms the caches";
  EXPECT_GE(times.medians()[9], 160e6) << "of the second stroke";
  times.take(
      100, [&] { ++strokes; }, [&](std::size_t i) { busy(i == 11 && strokes == 4 ? 200'000 : 1); });
  EXPECT_LT(times.medians()[11], 160e6) << "of two rounds the middle, not the slower";
}

TEST(Cost, AServoThatTheMachineHeldUpGoesOn) {
  hapticd::BuildMonitor monitor;
  auto built = hapticd::buildSnapshot(bumpySphereUpload(1'000), monitor);
  ASSERT_TRUE(built);
  auto memory = hapticd::openSnapshot(std::move(*built->memfd.share()), false);
  ASSERT_TRUE(memory);
  const MeshStroke stroke(memory->view, 0.3, 0.1);
  ServoStage servo(memory->view, stroke);
  servo.begin(0);
  for (std::size_t i = 0; i < stroke.ticks(); ++i) {
    if (i % 100 == 50) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    servo.tick(i);
  }
  EXPECT_TRUE(servo.touched());
}

TEST(Cost, TicksAreSummedUp) {
  std::vector<double> ticks;
  for (int i = 1000; i > 0; --i) ticks.push_back(i);
  const TickSummary summary = summariseTicks(ticks);
  EXPECT_EQ(summary.mean, 500.5);
  EXPECT_EQ(summary.median, 500);
  EXPECT_EQ(summary.p99, 990);
  EXPECT_EQ(summary.p999, 999);
  EXPECT_EQ(summary.max, 1000);
}

}  // namespace
}  // namespace haptic_bench
