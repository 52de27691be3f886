#include "tools/haptic-bench/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/readable.h"
#include "tools/haptic-bench/result/results.h"

namespace haptic_bench {

std::string valueText(const std::string& unit, double value, int digits) {
  if (unit == "hash") return fmt::format("{:012x}", static_cast<std::uint64_t>(value));
  return fmt::format("{:.{}g}", value, digits);
}

Series ratio(std::string name, const Series& a, const Series& b) {
  Series r{std::move(name), "", {}};
  for (std::size_t i = 0; i < a.rounds.size() && i < b.rounds.size(); ++i)
    r.rounds.push_back(a.rounds[i] / b.rounds[i]);
  return r;
}

void printRounds(const std::string& benchmark, const std::vector<Series>& all) {
  for (const Series& s : all) {
    for (std::size_t i = 0; i < s.rounds.size(); ++i) {
      fmt::print("{},{},{},{},{}\n", csvField(benchmark), csvField(s.name), s.unit, i + 1, s.rounds[i]);
    }
  }
}

std::string settingsLine(std::string_view benchmark, std::string_view settings) {
  return fmt::format("# settings of {}: {}", benchmark, settings);
}

void print(const Common& common, const std::string& benchmark, const std::vector<Series>& all,
           const std::string& settings) {
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  if (common.csv) {
    if (!settings.empty()) fmt::print("{}\n", settingsLine(benchmark, settings));
    fmt::print("{}\n", kResultsHeader);
    printRounds(benchmark, all);
    return;
  }
  std::size_t width = 0, most = 0, units = 0;
  std::vector<Readable> shown;
  for (const Series& s : all) {
    width = std::max(width, s.name.size());
    most = std::max(most, s.rounds.size());
    shown.push_back(readable(s.unit, estimate(s.rounds).median));
    units = std::max(units, shown.back().unit.size());
  }
  const bool fits = benchmark.size() <= width;  // Else it has a line of its own, above the columns' names.
  const auto line = [&](const std::string& name, const std::string& median, const std::string& unit,
                        const std::string& interval, const std::string& rounds) {
    std::string text = fmt::format("{:<{}}  {:>12} {:<{}}", name, width, median, unit, units);
    if (most > 1) text += fmt::format("  {:>23}  {:>6}", interval, rounds);  // Else all that there is stands there.
    fmt::print("{}\n", text.substr(0, text.find_last_not_of(' ') + 1));
  };
  fmt::print("\n{}", fits ? "" : benchmark + "\n");
  line(fits ? benchmark : "", most > 1 ? "median" : "value", "", most < kRoundsOfAnInterval ? "range" : "95 % interval",
       "rounds");
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Series& s = all[i];
    const Estimate e = estimate(s.rounds);
    const auto text = [&](double x) { return valueText(s.unit, x * shown[i].factor, 4); };
    const std::string spread = e.low == e.high ? "" : fmt::format("{:>10} .. {:>9}", text(e.low), text(e.high));
    line(s.name, text(e.median), shown[i].unit, spread, std::to_string(s.rounds.size()));
  }
}

}  // namespace haptic_bench
