// haptic-bench tables: tables 4.1 to 4.3 of the thesis with its figures beside ours.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/table/paper_table.h"

namespace haptic_bench {
namespace {

void show(const PaperTable& table) {
  std::vector<std::size_t> width;
  for (const std::string& name : table.columns) width.push_back(name.size());
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  }
  fmt::print("\n{}\n{}\n", table.title, table.settings);
  const auto line = [&](const std::vector<std::string>& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c)
      fmt::print("{:>{}}{}", cells[c], width[c], c + 1 < cells.size() ? "  " : "\n");
  };
  line(table.columns);
  for (const auto& row : table.rows) line(row);
}

int printTables(const Common& common) {
  const std::vector<PaperTable> tables = paperTables(common.rounds);
  if (common.csv) {
    std::vector<Series> all;
    for (const PaperTable& t : tables) all.insert(all.end(), t.series.begin(), t.series.end());
    print(common, "tables", all);
    return 0;
  }
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  fmt::print("# MSE in N^2; times of a step: mean over the trajectory{}\n",
             common.rounds == 1 ? "" : fmt::format(", median of {} rounds", common.rounds));
  for (const PaperTable& t : tables) show(t);
  return 0;
}

}  // namespace

void addTables(CLI::App& app, Run& chosen) {
  CLI::App* sub = app.add_subcommand("tables", "Tables 4.1 to 4.3 of the thesis, its figures beside ours");
  whenNamed(sub, chosen, printTables);
}

}  // namespace haptic_bench
