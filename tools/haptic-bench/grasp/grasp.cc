/** @file
 * haptic-bench grasp: chapter 2 of the thesis with simulated hands. How firmly are cubes held, and how do blocks turn
 * and slide between two fingers that let them go?
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <fstream>
#include <memory>
#include <numbers>
#include <optional>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/grasp/goals.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/result/tables.h"
#include "tools/haptic-bench/whole_file.h"

namespace haptic_bench {
namespace {

using namespace grasp;  // NOLINT(google-build-using-namespace)

constexpr double kDegrees = 180 / std::numbers::pi;

struct GraspOptions {
  std::string experiment;  ///< Empty: all.
  int persons = 3;
  int turns = 2;
  double unsteady_mm = 0.2;
  std::string samples;
  bool quick = false;
  bool check = false;

  [[nodiscard]] bool wants(const char* name) const { return experiment.empty() || experiment == name; }
};

const char* conditionOf(bool coupled) { return coupled ? "coupled" : "uncoupled"; }

bool printGoals(const Common& common, const std::vector<Goal>& goals) {
  bool met = true;
  for (const Goal& goal : goals) {
    fmt::print("{}{}: {}\n", common.csv ? "# " : "", goal.name, goal.met ? "yes" : "NO");
    met = met && goal.met;
  }
  return met;
}

bool cubes(const Common& common, const GraspOptions& o) {
  const std::vector<Cube> all = holdCubes(o.persons, o.turns, o.unsteady_mm * 1e-3);
  if (common.csv) {
    fmt::print("{}\n{}\n", settingsLine("grasp-cubes", fmt::format("fingers unsteady by {} mm", o.unsteady_mm)),
               tableForm("grasp-cubes").header());
  } else {
    fmt::print("\nThe 27 cubes, held by {} person{}, {} time{} each\n", o.persons, o.persons == 1 ? "" : "s", o.turns,
               o.turns == 1 ? "" : "s");
    fmt::print("{:>8} {:>8} {:>9} {:>9} {:>9} {:>9} {:>8}\n", "mass kg", "friction", "k N/m", "slips N", "fell N",
               "held N", "margin");
  }
  for (const Cube& cube : all) {
    if (!common.csv) {
      fmt::print("{:>8g} {:>8g} {:>9g} {:>9.3f} {:>9.3f} {:>9.3f} {:>6.0f} %\n", cube.mass, cube.friction,
                 cube.stiffness, cube.slips, cube.mean().fell, cube.mean().held, 100 * cube.margin());
      continue;
    }
    int number = 0;
    for (const Hold& one : cube.holds) {
      fmt::print("{:g},{:g},{:g},{},{:.6g},{:.6g},{:.6g}\n", cube.mass, cube.friction, cube.stiffness, ++number,
                 cube.slips, one.fell / cube.slips, one.held);
    }
  }
  const Correlations ours = correlate(all);
  const char* const mark = common.csv ? "# " : "";
  fmt::print("{0}rank correlation of the grip force (table 2.2: three men)   ours   thesis\n", mark);
  for (const auto& [name, here, there] : {std::tuple{"friction", ours.friction, kThesis.friction},
                                          {"mass", ours.mass, kThesis.mass},
                                          {"stiffness", ours.stiffness, kThesis.stiffness}})
    fmt::print("{}  {:54} {:8.3f} {:8.3f}\n", mark, name, here, there);
  return printGoals(common, judge(all));
}

/** The moments of all releases, every hundredth of a second, as CSV. */
class Samples {
 public:
  explicit Samples(const std::string& path) {
    if (!path.empty()) file_.emplace(path);
  }
  void add(const Release& r, const Moment& m) {
    if (file_ && ticks_++ % 10 == 0) {
      text_ += fmt::format("{},{:g},{:g},{:.3f},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", conditionOf(r.coupled), r.arm,
                           r.lever, m.t, m.y, m.z, m.turned, m.slid, m.grip);
    }
  }
  void keep() {
    if (!file_) return;
    std::ofstream out(file_->part());
    out << text_;
    out.close();
    if (!out) throw Failure(file_->part(), "not all could be written", "make room where it goes");
    file_->keep();
  }

 private:
  std::optional<WholeFile> file_;
  std::string text_ = "condition,arm_m,lever_m,t,y,z,turned_rad,slid_m,grip_n\n";
  std::uint64_t ticks_ = 0;
};

