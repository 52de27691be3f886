/** @file
 * haptic-bench cost: what a tick of the renderer, the servo's whole tick about it and the queries in it cost on meshes
 * from a thousand to a million triangles, beside a pointer chase over as many bytes, by which another machine can be
 * judged.
 *
 * A stroke of 10 s over a bumpy sphere, 1 mm deep at 0.1 m/s (or --speed) and 1 kHz, is done again and again; it is the
 * same to the bit each time, so the median over the rounds of each single tick is free of what else the machine did.
 */
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <memory>
#include <numeric>
#include <random>

#include "daemon/builder/build.h"
#include "daemon/snapshot_memory.h"
#include "rt/geometry/boxes.h"
#include "rt/geometry/nearest.h"
#include "rt/render/proxy.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/bumpy_sphere.h"
#include "tools/haptic-bench/cost/servo_stage.h"
#include "tools/haptic-bench/cost/stroke.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/metric/quantile.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

using SteadyClock = std::chrono::steady_clock;

double nsSince(SteadyClock::time_point start) {
  return std::chrono::duration<double, std::nano>(SteadyClock::now() - start).count();
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
  const auto start = SteadyClock::now();
  for (std::size_t i = 0; i < loads; ++i) at = line[at][0];
  const double each = nsSince(start) / static_cast<double>(loads);
  return at == ~0u ? 0 : each;
}

/** One mesh in a scene. */
class Stage {
 public:
  Stage(MeshView& mesh, const MeshStroke& stroke) : stroke_(stroke), scene_(std::make_unique<Scene>(table_)) {
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
    scene_->advance(kStrokeDt);
  }
  [[nodiscard]] bool ok() const { return ok_; }

  /** Puts a ball above the start of the stroke. */
  void begin(double radius) {
    radius_ = radius;
    renderer_.setRadius(radius);
    renderer_.reset(stroke_.at(0, radius + kStrokeAbove));
    touched_ = true;
  }
  void tick(std::size_t i) {
    scene_->advance(kStrokeDt);
    renderer_.step(*scene_, stroke_.at(i, radius_ - kStrokeDepth), Vec3::Zero(), kStrokeDt, contact_);
    touched_ = touched_ && contact_.object != 0;
  }
  /** Whether the hand has been in contact since begin(). */
  [[nodiscard]] bool touched() const { return touched_; }
  [[nodiscard]] const ProxyRenderer& renderer() const { return renderer_; }

 private:
  const MeshStroke& stroke_;
  MeshTable table_;
  std::unique_ptr<Scene> scene_;
  ProxyRenderer renderer_;
  SurfaceContact contact_;
  double radius_ = 0;
  bool ok_ = false;
  bool touched_ = true;
};

/** What the ticks of a stroke looked at. */
struct Looked {
  std::vector<double> sweeps, visited, gathered;  ///< Each tick; visited: for sweeps and looks.
  double at_once = 0, ahead = 0;                  ///< Vicinities gathered in the tick that needs them, and before.
};

struct CostOptions {
  double seconds = 10;
  double speed = 0.1;  ///< [m/s]
  std::string profile;
  std::vector<std::uint32_t> triangles = {1'000, 16'000, 100'000, 1'000'000};
  std::vector<double> radii_mm = {0, 1};
};

double clockReading() {
  std::vector<double> clock(1000);
  for (double& c : clock) c = nsSince(SteadyClock::now());
  return *std::min_element(clock.begin(), clock.end());
}

/** Of each tick of the stroke the median time over the rounds, less what reading the clock takes [ns]. */
template <class Begin, class Tick>
std::vector<double> timed(const Common& common, const MeshStroke& stroke, Begin&& begin, Tick&& tick) {
  const std::size_t count = stroke.ticks();
  std::vector<std::vector<double>> rounds(static_cast<std::size_t>(common.rounds), std::vector<double>(count));
  for (auto& round : rounds) {
    begin();
    for (std::size_t i = 0; i < count; ++i) {
      const auto start = SteadyClock::now();
      tick(i);
      round[i] = nsSince(start);
    }
  }
  const double reading = clockReading();
  std::vector<double> ticks(count), one(rounds.size());
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t r = 0; r < rounds.size(); ++r) one[r] = rounds[r][i];
    std::nth_element(one.begin(), one.begin() + static_cast<std::ptrdiff_t>(one.size() / 2), one.end());
    ticks[i] = std::max(one[one.size() / 2] - reading, 0.0);
  }
  return ticks;
}

