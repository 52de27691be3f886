#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tools/haptic-bench/result/results.h"

namespace haptic_bench {
namespace {

constexpr std::size_t kFewest = 6;  // Rows: with fewer the standard error itself is a matter of chance.
constexpr double kErrors = 4;       // One group in a hundred moves so far by chance if it has six rows, fewer if more.

/** A column of a group: each row before and after, in the measure in which changes are added up. */
struct Rows {
  const TableColumn* column = nullptr;
  std::vector<std::pair<double, double>> all;
};

bool isMeanSquare(const TableColumn& column) { return std::string_view(column.unit) == "N^2"; }
double measure(const TableColumn& column, double x) { return isMeanSquare(column) ? std::sqrt(x) : std::log(x); }
double value(const TableColumn& column, double x) { return isMeanSquare(column) ? x * x : std::exp(x); }

}  // namespace

std::vector<Change> judgeTogether(const Results& before, const Results& after) {
  std::map<std::pair<std::string, std::string>, Rows> groups;
  for (const StoredResult& old : before.all) {
    if (old.column == nullptr || old.column->rule.together <= 0) continue;
    const StoredResult* now = after.find(old.benchmark, old.series.name);
    if (now == nullptr) continue;
    const double a = measure(*old.column, old.series.rounds[0]), b = measure(*old.column, now->series.rounds[0]);
    if (!std::isfinite(a) || !std::isfinite(b)) continue;  // Their rows speak for themselves.
    Rows& rows = groups[{old.group, old.series.name}];
    rows.column = old.column;
    rows.all.emplace_back(a, b);
  }
  std::vector<Change> changes;
  for (const auto& [name, rows] : groups) {
    if (rows.all.size() < kFewest) continue;
    const auto n = static_cast<double>(rows.all.size());
    double mean_before = 0, mean = 0, squares = 0;
    for (const auto& [a, b] : rows.all) mean_before += a / n, mean += (b - a) / n;
    for (const auto& [a, b] : rows.all) squares += (b - a - mean) * (b - a - mean);
    const double standard_error = std::sqrt(squares / (n - 1) / n);
    if (!(std::abs(mean) > std::max(rows.column->rule.together, kErrors * standard_error))) continue;
    const double a = value(*rows.column, mean_before), b = value(*rows.column, mean_before + mean);
    const bool worse = (mean > 0) == (rows.column->rule.better == Rule::Better::kLess);
    changes.push_back({worse ? Change::Kind::kWorse : Change::Kind::kBetter,
                       fmt::format("{}, mean of {} rows", name.first, rows.all.size()),
                       name.second,
                       rows.column->unit,
                       {a, a, a},
                       {b, b, b}});
  }
  return changes;
}

}  // namespace haptic_bench
