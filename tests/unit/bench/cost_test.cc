/** @file
 * haptic-bench cost: what it counts is the same with all vector instructions; its rounds are summed up one by one.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <thread>

#include "daemon/builder/build.h"
#include "proto/snapshot.h"
#include "rt/geometry/nearest/nearest.h"
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

hapticd::Result<hapticd::SnapshotMemory> bumpySphere(std::uint32_t triangles) {
  hapticd::BuildMonitor monitor;
  auto built = hapticd::buildSnapshot(bumpySphereUpload(triangles), monitor);
  if (!built) return built.error();
  return hapticd::openSnapshot(std::move(*built->memfd.share()), false);
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

TEST(Cost, TheBumpySphereIsClosedAndLiesOnItsSurface) {
  EXPECT_EQ(bumpySphereTriangles(8), 8u);
  EXPECT_EQ(bumpySphereTriangles(9), 32u);
  EXPECT_EQ(bumpySphereTriangles(1'000'000), 8u * 354 * 354);
  const std::vector<std::byte> bytes = bumpySphereUpload(1'000);
  hd_mesh_upload header;
  std::memcpy(&header, bytes.data(), sizeof header);
  ASSERT_EQ(header.triangle_count, 8u * 12 * 12);
  std::vector<std::array<float, 3>> vertices(header.vertex_count);
  std::vector<std::array<std::uint32_t, 3>> triangles(header.triangle_count);
  ASSERT_EQ(bytes.size(), sizeof header + vertices.size() * 12 + triangles.size() * 12);
  std::memcpy(vertices.data(), bytes.data() + sizeof header, vertices.size() * 12);
  std::memcpy(triangles.data(), bytes.data() + sizeof header + vertices.size() * 12, triangles.size() * 12);
  const auto place = [&](std::uint32_t v) { return hapticd::Vec3(vertices[v][0], vertices[v][1], vertices[v][2]); };
  std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> edges;
  double volume = 0;
  for (const auto& t : triangles) {
    volume += place(t[0]).dot(place(t[1]).cross(place(t[2]))) / 6;
    for (std::size_t c = 0; c < 3; ++c) ++edges[{vertices[t[c]], vertices[t[(c + 1) % 3]]}];
  }
  EXPECT_NEAR(volume, 4 * EIGEN_PI / 3 * std::pow(0.05, 3), 1e-5) << "outward; of flat facets, by a hundredth less";
  EXPECT_EQ(edges.size(), 3 * triangles.size());
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_EQ(edges.count({edge.second, edge.first}), 1u) << "the neighbour goes the other way, with the same corners";
  }
  double low = 1, high = 0;
  for (std::uint32_t v = 0; v < header.vertex_count; ++v) {
    const hapticd::Vec3 u = place(v).normalized(), wave = (30 * u).array().sin();
    ASSERT_NEAR(place(v).norm(), 0.05 + 5e-4 * wave.prod(), 1e-8);
    low = std::min(low, place(v).norm()), high = std::max(high, place(v).norm());
  }
  EXPECT_LT(low, 0.0497);
  EXPECT_GT(high, 0.0503);
}

TEST(Cost, TheStrokeGoesOverNewGroundAtItsSpeed) {
  auto memory = bumpySphere(16'000);
  ASSERT_TRUE(memory);
  const MeshStroke stroke(memory->view, 8, 0.1);
  ASSERT_EQ(stroke.ticks(), 8000u);
  std::vector<hapticd::Vec3> way;
  for (std::size_t i = 0; i <= stroke.ticks(); ++i) way.push_back(stroke.at(i, 0).normalized());
  for (std::size_t i = 0; i < stroke.ticks(); ++i) {
    ASSERT_NEAR(0.05 * (way[i + 1] - way[i]).norm(), 1e-4, 2e-5) << "0.1 m/s at 1 kHz, and what the plane turns";
    ASSERT_NEAR((stroke.at(i, 1e-3) - stroke.at(i, 0)).norm(), 1e-3, 1e-9);
    hapticd::NearestQuery query;
    query.x = stroke.at(i, 0);
    query.limit = UINT32_MAX;
    hapticd::Nearest nearest;
    ASSERT_EQ(nearestOnMesh(memory->view, query, nearest), hapticd::NearestResult::kFound);
    ASSERT_LT(nearest.squared_distance, 1e-12) << "on the mesh, not the sphere";
  }
  // Two and a half times round: a quarter of a turn later it is far from where it has been, but for the crossings.
  int near = 0;
  for (std::size_t i = 3200; i < way.size(); i += 10) {
    for (std::size_t j = 0; j + 1000 < i; j += 10) near += (way[i] - way[j]).norm() < 0.02 ? 1 : 0;
  }
  EXPECT_LT(near, 100);
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
  auto memory = bumpySphere(1'000);
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
