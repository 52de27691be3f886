// haptic-bench compare: what got worse between two files of results.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "tools/haptic-bench/failure.h"
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

int run(const CompareOptions& options) {
  const Results before = Results::read(options.before), after = Results::read(options.after);
  Comparison what = options.what;
  what.times = !options.errors_only;
  if (what.times && !sameMachine(before, after)) fmt::print("# machine or build differ: times say little\n");
  int worse = 0, unknown = 0;
  for (const Change& c : compare(before, after, what)) {
    if (c.kind == Change::Kind::kUnknown) {
      ++unknown;
      continue;
    }
    const char* kind =
        c.kind == Change::Kind::kBetter ? "better" : (c.kind == Change::Kind::kWorse ? "worse" : "missing");
    worse += c.kind == Change::Kind::kBetter ? 0 : 1;
    fmt::print("{:<8} {}, {}: {}", kind, c.benchmark, c.quantity, text(c.unit, c.before));
    if (c.kind != Change::Kind::kMissing) fmt::print(" -> {}", text(c.unit, c.after));
    fmt::print(" {}\n", c.unit);
  }
  const auto compared = std::count_if(before.all.begin(), before.all.end(),
                                      [&](const StoredResult& r) { return isCompared(r.series.unit, what); });
  if (compared == unknown) {
    throw Failure(options.before, "nothing in it is compared", "without --errors, with --hashes, or of more --rounds");
  }
  if (unknown > 0) {
    fmt::print("# {} not judged: times of fewer than {} rounds, whose difference may be noise\n", unknown,
               roundsToJudge(before));
  }
  fmt::print("{} of {} quantities worse or missing\n", worse, compared - unknown);
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
  sub->callback([options, &chosen] { chosen = [options](const Common&) { return run(*options); }; });
}

}  // namespace haptic_bench
