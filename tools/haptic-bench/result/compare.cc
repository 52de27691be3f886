#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "rt/contact/point_kernel.h"
#include "tools/haptic-bench/result/results.h"

namespace haptic_bench {
namespace {

constexpr double kNoise = 0.02;     // A smaller difference of medians is never named.
constexpr double kRounding = 1e-9;  // Of errors across machines, in their SI unit; force in its mean square.

enum class Family { kTime, kError, kHash };

Family familyOf(const std::string& unit) {
  if (unit == "hash") return Family::kHash;
  for (const char* error : {"N^2", "m", "J", "samples", "ticks", kCountedUnit, kForceErrorUnit, kVirtualTimeUnit}) {
    if (unit == error) return Family::kError;
  }
  return Family::kTime;
}

/** Of a table's cell. */
const Rule& ruleOf(const StoredResult& result) {
  const Rule &rule = result.column->rule, &calm = result.column->calm;
  return result.calm && calm.relative > 0 ? calm : rule;
}

/** Whether two runs of one build differ in it: a time ("ns per message" too), or what runs against the clock. */
bool varies(const StoredResult& result) {
  if (result.column != nullptr || result.series.unit == kVirtualTimeUnit) return false;
  const std::string &benchmark = result.benchmark, &unit = result.series.unit;
  const std::string first = unit.substr(0, unit.find(' '));
  for (const char* time : {"ns", "us", "ms", "s", "1/ms"}) {
    if (first == time) return true;
  }
  const bool live = benchmark == "load" || benchmark == "servo" || benchmark == "ring";
  return live && unit != "ticks";  // Those of ring are counted.
}

bool moreIsBetter(const std::string& unit) { return unit == "N/m" || unit == "1/s" || unit == "1/ms" || unit == "Hz"; }

/**
 * The middle one of many steps is much the same in every run of one build. Into means, tails and times of loading goes
 * what else the machine does, for many rounds on end.
 */
bool isSteady(const Series& s) {
  constexpr std::string_view kMedian = " median";
  return s.name.size() > kMedian.size() && s.name.compare(s.name.size() - kMedian.size(), kMedian.size(), kMedian) == 0;
}

bool isPooled(const Series& s) { return s.name.ends_with(kPooled); }

/** An end of the interval of what is pooled. */
bool isPooledEnd(const Series& s) { return s.name.ends_with(kPooledLow) || s.name.ends_with(kPooledHigh); }

/** Of what is pooled, if the file holds it. */
std::optional<Estimate> pooledInterval(const Results& results, const StoredResult& pooled) {
  const std::string& name = pooled.series.name;
  const auto end = [&](std::string_view which) {
    return results.find(pooled.benchmark, name.substr(0, name.size() - kPooled.size()) + std::string(which));
  };
  const StoredResult *low = end(kPooledLow), *high = end(kPooledHigh);
  if (low == nullptr || high == nullptr) return std::nullopt;
  return Estimate{pooled.series.rounds[0], low->series.rounds[0], high->series.rounds[0]};
}

/** The vector unit of a row of collide, if it is of one. */
std::optional<hapticd::PointPath> vectorUnitOf(const StoredResult& result) {
  using hapticd::PointPath;
  for (const PointPath path : {PointPath::kPortable, PointPath::kAvx2, PointPath::kAvx512}) {
    if (result.benchmark.find(fmt::format(" {} query=", hapticd::nameOf(path))) != std::string::npos) return path;
  }
  return std::nullopt;
}

/** The best unit that a machine has, by its rows. */
std::optional<hapticd::PointPath> bestUnit(const Results& results) {
  std::optional<hapticd::PointPath> best;
  for (const StoredResult& r : results.all) best = std::max(best, vectorUnitOf(r));
  return best;
}

/** Whether a row that is gone is one that the other machine cannot have: some are of its best unit only. */
bool isOfOtherUnit(const StoredResult& gone, std::optional<hapticd::PointPath> best_before, const Results& after) {
  const std::optional<hapticd::PointPath> unit = vectorUnitOf(gone);
  if (!unit) return false;
  return (unit == best_before && unit != bestUnit(after)) ||
         (unit != hapticd::PointPath::kPortable && unit > bestUnit(after));
}

/** How likely it is that, of rounds that differ by chance alone, all of one run exceed all of the other. */
double chanceApart(std::size_t a, std::size_t b) {
  const auto logFactorial = [](std::size_t n) { return std::lgamma(static_cast<double>(n) + 1); };
  return 2 * std::exp(logFactorial(a) + logFactorial(b) - logFactorial(a + b));
}

/** Whether chance sets none of `count` such quantities apart, with 95 %. */
bool suffices(std::size_t before, std::size_t after, std::size_t count) {
  return std::min(before, after) >= kRoundsOfAnInterval &&
         chanceApart(before, after) * static_cast<double>(count) < 0.05;
}

/** Quantities that vary from round to round and are not steady. */
std::size_t countRestless(const Results& results) {
  return static_cast<std::size_t>(std::count_if(results.all.begin(), results.all.end(), [](const StoredResult& r) {
    return varies(r) && !isSteady(r.series) && !isPooled(r.series) && !isPooledEnd(r.series);
  }));
}

/** All rounds, not only those about the median. */
Estimate range(const std::vector<double>& rounds) {
  const auto [low, high] = std::minmax_element(rounds.begin(), rounds.end());
  return {estimate(rounds).median, *low, *high};
}

/** Positive: worse, negative: better, 0: the same. */
int judge(const Series& before, const Series& after, const Estimate& a, const Estimate& b) {
  switch (familyOf(before.unit)) {
    case Family::kHash:
      return before.rounds == after.rounds ? 0 : 1;
    case Family::kError: {
      const auto size = [&](double x) { return before.unit == "N^2" ? std::sqrt(std::abs(x)) : std::abs(x); };
      const double change = size(b.median) - size(a.median);
      return std::abs(change) <= kRounding ? 0 : (change > 0 ? 1 : -1);
    }
    case Family::kTime:
      break;
  }
  const bool up = b.low > a.high && b.median > a.median + kNoise * std::abs(a.median);
  const bool down = b.high < a.low && b.median < a.median - kNoise * std::abs(a.median);
  const int change = up ? 1 : (down ? -1 : 0);
  return moreIsBetter(before.unit) ? -change : change;
}

}  // namespace

bool sameMachine(const Results& a, const Results& b) {
  const auto lasting = [](const Results& results) {
    std::vector<std::string> lines;
    for (const std::string& line : results.machine) {
      // The load is never the same; what else is said of a run is not of the machine.
      for (const char* what : {"cpu: ", "kernel: ", "governor: ", "clock source: ", "build: "}) {
        if (line.rfind(what, 0) == 0) lines.push_back(line);
      }
    }
    return lines;
  };
  return lasting(a) == lasting(b);
}

bool isCompared(const StoredResult& result, const Comparison& what) {
  if (result.series.name == kMachineLatency) return false;  // Who else reads memory decides it, not the build.
  if (isPooledEnd(result.series)) return false;             // Judged with what lies between them.
  if (result.column != nullptr) return what.times || result.column->role != TableColumn::Role::kMemory;
  switch (familyOf(result.series.unit)) {
    case Family::kTime:
      return what.times;
    case Family::kHash:
      return what.hashes;
    case Family::kError:
      break;
  }
  return true;
}

std::string otherSettings(const Results& before, const Results& after) {
  for (const auto& [benchmark, settings] : before.settings) {
    const auto now = after.settings.find(benchmark);
    if (now != after.settings.end() && now->second != settings) return benchmark;
  }
  return {};
}

std::size_t roundsToJudge(const Results& before) {
  std::size_t rounds = kRoundsOfAnInterval;
  while (!suffices(rounds, rounds, countRestless(before))) ++rounds;
  return rounds;
}

std::vector<Change> compare(const Results& before, const Results& after, const Comparison& what) {
  std::vector<Change> changes;
  const std::size_t restless = countRestless(before);
  const std::optional<hapticd::PointPath> best_unit = bestUnit(before);
  for (const StoredResult& old : before.all) {
    if (!isCompared(old, what)) continue;
    Change change{
        Change::Kind::kMissing, old.benchmark, old.series.name, old.series.unit, estimate(old.series.rounds), {}};
    const StoredResult* found = after.find(old.benchmark, old.series.name);
    if (found == nullptr || found->series.unit != old.series.unit) {
      if (found == nullptr && !what.times && isOfOtherUnit(old, best_unit, after))
        change.kind = Change::Kind::kOtherUnit;
      changes.push_back(change);
      continue;
    }
    const Series* now = &found->series;
    change.after = estimate(now->rounds);
    if (isPooled(old.series)) {
      const std::optional<Estimate> a = pooledInterval(before, old), b = pooledInterval(after, *found);
      if (!a || !b) {
        change.kind = Change::Kind::kNoInterval;
        changes.push_back(change);
        continue;
      }
      change.before = *a, change.after = *b;
    } else if (varies(old)) {
      const bool steady = isSteady(old.series);
      if (!suffices(old.series.rounds.size(), now->rounds.size(), steady ? 1 : restless)) {
        change.kind = Change::Kind::kUnknown;
        changes.push_back(change);
        continue;
      }
      if (!steady) change.before = range(old.series.rounds), change.after = range(now->rounds);
    }
    const int judgement = old.column != nullptr ? judgeByRule(ruleOf(old), change.before.median, change.after.median)
                                                : judge(old.series, *now, change.before, change.after);
    if (judgement == 0) continue;
    change.kind = judgement > 0 ? Change::Kind::kWorse : Change::Kind::kBetter;
    changes.push_back(change);
  }
  for (Change& change : judgeTogether(before, after)) changes.push_back(std::move(change));
  return changes;
}

}  // namespace haptic_bench
