#include "tools/haptic-bench/side_by_side.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/readable.h"

namespace haptic_bench {
namespace {

constexpr std::size_t kWidth = 80;  // Of a terminal.
constexpr double kWide = 0.1;       // Of a median: an interval that is told.

/** A quantity: its name, its unit, and a text for each contender. */
struct TextColumn {
  std::string name, unit;
  std::vector<std::string> texts;

  [[nodiscard]] std::size_t width() const {
    std::size_t widest = std::max(name.size(), unit.size());
    for (const std::string& text : texts) widest = std::max(widest, text.size());
    return widest + 2;
  }
};

std::string medianText(const Series& s, double factor, bool& wide) {
  const Estimate e = estimate(s.rounds);
  const bool uncertain = e.high - e.low > kWide * std::abs(e.median);
  wide = wide || uncertain;
  return valueText(s.unit, e.median * factor, 4) + (uncertain ? '~' : ' ');
}

/** The unit of all of a column: in which the greatest is easily read. */
Readable unitOf(const std::vector<const Series*>& column) {
  double greatest = 0;
  std::string unit;
  for (const Series* s : column) {
    if (s == nullptr) continue;
    unit = s->unit;
    greatest = std::max(greatest, std::abs(estimate(s->rounds).median));
  }
  return readable(unit, greatest);
}

/** In the order of the first that has it. */
std::vector<TextColumn> columnsOf(const std::vector<Contender>& all, bool& wide) {
  std::vector<std::pair<std::string, std::vector<const Series*>>> found;  // By name, for each contender or none.
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const Series& s : all[i].series) {
      const std::string name = s.name.substr(all[i].name.size() + 1);
      auto at = std::find_if(found.begin(), found.end(), [&](const auto& column) { return column.first == name; });
      if (at == found.end()) at = found.insert(at, {name, std::vector<const Series*>(all.size())});
      at->second[i] = &s;
    }
  }
  std::vector<TextColumn> columns;
  for (const auto& [name, series] : found) {
    const Readable shown = unitOf(series);
    columns.push_back({name, shown.unit, {}});
    for (const Series* s : series)
      columns.back().texts.push_back(s == nullptr ? "- " : medianText(*s, shown.factor, wide));
  }
  return columns;
}

}  // namespace

void printSideBySide(const Common& common, const std::string& benchmark, const std::vector<Contender>& all) {
  if (common.csv || all.size() == 1) {
    std::vector<Series> series;
    for (const Contender& one : all) series.insert(series.end(), one.series.begin(), one.series.end());
    print(common, benchmark, series);
    return;
  }
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  bool wide = false;
  const std::vector<TextColumn> columns = columnsOf(all, wide);
  std::size_t names = 0;
  for (const Contender& one : all) names = std::max(names, one.name.size());
  fmt::print("\n{}\n", benchmark);
  for (std::size_t first = 0, end = 0; first < columns.size(); first = end) {
    std::size_t width = names;
    do width += columns[end++].width();
    while (end < columns.size() && width + columns[end].width() <= kWidth);
    const auto line = [&](const std::string& name, const auto& textOf) {
      std::string text = fmt::format("{:<{}}", name, names);
      for (std::size_t c = first; c < end; ++c) text += fmt::format("{:>{}}", textOf(columns[c]), columns[c].width());
      fmt::print("{}\n", text.substr(0, text.find_last_not_of(' ') + 1));
    };
    fmt::print("\n");
    line("", [](const TextColumn& c) { return c.name + ' '; });
    line("", [](const TextColumn& c) { return c.unit + ' '; });
    for (std::size_t i = 0; i < all.size(); ++i) line(all[i].name, [i](const TextColumn& c) { return c.texts[i]; });
  }
  std::size_t rounds = 0;
  for (const Series& s : all.front().series) rounds = std::max(rounds, s.rounds.size());
  if (rounds < 2) return;
  const char* interval = rounds < kRoundsOfAnInterval ? "range" : "95 % interval";
  fmt::print("\nMedians of {} rounds.\n", rounds);
  if (wide) fmt::print("~: the {} is wider than a tenth of it; --csv has every round.\n", interval);
}

}  // namespace haptic_bench
