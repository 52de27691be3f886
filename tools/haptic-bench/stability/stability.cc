/** @file
 * haptic-bench stability: tools that are dropped, pushed, jammed, spun and hammered on the simulated device with its
 * hand, by response, rate, mass and coupling: energy out of nothing, rest that is none, what creeps in a minute.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rt/body/constraint_response.h"
#include "rt/body/impulse_response.h"
#include "rt/body/penalty_response.h"
#include "rt/contact/point_field.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/collide/ours.h"
#include "tools/haptic-bench/collide/shapes.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/result/tables.h"
#include "tools/haptic-bench/stability/cases.h"

namespace haptic_bench {
namespace {

constexpr double kCreep = 10e-6;     ///< One encoder step [m].
constexpr double kCreepTurn = 1e-3;  ///< [rad]
constexpr double kCreated = 1e-9;    ///< Rounding [J].
constexpr double kCollide_hz = 500;  ///< Of volumes, as the daemon's collide thread asks.
constexpr const char* kFragment = "skull fragment";
constexpr const char* kVoxelPeg = "voxel peg";
constexpr const char* kDefault = "constraint";  ///< Of the responses.

struct StabilityOptions {
  bool quick = false, check = false;
  std::string pair, response;
  double voxel_mm = 0.5;
};

/** A pair with what finds its contacts. */
struct Pairing {
  StabilityPair pair;
  std::unique_ptr<BuiltVolume> tool, base;  ///< Null: closed forms.
  std::unique_ptr<Detector> detector;

  [[nodiscard]] std::unique_ptr<ToolRig> rig(double rate_hz, double mass, double stiffness, Response& response) {
    RigOptions o;
    o.rate_hz = rate_hz;
    o.mass = mass;
    o.stiffness = stiffness;
    o.size = pair.size;
    o.middle = pair.middle;
    if (tool != nullptr) {
      o.collide_every = static_cast<int>(rate_hz / kCollide_hz);
      o.late = o.collide_every / 2;
    }
    response.reset();
    return std::make_unique<ToolRig>(o, *detector, tool ? &tool->view : nullptr, base ? &base->view : nullptr,
                                     response);
  }
};

/** The halves of a broken block: rough faces that mate, as a fragment and its place do. */
Pairing fragment(double voxel) {
  Pairing s;
  s.pair = {kFragment, {}, {}, Vec3(0.06, 0.06, 0.02), {0, 0, 0.01}, {0, 0, 0.01}, 0.02};
  s.tool = std::make_unique<BuiltVolume>(fractureHalf(true), voxel, 2 * voxel, 48);
  s.base = std::make_unique<BuiltVolume>(fractureHalf(false), voxel, 2 * voxel, 48);
  s.detector = std::make_unique<PointFieldDetector>(1u << 14);
  return s;
}

/** The peg of haptic-bench collide, 20 mm thick, in a plate whose hole is 0.1 mm wider all around: its tip is held 15
 * mm deep, against friction. */
Pairing voxelPeg(double voxel) {
  Pairing s;
  s.pair = {kVoxelPeg, {}, {}, Vec3(0.02, 0.02, 0.06), {0, 0, 0.03}, {0, 0, 0.015}, 0.02, 60};
  s.tool = std::make_unique<BuiltVolume>(peg(), voxel, 2 * voxel, 48);
  s.base = std::make_unique<BuiltVolume>(plateWithHole(), voxel, 2 * voxel, 48);
  s.detector = std::make_unique<PointFieldDetector>(1u << 14);
  return s;
}

std::vector<Pairing> pairings(const StabilityOptions& o) {
  std::vector<Pairing> all;
  for (StabilityPair& pair : stabilityPairs()) {
    if (!o.pair.empty() && o.pair != pair.name) continue;
    Pairing s;
    s.detector = std::make_unique<AnalyticDetector>(pair.points, pair.field);
    s.pair = std::move(pair);
    all.push_back(std::move(s));
  }
  if (o.pair.empty() || o.pair == kFragment) all.push_back(fragment(o.voxel_mm * 1e-3));
  if (o.pair.empty() || o.pair == kVoxelPeg) all.push_back(voxelPeg(o.voxel_mm * 1e-3));
  return all;
}

std::vector<std::string> pairNames() {
  std::vector<std::string> names;
  for (const StabilityPair& pair : stabilityPairs()) names.emplace_back(pair.name);
  names.insert(names.end(), {kFragment, kVoxelPeg});
  return names;
}

/** All runs of one pair, excitation and response. */
struct SweepLine {
  int runs = 0, at_rest = 0;
  double created = -1, unrest = 0, strongest = 0;
  double patience = 0;  ///< Most that a run took beyond the usual time to come to rest [s].
  bool finite = true;
  std::optional<double> creep, creep_turn;  ///< In a minute [m, rad], of what ends pressed.
};

