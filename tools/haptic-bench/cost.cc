/** @file
 * haptic-bench cost: what a tick of the renderer costs on meshes from a thousand to a million triangles, beside a
 * pointer chase over as many bytes, by which another machine can be judged.
 *
 * A stroke of 10 s over a bumpy sphere, 1 mm deep at 0.1 m/s and 1 kHz, is rendered again and again; it is the same to
 * the bit each time, so the median over the rounds of each single tick is free of what else the machine did.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <numeric>
#include <random>

#include "daemon/builder/build.h"
#include "daemon/snapshot_memory.h"
#include "rt/render/proxy.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/bumpy_sphere.h"
#include "tools/haptic-bench/machine.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr double kDt = 1e-3;       // [s]
constexpr double kSpeed = 0.1;     // Of the stroke [m/s].
constexpr double kDepth = 1e-3;    // [m]
constexpr double kTurn = 0.61803;  // Of the stroke's plane per revolution: new ground each time round.

using Clock = std::chrono::steady_clock;

double nsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

/** The hand on its way round the sphere, `height` above the surface. */
Vec3 handAt(double seconds, double height) {
  const double angle = seconds * kSpeed / 0.05;
  const double tilt = 0.3 + kTurn * angle / (2 * M_PI);
  const Vec3 u(std::cos(angle), std::sin(angle) * std::cos(tilt), std::sin(angle) * std::sin(tilt));
  return (bumpyRadius(u) + height) * u;
}

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
  const auto start = Clock::now();
  for (std::size_t i = 0; i < loads; ++i) at = line[at][0];
  const double each = nsSince(start) / static_cast<double>(loads);
  return at == ~0u ? 0 : each;
}

/** One mesh in a scene. */
class Stage {
 public:
  explicit Stage(MeshView& mesh) : scene_(std::make_unique<Scene>(table_)) {
    table_.publish(0, &mesh);
    Command command;
    command.kind = CommandKind::kAddObject;
    auto& object = command.as<AddObject>();
    object = AddObject{};
    object.object = makeObjectId(1, 1);
    object.flags = HD_OBJECT_ENABLED;
    object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
    object.material.stiffness = 1000;
    object.q[0] = 1;
    ok_ = scene_->apply(command) == ErrorCode::kOk;
    scene_->advance(kDt);
  }
  [[nodiscard]] bool ok() const { return ok_; }

  /** Time of each tick of one stroke [ns]; false if the hand was not in contact all the time. */
  bool stroke(double radius, std::vector<double>& ticks) {
    ProxyRenderer renderer;
    SurfaceContact contact;
    renderer.reset(handAt(0, radius + 1e-4));
    renderer.step(*scene_, handAt(0, radius - kDepth), Vec3::Zero(), kDt, contact);
    bool touched = true;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      const Vec3 hip = handAt(static_cast<double>(i) * kDt, radius - kDepth);
      const auto start = Clock::now();
      scene_->advance(kDt);
      renderer.step(*scene_, hip, Vec3::Zero(), kDt, contact);
      ticks[i] = nsSince(start);
      touched = touched && contact.object != 0;
    }
    return touched;
  }

 private:
  MeshTable table_;
  std::unique_ptr<Scene> scene_;
  bool ok_ = false;
};

struct Options {
  double seconds = 10;
  std::vector<std::uint32_t> triangles = {1'000, 16'000, 100'000, 1'000'000};
  std::vector<double> radii_mm = {0};
};

double quantile(const std::vector<double>& sorted, double q) {
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(q * static_cast<double>(sorted.size())))];
}

/** Per tick the median over the rounds, less what reading the clock takes. */
std::vector<double> medianTicks(std::vector<std::vector<double>>& rounds) {
  std::vector<double> clock(1000);
  for (double& c : clock) {
    const auto start = Clock::now();
    c = nsSince(start);
  }
  const double reading = *std::min_element(clock.begin(), clock.end());
  std::vector<double> ticks(rounds[0].size()), one(rounds.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    for (std::size_t r = 0; r < rounds.size(); ++r) one[r] = rounds[r][i];
    std::nth_element(one.begin(), one.begin() + static_cast<std::ptrdiff_t>(one.size() / 2), one.end());
    ticks[i] = std::max(one[one.size() / 2] - reading, 0.0);
  }
  return ticks;
}

bool measure(const Common& common, const Options& options, std::uint32_t triangles) {
  const std::vector<std::byte> upload = bumpySphereUpload(triangles);
  BuildMonitor monitor;
  auto built = buildSnapshot(upload, monitor);
  if (!built) {
    fmt::print(stderr, "haptic-bench: {}\n", toString(built.error()));
    return false;
  }
  const double bytes = static_cast<double>(built->stats.bytes);
  const double build_s = static_cast<double>(built->stats.build_ns) / 1e9;
  const std::uint32_t count = built->stats.triangles;
  auto memory = openSnapshot(std::move(*built->memfd.share()), false);
  if (!memory) {
    fmt::print(stderr, "haptic-bench: {}\n", toString(memory.error()));
    return false;
  }
  const double load = chase(static_cast<std::size_t>(bytes));
  Stage stage(memory->view);
  for (const double radius_mm : options.radii_mm) {
    std::vector<std::vector<double>> rounds(static_cast<std::size_t>(common.rounds));
    bool touched = stage.ok();
    for (auto& round : rounds) {
      round.resize(static_cast<std::size_t>(options.seconds / kDt));
      touched = touched && stage.stroke(radius_mm * 1e-3, round);
    }
    std::vector<double> ticks = medianTicks(rounds);
    const double mean = std::accumulate(ticks.begin(), ticks.end(), 0.0) / static_cast<double>(ticks.size());
    std::sort(ticks.begin(), ticks.end());
    const char* form = common.csv
                           ? "{},{},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.3f},{:.1f},{:.2f},{}\n"
                           : "{:>9} {:>6} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.2f} {:>8.1f} {:>8.1f} {}\n";
    fmt::print(fmt::runtime(form), count, radius_mm, mean, quantile(ticks, 0.5), quantile(ticks, 0.99),
               quantile(ticks, 0.999), ticks.back(), build_s, bytes / 1e6, load, touched ? "" : "lost contact");
    std::fflush(stdout);
    if (!touched) return false;
  }
  return true;
}

int run(const Common& common, const Options& options) {
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  fmt::print("# stroke of {} s, {} mm deep at {} m/s, 1 kHz; per tick the median of {} rounds; times in ns\n",
             options.seconds, kDepth * 1e3, kSpeed, common.rounds);
  fmt::print("{}\n", common.csv
                         ? "triangles,radius_mm,mean,median,p99,p99.9,max,build_s,MB,chase,note"
                         : "triangles radius     mean   median      p99    p99.9      max  build/s       MB    chase");
  for (const std::uint32_t n : options.triangles) {
    if (!measure(common, options, n)) return 1;
  }
  return 0;
}

}  // namespace

void addCost(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* cost = app.add_subcommand("cost", "A renderer's tick on meshes of rising size, beside a pointer chase");
  cost->add_option("--triangles", options->triangles, "Sizes of the mesh")
      ->capture_default_str()
      ->check(CLI::Range(8, 8'000'000));
  cost->add_option("--radius", options->radii_mm, "Of the proxy [mm]")->capture_default_str()->check(CLI::Range(0, 10));
  cost->add_option("--seconds", options->seconds, "Of stroke")->capture_default_str()->check(CLI::Range(0.1, 600.0));
  cost->callback([&chosen, options] { chosen = [options](const Common& common) { return run(common, *options); }; });
}

}  // namespace haptic_bench
