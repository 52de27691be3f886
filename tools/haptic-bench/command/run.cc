// haptic-bench run: algorithms over a trajectory on a model.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <optional>

#include "tools/haptic-bench/algorithm/registry.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/result/results.h"
#include "tools/haptic-bench/side_by_side.h"
#include "tools/haptic-bench/spec.h"
#include "tools/haptic-bench/trajectory/registry.h"
#include "tools/haptic-bench/trial/trial.h"
#include "tools/haptic-bench/whole_file.h"

namespace haptic_bench {
namespace {

struct RunOptions {
  std::vector<std::string> algorithms{"ours", "nearest"};
  std::string model = "sphere";
  std::string trajectory = "spiral";
  Surface surface;
  double threshold = 0.0005;
  FileOptions file;
  std::string samples;
};

/** The files that are read, among other names. */
std::vector<std::string> inputs(const RunOptions& options) {
  std::vector<std::string> names{Spec(options.model).name(), options.trajectory};
  if (options.trajectory.rfind("measured:", 0) != 0) return names;
  Spec measured(options.trajectory);
  for (const char* stream : {"forces", "poses"}) names.push_back(measured.word(stream, ""));
  return names;
}

/** Every sample and what each algorithm made of it. */
void writeSamples(WholeFile& to, const Trajectory& trajectory, const std::deque<Trial>& trials) {
  std::ofstream file(to.part());
  const auto columns = [&](const std::string& prefix) {
    for (const char axis : {'x', 'y', 'z'}) file << ',' << csvField(prefix + axis);
  };
  const auto values = [&](const Vec3& x) { file << fmt::format(",{},{},{}", x.x(), x.y(), x.z()); };
  file << "t_s";
  columns("");
  if (trajectory.proxy_known) columns("proxy_");
  if (trajectory.force_known) columns("f");
  const bool all_judged =
      std::all_of(trajectory.samples.begin(), trajectory.samples.end(), [](const Sample& s) { return s.judged; });
  if (!all_judged) file << ",judged";
  for (const Trial& trial : trials) {
    columns(trial.algorithm() + "_f");
    columns(trial.algorithm() + "_proxy_");
    file << ',' << csvField(trial.algorithm() + "_step_ns");
  }
  file << '\n';
  for (std::size_t i = 0; i < trajectory.samples.size(); ++i) {
    const Sample& s = trajectory.samples[i];
    file << fmt::format("{}", s.t_s);
    values(s.hip);
    if (trajectory.proxy_known) values(s.proxy);
    if (trajectory.force_known) values(s.force);
    if (!all_judged) file << (s.judged ? ",1" : ",0");
    for (const Trial& trial : trials) {
      values(trial.outcome().answers[i].force);
      values(trial.outcome().answers[i].proxy);
      file << ',' << trial.outcome().step_ns[i];
    }
    file << '\n';
  }
  if (!file.flush()) throw Failure(to.part(), "it could not be written whole", "make room on the disk");
  to.keep();
}

int run(const RunOptions& options, const Common& common) {
  checkSurface(options.surface);
  requireNames(options.algorithms);
  for (const std::string& input : inputs(options)) refuseToReplace(input, options.samples);
  const Model model = makeModel(options.model);
  const Trajectory trajectory = makeTrajectory(options.trajectory, model, options.surface, options.file);
  requireAlgorithms(options.algorithms, model, trajectory, options.surface);
  std::optional<WholeFile> samples;
  if (!options.samples.empty()) samples.emplace(options.samples);
  std::vector<Contender> all;
  all.reserve(options.algorithms.size());
  std::deque<Trial> trials;
  for (const std::string& algorithm : options.algorithms)
    trials.emplace_back(algorithm, model, trajectory, options.surface);
  runRounds(trials, common.rounds);
  for (const Trial& trial : trials)
    all.push_back({trial.algorithm(), describe(trial.algorithm(), trajectory, trial.outcome(), options.threshold)});
  std::string what =
      fmt::format("run {} {} k={} mu_s={} mu_d={} b={}", model.name, trajectory.name, options.surface.stiffness,
                  options.surface.friction_static, options.surface.friction_dynamic, options.surface.damping);
  if (options.surface.radius > 0) what += fmt::format(" r={}", options.surface.radius);
  printSideBySide(common, what, all);
  if (samples) writeSamples(*samples, trajectory, trials);
  tellDoubts(trials);
  return 0;
}

}  // namespace

void addRun(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* sub = app.add_subcommand("run", "Algorithms over a trajectory on a model");
  sub->footer(modelHelp() + trajectoryHelp() + algorithmHelp());
  sub->add_option("-a,--algorithm", options->algorithms, "Name or shared object, with :settings; several")
      ->capture_default_str();
  sub->add_option("-m,--model", options->model, "Shape or mesh file")->capture_default_str();
  sub->add_option("-t,--trajectory", options->trajectory, "Generator or file")->capture_default_str();
  addFileOptions(*sub, options->file);
  addSurface(*sub, options->surface);
  addThreshold(*sub, options->threshold);
  sub->add_option("--samples", options->samples, "CSV file for every sample, answer and time of a step");
  whenNamed(sub, chosen, [options](const Common& common) { return run(*options, common); });
}

}  // namespace haptic_bench
