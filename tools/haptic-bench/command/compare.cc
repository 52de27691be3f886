// haptic-bench compare: what got worse between two files of results.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/result/results.h"

namespace haptic_bench {
namespace {

struct CompareOptions {
  std::string before, after;
  bool errors_only = false;
  Comparison what;
};

std::string text(const std::string& unit, const Estimate& e) {
  return e.low == e.high ? valueText(unit, e.median, 6)
                         : fmt::format("{:.4g} ({:.4g} .. {:.4g})", e.median, e.low, e.high);
}

/** Throws Failure where two files have nothing to do with each other. */
void requireSame(const CompareOptions& options, const Results& before, const Results& after) {
  if (const std::string benchmark = otherSettings(before, after); !benchmark.empty()) {
    throw Failure(options.after,
                  fmt::format("its settings of {} are \"{}\", those of {} \"{}\"", benchmark,
                              after.settings.at(benchmark), options.before, before.settings.at(benchmark)),
                  "two runs with the same settings");
  }
  const bool common = std::any_of(before.all.begin(), before.all.end(), [&](const StoredResult& r) {
    return after.find(r.benchmark, r.series.name) != nullptr;
  });
  if (common) return;
  throw Failure(fmt::format("{}, line {}", options.after, after.all[0].line),
                fmt::format("it holds \"{}\" and nothing of what {} holds, such as \"{}\"", after.all[0].benchmark,
                            options.before, before.all[0].benchmark),
                "two runs of one benchmark with the same settings");
}

/** Benchmarks that are gone as a whole, with their quantities, in their order. */
void printGone(const std::vector<Change>& changes, const Results& after) {
  std::vector<std::pair<std::string, int>> gone;
  for (const Change& c : changes) {
    if (c.kind != Change::Kind::kMissing || after.holds(c.benchmark)) continue;
    if (gone.empty() || gone.back().first != c.benchmark) gone.emplace_back(c.benchmark, 0);
    ++gone.back().second;
  }
  for (const auto& [benchmark, quantities] : gone)
    fmt::print("missing  {}: all that is compared of it ({} quantities)\n", benchmark, quantities);
}

/** What one file tells and the other does not. */
void printOneSided(const Results& before, const Results& after, const Comparison& what) {
  const auto untold = [](const char* file, const Results& told, const Results& in) {
    for (const auto& [benchmark, settings] : told.settings) {
      if (in.settings.count(benchmark) == 0) fmt::print("# {} does not tell its settings of {}\n", file, benchmark);
    }
  };
  untold("NEW", before, after);
  untold("OLD", after, before);
  const auto added = std::count_if(after.all.begin(), after.all.end(), [&](const StoredResult& r) {
    return isCompared(r, what) && before.find(r.benchmark, r.series.name) == nullptr;
  });
  if (added > 0) fmt::print("# {} quantities of NEW are not in OLD\n", added);
}

int run(const CompareOptions& options) {
  const Results before = Results::read(options.before), after = Results::read(options.after);
  requireSame(options, before, after);
  Comparison what = options.what;
  what.times = !options.errors_only;
  if (what.times && !sameMachine(before, after)) fmt::print("# machine or build differ: times say little\n");
  int worse = 0, unknown = 0, no_interval = 0, other_unit = 0;
  const std::vector<Change> changes = compare(before, after, what);
  for (const Change& c : changes) {
    if (c.kind >= Change::Kind::kUnknown) {
      ++(c.kind == Change::Kind::kUnknown ? unknown : c.kind == Change::Kind::kNoInterval ? no_interval : other_unit);
      continue;
    }
    const char* kind =
        c.kind == Change::Kind::kBetter ? "better" : (c.kind == Change::Kind::kWorse ? "worse" : "missing");
    worse += c.kind == Change::Kind::kBetter ? 0 : 1;
    if (c.kind == Change::Kind::kMissing && !after.holds(c.benchmark)) continue;
    fmt::print("{:<8} {}, {}: {}", kind, c.benchmark, c.quantity, text(c.unit, c.before));
    if (c.kind != Change::Kind::kMissing) fmt::print(" -> {}", text(c.unit, c.after));
    fmt::print("{}{}\n", c.unit.empty() ? "" : " ", c.unit);
  }
  printGone(changes, after);
  printOneSided(before, after, what);
  const auto compared =
      std::count_if(before.all.begin(), before.all.end(), [&](const StoredResult& r) { return isCompared(r, what); });
  const int passed_over = unknown + no_interval + other_unit;
  if (compared == passed_over) {
    throw Failure(options.before, "nothing in it is compared", "without --errors, with --hashes, or of more --rounds");
  }
  if (unknown > 0) {
    fmt::print("# {} not judged: times of fewer than {} rounds, whose difference may be noise\n", unknown,
               roundsToJudge(before));
  }
  if (no_interval > 0) {
    fmt::print("# {} not judged: of all slices together, however many rounds; only a ratio of such has an interval\n",
               no_interval);
  }
  if (other_unit > 0) fmt::print("# {} not compared: of vector units that only one machine has\n", other_unit);
  fmt::print("{} of {} quantities worse or missing\n", worse, compared - passed_over);
  return worse == 0 ? 0 : 1;
}

}  // namespace

void addCompare(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* sub = app.add_subcommand("compare", "What got worse between two files that --csv wrote");
  sub->add_option("OLD", options->before, "Results")->required();
  sub->add_option("NEW", options->after, "Results")->required();
  sub->add_flag("--errors", options->errors_only, "Leave out times, ratios and memory: for results of two machines");
  sub->add_flag("--hashes", options->what.hashes, "Hashes of forces too: for results of one build on one machine");
  whenNamed(sub, chosen, [options](const Common&) { return run(*options); });
}

}  // namespace haptic_bench