SweepLine sweep(Pairing& pairing, const Excitation& what, Response& response, const StabilityOptions& o) {
  SweepLine row;
  const std::vector<double> rates = o.quick ? std::vector<double>{1000} : std::vector<double>{1000, 4000};
  const std::vector<double> masses =
      o.quick ? std::vector<double>{0.02, 2.0} : std::vector<double>{0.02, 0.06, 0.2, 0.6, 2.0};
  for (const double rate : rates) {
    for (const double mass : masses) {
      for (const double stiffness : {0.0, 1e9}) {
        if (o.quick && (mass > 1) == (stiffness > 0)) continue;
        const auto rig = pairing.rig(rate, mass, stiffness, response);
        const StabilityOutcome out = play(pairing.pair, what, mass, *rig);
        ++row.runs;
        row.at_rest += out.unrest < kRest ? 1 : 0;
        row.created = std::max(row.created, out.created);
        row.unrest = std::max(row.unrest, out.unrest);
        row.patience = std::max(row.patience, out.patience);
        row.strongest = std::max(row.strongest, out.strongest);
        row.finite = row.finite && out.finite;
      }
    }
  }
  if (!o.quick && !what.airborne) {
    const auto rig = pairing.rig(1000, 0.2, 0, response);
    (void)play(pairing.pair, what, 0.2, *rig);
    rig->run(1);
    const Vec3 hand = rig->device().body().position(), tool = rig->tool().body().com();
    const Quat turned = rig->tool().body().orientation();
    rig->run(60);
    row.creep = std::max((rig->device().body().position() - hand).norm(), (rig->tool().body().com() - tool).norm());
    row.creep_turn = rig->tool().body().orientation().angularDistance(turned);
    row.finite = row.finite && rig->finite();
  }
  return row;
}

bool holds(const SweepLine& row) {
  return row.finite && row.at_rest == row.runs && row.created <= kCreated && row.creep.value_or(0) < kCreep &&
         row.creep_turn.value_or(0) < kCreepTurn;
}

void print(const Common& common, const char* pair, const char* what, const char* response, const SweepLine& row) {
  const auto optional = [&](const std::optional<double>& x, double unit) {
    return x ? fmt::format("{:.3g}", *x * unit) : std::string("-");
  };
  if (common.csv) {
    fmt::print("{},{},{},{},{},{:g},{:g},{:g},{:g},{},{},{}\n", pair, what, response, row.runs, row.at_rest,
               row.patience, row.unrest, row.created, row.strongest, optional(row.creep, 1),
               optional(row.creep_turn, 1), row.finite);
  } else {
    fmt::print("{:15} {:9} {:11} | {:3} of {:3} {:6.1f} {:10.3g} | {:>8} {:>8} | {:9.2g} {:6.1f} {}\n", pair, what,
               response, row.at_rest, row.runs, row.patience, row.unrest * 1e6, optional(row.creep, 1e6),
               optional(row.creep_turn, 1e3), std::max(row.created, 0.0), row.strongest,
               row.finite ? "" : "not finite");
  }
  std::fflush(stdout);
}

int run(const Common& common, const StabilityOptions& o) {
  if (o.check && !o.response.empty() && o.response != kDefault) {
    throw Failure("--check", "it judges the default response alone", std::string("without --response, or ") + kDefault);
  }
  PenaltyGains hard;
  hard.stiffness = 5000;
  hard.max_depth = 0.01;
  std::vector<std::unique_ptr<Response>> responses;
  responses.push_back(std::make_unique<ConstraintResponse>());
  responses.push_back(std::make_unique<ImpulseResponse>());
  responses.push_back(std::make_unique<PenaltyResponse>(hard));
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  if (common.csv) {
    fmt::print("{}\n",
               settingsLine("stability", fmt::format("{}voxels of {} mm", o.quick ? "quick, " : "", o.voxel_mm)));
    fmt::print("{}\n", tableForm("stability").header());
  } else {
    fmt::print("{:15} {:9} {:11} | {:>10} {:>6} {:>10} | {:>8} {:>8} | {:>9} {:>6}\n", "pair", "", "response",
               "at rest", "later", "unrest um", "creep um", "mrad", "created J", "most N");
  }
  bool good = true;
  for (Pairing& pairing : pairings(o)) {
    for (const Excitation& what : excitations()) {
      for (const auto& response : responses) {
        const bool is_default = response == responses.front();
        if (!o.response.empty() ? o.response != response->name() : o.quick && !is_default) continue;
        const SweepLine row = sweep(pairing, what, *response, o);
        print(common, pairing.pair.name, what.name, response->name(), row);
        good = good && (!is_default || holds(row));
      }
    }
  }
  if (o.check && !good) {
    fmt::print(
        "the default response creates energy, is not finite, or does not rest within {:g} um ({:g} in a minute)\n",
        kRest * 1e6, kCreep * 1e6);
  }
  return o.check && !good ? 1 : 0;
}

}  // namespace

void addStability(CLI::App& app, Run& chosen) {
  CLI::App* command = app.add_subcommand(
      "stability", "Held tools dropped, pushed, jammed, spun and hammered: energy from nothing, unrest, creep");
  const auto o = std::make_shared<StabilityOptions>();
  command->add_flag("--quick", o->quick, "The default response, 1 kHz, lightest and heaviest, no minute at rest");
  command->add_flag("--check", o->check, "End with 1 when the default response does not hold");
  command->add_option("--pair", o->pair, "Only this")->check(CLI::IsMember(pairNames()));
  command->add_option("--response", o->response, "Only this: constraint, impulse or penalty")
      ->check(CLI::IsMember({kDefault, "impulse", "penalty"}));
  command->add_option("--voxel", o->voxel_mm, "Side of the voxels of the volumes")
      ->type_name("MM")
      ->check(within(0.1, 5.0))
      ->capture_default_str();
  whenNamed(command, chosen, [o](const Common& common) { return run(common, *o); });
}

}  // namespace haptic_bench
