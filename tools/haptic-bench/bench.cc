#include "tools/haptic-bench/bench.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/result/results.h"

namespace haptic_bench {

Series ratio(std::string name, const Series& a, const Series& b) {
  Series r{std::move(name), "", {}};
  for (std::size_t i = 0; i < a.rounds.size() && i < b.rounds.size(); ++i)
    r.rounds.push_back(a.rounds[i] / b.rounds[i]);
  return r;
}

void print(const Common& common, const std::string& benchmark, const std::vector<Series>& all) {
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  if (common.csv) {
    fmt::print("benchmark,quantity,unit,round,value\n");
    for (const Series& s : all) {
      for (std::size_t i = 0; i < s.rounds.size(); ++i) {
        fmt::print("{},{},{},{},{}\n", csvField(benchmark), csvField(s.name), s.unit, i + 1, s.rounds[i]);
      }
    }
    return;
  }
  std::size_t width = 0;
  for (const Series& s : all) width = std::max(width, s.name.size());
  fmt::print("\n{:<{}}  {:>10}  {:>23}  rounds\n", benchmark, width, "median", "95 % interval");
  for (const Series& s : all) {
    const Estimate e = estimate(s.rounds);
    fmt::print("{:<{}}  {:>10.4g}  {:>10.4g} .. {:>9.4g}  {} {}\n", s.name, width, e.median, e.low, e.high,
               s.rounds.size(), s.unit);
  }
}

}  // namespace haptic_bench
