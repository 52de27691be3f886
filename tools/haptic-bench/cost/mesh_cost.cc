#include "tools/haptic-bench/cost/mesh_cost.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <numeric>
#include <random>

#include "daemon/builder/build.h"
#include "rt/geometry/nearest/nearest.h"
#include "rt/geometry/sweep/sweep.h"
#include "rt/render/proxy/proxy.h"
#include "tools/haptic-bench/cost/bumpy_sphere.h"
#include "tools/haptic-bench/cost/servo_stage.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

namespace {

/** Nanoseconds a load of a chain through all lines of `bytes` in random order. */
double chase(std::size_t bytes) {
  const std::size_t lines = std::max<std::size_t>(bytes / 64, 2);
  std::vector<std::uint32_t> order(lines);
  std::iota(order.begin(), order.end(), 0u);
  std::mt19937 random(1);
  std::shuffle(order.begin(), order.end(), random);
  std::vector<std::array<std::uint32_t, 16>> line(lines);
  for (std::size_t i = 0; i < lines; ++i) line[order[i]][0] = order[(i + 1) % lines];
  std::uint32_t at = 0;
  const std::size_t loads = std::clamp<std::size_t>(2 * lines, 100'000, 2'000'000);
  for (std::size_t i = 0; i < loads / 2; ++i) at = line[at][0];  // warms up
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < loads; ++i) at = line[at][0];
  const std::chrono::duration<double, std::nano> passed = std::chrono::steady_clock::now() - start;
  return at == ~0u ? 0 : passed.count() / static_cast<double>(loads);
}

double cpuMilliseconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/** A ball from above the surface, clear of its slopes, to `kStrokeDepth` below it, a tick further on. */
void sweepOnce(const MeshView& mesh, const MeshStroke& stroke, std::size_t i, double radius) {
  Sweep sweep;
  sweep.a = stroke.at(i, 2 * radius + kStrokeAbove);
  sweep.d = stroke.at(i + 1, radius - kStrokeDepth) - sweep.a;
  sweep.radius = radius;
  sweep.limit = ProxyRenderer::kMaxWork;
  SweepHit hit;
  if (sweepMesh(mesh, sweep, hit) != SweepResult::kHit) throw Failure("stroke", "a sweep met nothing", "");
}

void nearestOnce(const MeshView& mesh, const MeshStroke& stroke, std::size_t i) {
  NearestQuery query;
  query.x = stroke.at(i, -kStrokeDepth);
  query.limit = ProxyRenderer::kMaxWork;
  Nearest nearest;
  if (nearestOnMesh(mesh, query, nearest) != NearestResult::kFound)
    throw Failure("stroke", "no point of the mesh is near", "");
}

}  // namespace

MeshCost::MeshCost(std::uint32_t triangles, const CostOptions& options)
    : options_(options), upload_(bumpySphereUpload(triangles)) {
  for (const char* what : {"tick", "servo", "sweep"}) {
    for (const double radius : options.radii_mm) times_.emplace_back(fmt::format("{} {} mm", what, radius));
  }
  times_.emplace_back("nearest");
}

void MeshCost::build() {
  BuildMonitor monitor;
  const double before = cpuMilliseconds();
  auto built = buildSnapshot(upload_, monitor);
  builds_.rounds.push_back(cpuMilliseconds() - before);
  if (!built) throw Failure(built.error());
  bytes_ = static_cast<std::size_t>(built->stats.bytes);
  triangles_ = built->stats.triangles;
  depth_ = built->stats.depth;
  auto memory = openSnapshot(std::move(*built->memfd.share()), false);
  if (!memory) throw Failure(memory.error());
  memory_ = std::make_unique<SnapshotMemory>(std::move(*memory));
}

void MeshCost::round() {
  build();
  chases_.rounds.push_back(chase(bytes_));
  MeshView& mesh = memory_->view;
  if (stroke_ == nullptr) stroke_ = std::make_unique<MeshStroke>(mesh, options_.seconds, options_.speed);
  const MeshStroke& stroke = *stroke_;
  auto next = times_.begin();
  RenderStage render(mesh, stroke);
  for (const double radius : options_.radii_mm) {
    next++->take(
        stroke.ticks(), [&] { render.begin(radius / 1e3); }, [&](std::size_t i) { render.tick(i); });
    if (!render.touched()) throw Failure("stroke", "the hand left the surface", "");
  }
  ServoStage servo(mesh, stroke);
  for (const double radius : options_.radii_mm) {
    next++->take(
        stroke.ticks(), [&] { servo.begin(radius / 1e3); }, [&](std::size_t i) { servo.tick(i); });
    if (!servo.touched()) throw Failure("stroke", "the hand left the surface, or the servo was not armed", "");
  }
  for (const double radius : options_.radii_mm) {
    next++->take(
        stroke.ticks(), [] {}, [&](std::size_t i) { sweepOnce(mesh, stroke, i, radius / 1e3); });
  }
  next->take(
      stroke.ticks(), [] {}, [&](std::size_t i) { nearestOnce(mesh, stroke, i); });
}

Looked MeshCost::count(double radius_mm) {
  RenderStage render(memory_->view, *stroke_);
  return lookedAt(render, *stroke_, radius_mm / 1e3);
}

}  // namespace haptic_bench
