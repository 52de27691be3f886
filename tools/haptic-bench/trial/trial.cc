#include "tools/haptic-bench/trial/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "rt/base/standard_streams.h"
#include "tools/haptic-bench/algorithm/registry.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

using SteadyClock = std::chrono::steady_clock;

std::int64_t ns(SteadyClock::duration d) { return std::chrono::duration_cast<std::chrono::nanoseconds>(d).count(); }

/** Answers and times of one run. */
void runOnce(const std::string& name, Algorithm& algorithm, const Trajectory& trajectory, std::vector<Answer>& answers,
             std::vector<std::int64_t>& step_ns) {
  algorithm.start(trajectory.start);
  const double period = trajectory.period_s();
  for (std::size_t i = 0; i < trajectory.samples.size(); ++i) {
    const Sample& s = trajectory.samples[i];
    const double dt = i == 0 ? period : s.t_s - trajectory.samples[i - 1].t_s;
    const Vec3 v = i == 0 ? Vec3(Vec3::Zero()) : Vec3((s.hip - trajectory.samples[i - 1].hip) / dt);
    haptic_algorithm_contact contact{};
    PluginWatch::atSample(i + 1);
    const SteadyClock::time_point begin = SteadyClock::now();
    try {
      algorithm.step(s.hip, v, dt, contact);
    } catch (const Failure& failure) {
      throw Failure(fmt::format("{}, at sample {} at {} s", failure.what(), i + 1, s.t_s));
    } catch (const std::exception& thrown) {
      throw Failure(name, fmt::format("it has thrown \"{}\" at sample {} at {} s", thrown.what(), i + 1, s.t_s),
                    "mend the algorithm: no function of it may throw");
    }
    step_ns[i] = ns(SteadyClock::now() - begin);
    answers[i] = {hapticd::vec3(contact.force), hapticd::vec3(contact.proxy), contact.touches != 0};
  }
  PluginWatch::atSample(0);
}

void requireFinite(const std::string& algorithm, const Trajectory& trajectory, const std::vector<Answer>& answers) {
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i].force.allFinite() && answers[i].proxy.allFinite()) continue;
    throw Failure(algorithm,
                  fmt::format("its answer to sample {} at {} s is not finite", i + 1, trajectory.samples[i].t_s),
                  "mend the algorithm");
  }
}

/** Points into the model. */
haptic_algorithm_problem problemOf(const Model& model, const Trajectory& trajectory, const Surface& surface) {
  haptic_algorithm_problem problem{};
  problem.vertices = reinterpret_cast<const float(*)[3]>(model.vertices.data());
  problem.triangles = reinterpret_cast<const std::uint32_t(*)[3]>(model.triangles.data());
  problem.vertex_count = static_cast<std::uint32_t>(model.vertices.size());
  problem.triangle_count = static_cast<std::uint32_t>(model.triangles.size());
  problem.stiffness = surface.stiffness;
  problem.damping = surface.damping;
  problem.friction_static = surface.friction_static;
  problem.friction_dynamic = surface.friction_dynamic;
  problem.radius = surface.radius;
  problem.period_s = trajectory.period_s();
  return problem;
}

double largestForce(const Trajectory& trajectory) {
  double most = 0;
  if (!trajectory.force_known) return most;
  for (const Sample& s : trajectory.samples) most = std::max(most, s.force.norm());
  return most;
}

}  // namespace

void requireAlgorithms(const std::vector<std::string>& algorithms, const Model& model, const Trajectory& trajectory,
                       const Surface& surface) {
  if (algorithms.size() < 2) return;
  const haptic_algorithm_problem problem = problemOf(model, trajectory, surface);
  for (const std::string& one : algorithms) (void)Algorithm(one, problem);
}

std::string refusal(const std::string& algorithm, const Model& model, const Trajectory& trajectory,
                    const Surface& surface) {
  try {
    (void)Algorithm(algorithm, problemOf(model, trajectory, surface));
    return {};
  } catch (const Failure& failure) {
    return failure.what();
  }
}

Trial::Trial(std::string algorithm, const Model& model, const Trajectory& trajectory, const Surface& surface)
    : algorithm_(std::move(algorithm)), model_(model), trajectory_(trajectory), surface_(surface) {}

