/** @file
 * haptic-bench load: figure 5.11 of the thesis for today. The servo's period and the error of the force under six
 * levels of load, on three meshes, by the native scene, by local models and by forces that a client computes.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "rt/base/standard_streams.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/interrupt.h"
#include "tools/haptic-bench/load/live.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {
namespace {

struct LoadOptions {
  std::vector<std::uint32_t> triangles{3'000, 64'000, 137'000};
  std::vector<double> rates_hz{10, 30, 100, 300, 1000};
  std::vector<std::string> levels;
  double seconds = 1;
  std::string daemon;
};

/** The series of one cell, a value for each round. */
struct Cell {
  std::string name;
  std::vector<LiveResult> rounds;
};

void addSeries(const Cell& cell, std::vector<Series>& all) {
  const auto add = [&](const char* quantity, const char* unit, double LiveResult::*value, double scale) {
    Series series{cell.name + ": " + quantity, unit, {}};
    for (const LiveResult& r : cell.rounds) series.rounds.push_back(scale * r.*value);
    all.push_back(series);
  };
  add("period mean", "us", &LiveResult::period_mean_us, 1);
  add("period p99", "us", &LiveResult::period_p99_us, 1);
  add("period max", "us", &LiveResult::period_max_us, 1);
  add("missed periods", "", &LiveResult::missed, 1);
  add("force error rms", "%", &LiveResult::force_rms, 100);
  add("mean force", "N", &LiveResult::mean_force, 1);
  if (cell.rounds.front().client_period_mean_us == 0) return;
  add("client period mean", "us", &LiveResult::client_period_mean_us, 1);
  add("client period max", "us", &LiveResult::client_period_max_us, 1);
}

void printCells(const Common& common, const LoadOptions& options, const std::vector<Cell>& cells) {
  std::vector<Series> all;
  for (const Cell& cell : cells) addSeries(cell, all);
  print(common, "load", all, fmt::format("runs of {} s", options.seconds));
}

int runLoad(const Common& common, const LoadOptions& options) {
  std::vector<Level> levels;
  for (const Level level : kLevels) {
    const auto& wanted = options.levels;
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), nameOf(level)) != wanted.end())
      levels.push_back(level);
  }

  const std::vector<std::uint32_t> all_triangles = distinct(options.triangles);
  const std::vector<double> rates_hz = distinct(options.rates_hz);

  const Interrupts interrupts;
  std::vector<Cell> cells;
  std::size_t at = 0;
  const auto measure = [&](const LiveDaemon& daemon, const Model& model, Source source, double rate_hz, Level level) {
    if (at == cells.size()) {
      cells.push_back({fmt::format("{} triangles, {}, {}", model.triangles.size(), nameOf(level), nameOf(source)), {}});
      if (source != Source::kNative) cells.back().name += fmt::format(" {:g} Hz", rate_hz);
    }
    try {
      cells[at].rounds.push_back(runLive(daemon, model, source, rate_hz, level, options.seconds));
    } catch (const Failure&) {
      if (cells.back().rounds.empty()) cells.pop_back();
      printCells(common, options, cells);  // Minutes of measurements are not thrown away for one that failed.
      throw;
    }
    const LiveResult& last = cells[at].rounds.back();
    hapticd::tellError(fmt::format("{}: period p99 {:.0f} us, force error {:.3g} %\n", cells[at].name,
                                   last.period_p99_us, 100 * last.force_rms));
    ++at;
  };
  for (int round = 0; round < common.rounds; ++round) {
    at = 0;
    for (const std::uint32_t triangles : all_triangles) {
      const Model model = tessellate({0.05, 0.02}, triangles);
      const LiveDaemon daemon(options.daemon);
      for (const Level level : levels) {
        measure(daemon, model, Source::kNative, 0, level);
        for (const Source source : {Source::kPlane, Source::kPatch, Source::kForce}) {
          for (const double rate_hz : rates_hz) measure(daemon, model, source, rate_hz, level);
        }
      }
    }
  }
  printCells(common, options, cells);
  return 0;
}

}  // namespace

void addLoad(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<LoadOptions>();
  CLI::App* load = app.add_subcommand(
      "load", "Servo period and force error under six levels of load, on a daemon and clients of its own");
  bounded(load, "--triangles", options->triangles, "Triangles of the meshes", 100, 8'000'000);
  bounded(load, "--rates", options->rates_hz, "Clients' rates [Hz]", 1.0, 1000.0);
  load->add_option("--levels", options->levels, "Loads to measure under; all unless given")
      ->check(CLI::IsMember({"idle", "graphics", "uploads", "clients", "disk", "busy"}));
  bounded(load, "--seconds", options->seconds, "Length of each run [s]", 0.1, 600.0);
  load->add_option("--daemon", options->daemon,
                   "Path of hapticd; else the one built or installed with this, else of $PATH");
  whenNamed(load, chosen, [options](const Common& common) { return runLoad(common, *options); });
}

}  // namespace haptic_bench