bool release(const Common& common, Samples& samples) {
  const std::vector<Release> all = releases([&](const Release& r, const Moment& m) { samples.add(r, m); });
  if (common.csv) {
    fmt::print("{}\n", tableForm("grasp-release").header());
  } else {
    fmt::print("\nA bar of 0.2 kg is let go, held so far from its centre of mass (lengths in mm)\n");
    fmt::print("{:>10} {:>6} {:>6} {:>9} {:>9} | {:>9} {:>9} | {:>13}\n", "friction", "L_0", "L", "closed N",
               "yields N", "slid, 10\u00b0", "slid, 30\u00b0", "turned, 5 mm");
  }
  const auto number = [](double x, double unit) { return std::isnan(x) ? "-" : fmt::format("{:.2f}", x * unit); };
  for (const Release& r : all) {
    if (common.csv) {
      fmt::print("{},{:g},{:g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", conditionOf(r.coupled), r.arm, r.lever, r.closed,
                 r.yields / r.closed, r.slid_10, r.slid_30, r.turned_5);
    } else {
      fmt::print("{:>10} {:>6.2f} {:>6.2f} {:>9.3f} {:>9.3f} | {:>9} {:>9} | {:>12}\u00b0\n", conditionOf(r.coupled),
                 1e3 * r.arm, 1e3 * r.lever, r.closed, r.yields, number(r.slid_10, 1e3), number(r.slid_30, 1e3),
                 number(r.turned_5, kDegrees));
    }
  }
  samples.keep();
  return printGoals(common, judge(all));
}

bool align(const Common& common, const GraspOptions& o) {
  const std::vector<Alignment> all = alignments(o.persons, o.unsteady_mm * 1e-3);
  if (common.csv) {
    fmt::print("{}\n{}\n", settingsLine("grasp-align", fmt::format("fingers unsteady by {} mm", o.unsteady_mm)),
               tableForm("grasp-align").header());
  } else {
    fmt::print("\nBars of 0.05, 0.1 and 0.2 kg are let turn to an angle, by {} person{} (medians)\n", o.persons,
               o.persons == 1 ? "" : "s");
    fmt::print("{:>10} {:>6} {:>8} | {:>7} {:>8} {:>11}\n", "friction", "L mm", "wanted", "off", "slid mm", "lost");
  }
  for (const Alignment& one : all) {
    if (!common.csv) {
      fmt::print("{:>10} {:>6g} {:>7.0f}\u00b0 | {:>6.1f}\u00b0 {:>8.1f} {:>5} of {:>2}\n", conditionOf(one.coupled),
                 1e3 * one.lever, kDegrees * one.wanted, kDegrees * one.error(), 1e3 * one.slid(), one.lost(),
                 one.attempts.size());
      continue;
    }
    for (const Attempt& a : one.attempts) {
      fmt::print("{},{:g},{:.4g},{:g},{},{:.6g},{:.6g},{:.6g},{}\n", conditionOf(one.coupled), one.lever,
                 kDegrees * one.wanted, a.mass, a.person, kDegrees * a.off, kDegrees * std::abs(a.off), a.slid, a.lost);
    }
  }
  return printGoals(common, judge(all));
}

int run(const Common& common, GraspOptions o) {
  if (o.quick) o.persons = o.turns = 1;
  if (!o.samples.empty() && !o.wants("release")) {
    throw Failure("--samples", "they are of the releases, which are left out", "grasp release --samples FILE");
  }
  Samples samples(o.samples);
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  bool met = true;
  if (o.wants("cubes")) met = cubes(common, o) && met;
  std::fflush(stdout);
  if (o.wants("release")) met = release(common, samples) && met;
  std::fflush(stdout);
  if (o.wants("align")) met = align(common, o) && met;
  return o.check && !met ? 1 : 0;
}

}  // namespace

void addGrasp(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<GraspOptions>();
  CLI::App* sub = app.add_subcommand(
      "grasp", "Blocks between two fingers of simulated hands: how firmly they are held, how they slide and turn");
  sub->add_option("experiment", options->experiment, "cubes, release or align; all of them if none is named")
      ->check(CLI::IsMember({"cubes", "release", "align"}));
  bounded(sub, "--persons", options->persons, "Simulated persons, each with fingers unsteady in another way", 1, 1000);
  bounded(sub, "--turns", options->turns, "How often each holds each cube", 1, 1000);
  bounded(sub, "--unsteady", options->unsteady_mm, "How far fingers are from where they want to be, RMS [mm]", 0.0,
          0.5);
  sub->add_option("--samples", options->samples, "CSV file for the course of every release");
  sub->add_flag("--quick", options->quick, "One person and one turn");
  sub->add_flag("--check", options->check, "Exit 1 if something comes out otherwise than in the thesis");
  whenNamed(sub, chosen, [options](const Common& common) { return run(common, *options); });
}

}  // namespace haptic_bench