void Trial::runRound() {
  const SteadyClock::time_point begin = SteadyClock::now();
  Algorithm instance(algorithm_, problemOf(model_, trajectory_, surface_));
  outcome_.init_s.push_back(1e-9 * static_cast<double>(ns(SteadyClock::now() - begin)));
  std::vector<Answer> answers(trajectory_.samples.size());
  std::vector<std::int64_t> step_ns(trajectory_.samples.size());
  runOnce(algorithm_, instance, trajectory_, answers, step_ns);
  requireFinite(algorithm_, trajectory_, answers);
  outcome_.rounds.push_back(summarise(step_ns));
  outcome_.bytes = instance.bytes();
  if (outcome_.rounds.size() == 1) {
    outcome_.answers = std::move(answers);
    outcome_.step_ns = std::move(step_ns);
    return;
  }
  for (std::size_t i = 0; i < answers.size(); ++i)
    outcome_.repeats = outcome_.repeats && answers[i].force == outcome_.answers[i].force;
}

void runRounds(std::deque<Trial>& trials, int rounds) {
  for (int round = 0; round < rounds; ++round)
    for (Trial& trial : trials) trial.runRound();
}

void tellDoubts(const std::deque<Trial>& trials) {
  std::set<std::string> told;
  for (const Trial& trial : trials) {
    if (trial.outcome().repeats || !told.insert(trial.algorithm()).second) continue;
    hapticd::tellError(fmt::format(
        "haptic-bench: {}: its rounds differ in their forces: it depends on more than its input\n", trial.algorithm()));
  }
  double most = 0;
  for (const Trial& trial : trials) most = std::max(most, largestForce(trial.trajectory()));
  constexpr double kOfAHand = 100;  // [N]
  if (most > kOfAHand) {
    hapticd::tellError(fmt::format(
        "haptic-bench: the forces of the trajectory reach {:.3g} N, more than a hand bears (a column's unit "
        "stands behind its name, as in fx_mN)\n",
        most));
  }
  const auto felt = [](const Answer& a) { return !a.force.isZero(0); };
  const auto feels = [&](const Trial& trial) {
    return std::any_of(trial.outcome().answers.begin(), trial.outcome().answers.end(), felt);
  };
  if (std::none_of(trials.begin(), trials.end(), feels))
    hapticd::tellError("haptic-bench: no force in any sample (the units of the columns, and where the model stands)\n");
}

Outcome runTrial(const std::string& algorithm, const Model& model, const Trajectory& trajectory, const Surface& surface,
                 int rounds) {
  std::deque<Trial> one;
  one.emplace_back(algorithm, model, trajectory, surface);
  runRounds(one, rounds);
  return one.front().outcome();
}

std::vector<Series> describe(const std::string& name, const Trajectory& trajectory, const Outcome& outcome,
                             double threshold) {
  const Accuracy a = judge(trajectory, outcome.answers, threshold);
  std::vector<Series> all;
  const auto one = [&](const std::string& what, const char* unit, double value) {
    all.push_back({name + " " + what, unit, {value}});
  };
  if (trajectory.force_known) {
    one("force MSE", "N^2", a.force_mse);
    one("energy error", "J", a.energy_error);
  }
  if (trajectory.proxy_known) {
    one("proxy RMS", "m", a.proxy_rms);
    one("proxy max", "m", a.proxy_max);
    one(fmt::format("above {} m", threshold), "samples", static_cast<double>(a.above));
  }
  one("forces", "hash", static_cast<double>(a.hash));
  const auto timed = [&](const char* what, double Timing::*which) {
    Series s{name + " " + what, "ns", {}};
    for (const Timing& t : outcome.rounds) s.rounds.push_back(t.*which);
    all.push_back(std::move(s));
  };
  timed("mean", &Timing::mean);
  timed("median", &Timing::median);
  timed("p99", &Timing::p99);
  timed("p99.9", &Timing::p999);
  timed("max", &Timing::max);
  all.push_back({name + " init", "s", outcome.init_s});
  if (outcome.bytes != 0) one("memory", "byte", static_cast<double>(outcome.bytes));
  return all;
}

}  // namespace haptic_bench
