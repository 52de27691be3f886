/** @file
 * haptic-bench cost: what a tick of the renderer, the servo's whole tick about it and the queries in it cost on meshes
 * from a thousand to a million triangles, beside a pointer chase over as many bytes, by which another machine can be
 * judged.
 *
 * A stroke of 10 s over a bumpy sphere, 1 mm deep at 0.1 m/s (or --speed) and 1 kHz, is done again and again; it is the
 * same to the bit each time. So the table can show the median over the rounds of each single tick, which is free of
 * what else the machine did. A CSV holds median, mean and tails of each round, by which compare judges; a round does
 * the stroke twice for them.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <deque>
#include <fstream>
#include <numeric>

#include "rt/geometry/tree/boxes.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/cost/bumpy_sphere.h"
#include "tools/haptic-bench/cost/deeper_stack.h"
#include "tools/haptic-bench/cost/mesh_cost.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/metric/quantile.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {
namespace {

constexpr int kStackSteps = 13;  // A page.

double medianOf(const Series& series) { return estimate(series.rounds).median; }

/** Mean, 99th percentile and maximum of what each tick looked at. */
struct Spread {
  double mean = 0, p99 = 0, max = 0;
};

Spread spreadOf(std::vector<double> x) {
  const double mean = std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
  std::sort(x.begin(), x.end());
  return {mean, nearestRank(x, 0.99), x.back()};
}

void printRow(std::uint32_t triangles, const TickTimes& times, double load) {
  const TickSummary steady = summariseTicks(times.medians());
  fmt::print("{:>9}  {:<12} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.0f} {:>8.1f}\n", triangles, times.name(),
             steady.mean, steady.median, steady.p99, steady.p999, steady.max, load);
}

void printLooked(const Looked& looked) {
  const auto each = [](const std::vector<double>& x) {
    const Spread spread = spreadOf(x);
    return fmt::format("{:.1f} ({:.0f}, {:.0f})", spread.mean, spread.p99, spread.max);
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

void addCounts(std::vector<Series>& all, const std::string& name, const Looked& looked) {
  const auto add = [&](const char* what, const std::vector<double>& each) {
    const Spread spread = spreadOf(each);
    all.push_back({fmt::format("{} {}, mean", name, what), kCountedUnit, {spread.mean}});
    all.push_back({fmt::format("{} {}, max", name, what), kCountedUnit, {spread.max}});
  };
  add("sweeps", looked.sweeps);
  add("nodes and triangles", looked.visited);
  add("gathered", looked.gathered);
}

/** One mesh's table or results. */
void print(const Common& common, const CostOptions& options, MeshCost& mesh) {
  std::vector<Series> all{{"snapshot", "byte", {static_cast<double>(mesh.bytes())}}, mesh.builds(), mesh.chases()};
  if (!common.csv) {
    fmt::print("# {} triangles: {:.2f} MB, tree {} deep, built in {:.3f} s of processor time\n", mesh.triangles(),
               static_cast<double>(mesh.bytes()) / 1e6, mesh.depth(), medianOf(mesh.builds()) / 1e3);
  }
  const std::vector<TickTimes>& times = mesh.times();
  for (std::size_t i = 0; i < times.size(); ++i) {
    for (Series& s : times[i].series()) all.push_back(std::move(s));
    if (!common.csv) printRow(mesh.triangles(), times[i], medianOf(mesh.chases()));
    if (i >= options.radii_mm.size()) continue;
    const double radius_mm = options.radii_mm[i];
    const Looked looked = mesh.count(radius_mm);
    addCounts(all, times[i].name(), looked);
    if (!common.csv) printLooked(looked);
    if (!options.profile.empty())
      writeProfile(options.profile, mesh.triangles(), radius_mm, times[i].medians(), looked);
  }
  // The whole stroke is part of the name: one of another speed or length meets other ticks.
  if (common.csv) {
    printRounds(fmt::format("cost {} triangles {} m/s {} s", mesh.triangles(), options.speed, options.seconds), all);
  }
}

int run(const Common& common, CostOptions options) {
  options.radii_mm = distinct(options.radii_mm);
  if (!options.profile.empty() && !std::ofstream(options.profile, std::ios::app)) {
    throw Failure(options.profile, "it cannot be written", "see the path and its rights");
  }
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  fmt::print("# stroke of {} s, {} mm deep at {} m/s, 1 kHz; {}; boxes: {}\n", options.seconds, kStrokeDepth * 1e3,
             options.speed,
             common.csv ? "median, mean and tails of each round"
                        : fmt::format("of each tick the median of {} round{} [ns]", common.rounds,
                                      common.rounds == 1 ? "" : "s"),
             hapticd::nameOf(hapticd::vectorPath()));
  if (common.csv) {
    fmt::print("{}\n", kResultsHeader);
  } else {
    fmt::print("triangles  what             mean   median      p99    p99.9      max    chase\n");
  }
  std::fflush(stdout);
  for (std::uint32_t& n : options.triangles) n = bumpySphereTriangles(n);
  std::deque<MeshCost> meshes;
  for (const std::uint32_t n : distinct(options.triangles)) {
    meshes.emplace_back(n, options);
  }
  // The meshes take turns, so that what disturbs the machine for a while is not in all rounds of one.
  for (int round = 0; round < common.rounds; ++round) {
    withDeeperStack(round % kStackSteps, [&] {
      for (MeshCost& mesh : meshes) mesh.round();
    });
  }
  for (MeshCost& mesh : meshes) print(common, options, mesh);
  return 0;
}

}  // namespace

void addCost(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<CostOptions>();
  CLI::App* cost = app.add_subcommand("cost",
                                      "A tick of the renderer and of the whole servo, and their queries, on meshes of "
                                      "rising size, beside a pointer chase");
  bounded(cost, "--triangles", options->triangles, "Sizes of the mesh", 8, 8'000'000);
  bounded(cost, "--radius", options->radii_mm, "Radius of the swept ball [mm]", 0.0, 10.0);
  bounded(cost, "--seconds", options->seconds, "Length of the stroke [s]", 0.1, 600.0);
  bounded(cost, "--speed", options->speed, "Speed of the hand [m/s]", 0.001, 1.0);
  cost->add_option("--profile", options->profile,
                   "CSV to which each tick is appended: time, sweeps, nodes and triangles visited, and those gathered");
  whenNamed(cost, chosen, [options](const Common& common) { return run(common, *options); });
}

}  // namespace haptic_bench
