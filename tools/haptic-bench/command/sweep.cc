// haptic-bench sweep: algorithms over stiffness, friction and speed.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <set>

#include "tools/haptic-bench/algorithm/registry.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/side_by_side.h"
#include "tools/haptic-bench/trajectory/registry.h"
#include "tools/haptic-bench/trial/trial.h"

namespace haptic_bench {
namespace {

struct SweepOptions {
  std::vector<std::string> algorithms{"ours"};
  std::string model = "sphere", trajectory = "spiral";
  std::vector<double> stiffness{100, 300, 1000, 3000}, friction{0}, speed{1};
  FileOptions file;
  double threshold = 0.0005;
};

/** Throws Failure for a value that is named twice: its results could not be told apart. */
void requireOnce(const char* option, const std::vector<double>& values) {
  std::set<double> seen;
  for (const double value : values) {
    if (!seen.insert(value).second)
      throw Failure(option, fmt::format("{} is named twice", value), "more --rounds repeat it");
  }
}

int run(const SweepOptions& options, const Common& common) {
  requireNames(options.algorithms);
  requireOnce("--stiffness", options.stiffness);
  requireOnce("--friction", options.friction);
  requireOnce("--speed", options.speed);
  const Model model = makeModel(options.model);
  struct Cell {
    std::string name;
    Trajectory trajectory;
  };
  std::deque<Cell> cells;
  std::deque<Trial> trials;  // One for each cell.
  for (const double k : options.stiffness) {
    for (const double mu : options.friction) {
      // The cone at rest is 1.25 times as wide as in motion.
      const Surface surface{k, 0, 1.25 * mu, mu};
      const Trajectory made = makeTrajectory(options.trajectory, model, surface, options.file);
      if (trials.empty()) requireAlgorithms(options.algorithms, model, made, surface);
      for (const double speed : options.speed) {
        for (const std::string& algorithm : options.algorithms) {
          cells.push_back({fmt::format("{} k={} mu={} speed={}", algorithm, k, mu, speed),
                           speed == 1 ? made : atSpeed(made, speed)});
          trials.emplace_back(algorithm, model, cells.back().trajectory, surface);
        }
      }
    }
  }
  runRounds(trials, common.rounds);
  std::vector<Contender> all;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    all.push_back(
        {cells[i].name, describe(cells[i].name, cells[i].trajectory, trials[i].outcome(), options.threshold)});
  }
  printSideBySide(common, fmt::format("sweep {} {}", model.name, cells.front().trajectory.name), all);
  tellDoubts(trials);
  return 0;
}

}  // namespace

void addSweep(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<SweepOptions>();
  CLI::App* sub = app.add_subcommand("sweep", "Algorithms over ranges of stiffness, friction and speed");
  sub->add_option("-a,--algorithm", options->algorithms, "As for run; several")->capture_default_str();
  sub->add_option("-m,--model", options->model, "As for run")->capture_default_str();
  sub->add_option("-t,--trajectory", options->trajectory, "As for run")->capture_default_str();
  addFileOptions(*sub, options->file);
  bounded(sub, "--stiffness", options->stiffness, "N/m; several, parted by commas or blanks", 1e-3, 1e5)
      ->delimiter(',');
  bounded(sub, "--friction", options->friction, "Dynamic coefficient; several. At rest 1.25 times that", 0.0, 5.0)
      ->delimiter(',');
  bounded(sub, "--speed", options->speed, "Times that of the trajectory; several", 0.01, 1000.0)->delimiter(',');
  addThreshold(*sub, options->threshold);
  whenNamed(sub, chosen, [options](const Common& common) { return run(*options, common); });
}

}  // namespace haptic_bench