double meanOf(const std::vector<double>& x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

void printRow(const Common& common, std::uint32_t triangles, const std::string& what, std::vector<double> ticks,
              double load) {
  const double mean = meanOf(ticks);
  std::sort(ticks.begin(), ticks.end());
  const char* form = common.csv ? "{},{},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.2f}\n"
                                : "{:>9}  {:<12} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.1f}\n";
  fmt::print(fmt::runtime(form), triangles, what, mean, nearestRank(ticks, 0.5), nearestRank(ticks, 0.99),
             nearestRank(ticks, 0.999), ticks.back(), load);
  std::fflush(stdout);
}

/** The stroke once more, counted instead of timed. */
Looked counted(Stage& stage, const MeshStroke& stroke, double radius) {
  Looked looked;
  const Surroundings& around = stage.renderer().surroundings();
  stage.begin(radius);
  const std::uint64_t at_once = around.gatheredAtOnce(), ahead = around.gatheredAhead();
  for (std::size_t i = 0; i < stroke.ticks(); ++i) {
    stage.tick(i);
    const ProxyEffort& effort = stage.renderer().effort();
    looked.sweeps.push_back(effort.sweeps);
    looked.visited.push_back(effort.visited);
    looked.gathered.push_back(effort.gathered);
  }
  looked.at_once = static_cast<double>(around.gatheredAtOnce() - at_once);
  looked.ahead = static_cast<double>(around.gatheredAhead() - ahead);
  return looked;
}

void printLooked(const Common& common, const Looked& looked) {
  if (common.csv) return;
  const auto each = [](std::vector<double> x) {
    const double mean = meanOf(x);
    std::sort(x.begin(), x.end());
    return fmt::format("{:.1f} ({:.0f}, {:.0f})", mean, nearestRank(x, 0.99), x.back());
  };
  const double share = 1e3 / static_cast<double>(looked.sweeps.size());
  fmt::print(
      "#   a tick, mean (p99, max): sweeps {}, nodes and triangles {}, gathered {}; "
      "of 1000 ticks {:.1f} gather at once, {:.1f} have it ready\n",
      each(looked.sweeps), each(looked.visited), each(looked.gathered), share * looked.at_once, share * looked.ahead);
}

void writeProfile(const std::string& path, std::uint32_t triangles, double radius_mm, const std::vector<double>& ticks,
                  const Looked& looked) {
  std::ofstream file(path, std::ios::app | std::ios::ate);
  if (file.tellp() == 0) file << "triangles,radius_mm,tick,time_ns,sweeps,visited,gathered\n";
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    file << fmt::format("{},{},{},{:.0f},{},{},{}\n", triangles, radius_mm, i, ticks[i], looked.sweeps[i],
                        looked.visited[i], looked.gathered[i]);
  }
  if (!file.flush()) throw Failure(path, "it could not be written whole", "make room on the disk");
}

/** A ball from above the surface, clear of its slopes, to `kStrokeDepth` below it, a tick further on. */
std::vector<double> timedSweeps(const Common& common, const MeshStroke& stroke, const MeshView& mesh, double radius) {
  return timed(
      common, stroke, [] {},
      [&](std::size_t i) {
        Sweep sweep;
        sweep.a = stroke.at(i, 2 * radius + kStrokeAbove);
        sweep.d = stroke.at(i + 1, radius - kStrokeDepth) - sweep.a;
        sweep.radius = radius;
        sweep.limit = ProxyRenderer::kMaxWork;
        SweepHit hit;
        if (sweepMesh(mesh, sweep, hit) != SweepResult::kHit) throw Failure("stroke", "a sweep met nothing", "");
      });
}

std::vector<double> timedNearest(const Common& common, const MeshStroke& stroke, const MeshView& mesh) {
  return timed(
      common, stroke, [] {},
      [&](std::size_t i) {
        NearestQuery query;
        query.x = stroke.at(i, -kStrokeDepth);
        query.limit = ProxyRenderer::kMaxWork;
        Nearest nearest;
        if (nearestOnMesh(mesh, query, nearest) != NearestResult::kFound)
          throw Failure("stroke", "no point of the mesh is near", "");
      });
}

double cpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void measure(const Common& common, const CostOptions& options, std::uint32_t triangles) {
  const std::vector<std::byte> upload = bumpySphereUpload(triangles);
  BuildMonitor monitor;
  const double before = cpuSeconds();
  auto built = buildSnapshot(upload, monitor);
  const double build_s = cpuSeconds() - before;
  if (!built) throw Failure(built.error());
  const auto bytes = static_cast<std::size_t>(built->stats.bytes);
  const std::uint32_t count = built->stats.triangles;
  auto memory = openSnapshot(std::move(*built->memfd.share()), false);
  if (!memory) throw Failure(memory.error());
  const double load = chase(bytes);
  fmt::print("# {} triangles: {:.2f} MB, tree {} deep, built in {:.3f} s of processor time\n", count,
             static_cast<double>(bytes) / 1e6, built->stats.depth, build_s);
  const MeshStroke stroke(memory->view, options.seconds, options.speed);
  Stage stage(memory->view, stroke);
  for (const double radius : options.radii_mm) {
    const auto ticks = timed(
        common, stroke, [&] { stage.begin(radius / 1e3); }, [&](std::size_t i) { stage.tick(i); });
    if (!stage.ok() || !stage.touched()) throw Failure("stroke", "the hand left the surface", "");
    printRow(common, count, fmt::format("tick {} mm", radius), ticks, load);
    const Looked looked = counted(stage, stroke, radius / 1e3);
    printLooked(common, looked);
    if (!options.profile.empty()) writeProfile(options.profile, count, radius, ticks, looked);
  }
  ServoStage servo(memory->view, stroke);
  for (const double radius : options.radii_mm) {
    const auto ticks = timed(
        common, stroke, [&] { servo.begin(radius / 1e3); }, [&](std::size_t i) { servo.tick(i); });
    if (!servo.touched()) throw Failure("stroke", "the hand left the surface, or the servo was not armed", "");
    printRow(common, count, fmt::format("servo {} mm", radius), ticks, load);
  }
  for (const double radius : options.radii_mm) {
    printRow(common, count, fmt::format("sweep {} mm", radius), timedSweeps(common, stroke, memory->view, radius / 1e3),
             load);
  }
  printRow(common, count, "nearest", timedNearest(common, stroke, memory->view), load);
}

int run(const Common& common, const CostOptions& options) {
  if (!options.profile.empty() && !std::ofstream(options.profile, std::ios::app)) {
    throw Failure(options.profile, "it cannot be written", "see the path and its rights");
  }
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  fmt::print("# stroke of {} s, {} mm deep at {} m/s, 1 kHz; of each tick the median of {} rounds [ns]; boxes: {}\n",
             options.seconds, kStrokeDepth * 1e3, options.speed, common.rounds, nameOf(vectorPath()));
  fmt::print("{}\n", common.csv ? "triangles,what,mean,median,p99,p99.9,max,chase"
                                : "triangles  what             mean   median      p99    p99.9      max    chase");
  for (const std::uint32_t n : options.triangles) measure(common, options, n);
  return 0;
}

}  // namespace

void addCost(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<CostOptions>();
  CLI::App* cost = app.add_subcommand("cost",
                                      "A tick of the renderer and of the whole servo, and their queries, on meshes of "
                                      "rising size, beside a pointer chase");
  cost->add_option("--triangles", options->triangles, "Sizes of the mesh")
      ->capture_default_str()
      ->check(CLI::Range(8, 8'000'000));
  cost->add_option("--radius", options->radii_mm, "Of the swept ball [mm]")
      ->capture_default_str()
      ->check(within(0.0, 10.0));
  cost->add_option("--seconds", options->seconds, "Of stroke")->capture_default_str()->check(within(0.1, 600.0));
  cost->add_option("--speed", options->speed, "Of the hand [m/s]")->capture_default_str()->check(within(0.001, 1.0));
  cost->add_option("--profile", options->profile,
                   "CSV to which each tick is appended: time, sweeps, nodes and triangles visited, and those gathered");
  cost->callback([&chosen, options] { chosen = [options](const Common& common) { return run(common, *options); }; });
}

}  // namespace haptic_bench
