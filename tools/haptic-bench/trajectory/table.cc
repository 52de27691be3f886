#include "tools/haptic-bench/trajectory/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <utility>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/spec.h"
#include "tools/haptic-bench/tell.h"

namespace haptic_bench {
namespace {

struct Unit {
  std::string_view suffix;
  double scale;
};
constexpr Unit kUnits[] = {{"_s", 1},     {"_ms", 1e-3}, {"_us", 1e-6}, {"_ns", 1e-9}, {"_m", 1},
                           {"_mm", 1e-3}, {"_um", 1e-6}, {"_N", 1},     {"_mN", 1e-3}};
constexpr std::string_view kBlanks = " \t\r";

// In the place of what is no finite number: text in a column or row that nobody asks for is no fault.
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();  // It said nan or inf.
constexpr double kEmpty = std::numeric_limits<double>::infinity(), kText = -kEmpty;

/** As programs print what is not finite. */
bool isUnknown(std::string_view field) {
  if (field.substr(0, 1) == "-") field.remove_prefix(1);
  return field == "nan" || field == "inf";
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\"");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\"") + 1 - first);
}

/** Where the field at the beginning of `line` ends: at one of `ends` that no quotes enclose. */
std::size_t endOfField(std::string_view line, std::string_view ends) {
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (!quoted && ends.find(line[i]) != std::string_view::npos) return i;
  }
  return std::string_view::npos;
}

/** The fields of a line: between commas, or between blanks where there is no comma. */
template <class F>
void forEachField(std::string_view line, F f) {
  const bool commas = line.find(',') != std::string_view::npos;
  while (true) {
    if (!commas) line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlanks)));
    if (!commas && line.empty()) return;
    const std::size_t end = endOfField(line, commas ? "," : kBlanks);
    f(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

/** Whether a line holds words alone, as one of names does: nothing that begins like a number, nan and inf included. */
bool isWords(std::string_view line) {
  bool words = false, numbers = false;
  forEachField(line, [&](std::string_view field) {
    const std::string text(field);
    char* end = nullptr;
    (void)std::strtod(text.c_str(), &end);
    const bool number = *end == 0 || text.find_first_of("+-.0123456789") == 0;
    (number ? numbers : words) |= !text.empty();
  });
  return words && !numbers;
}

}  // namespace

std::string Table::at(std::size_t row) const { return fmt::format("{}, line {}", where_, lines_[row]); }

void Table::setNames(std::string_view line, std::size_t number, bool given) {
  names_given_ = given;
  const std::string there = given ? "--columns" : fmt::format("{}, line {}", where_, number);
  forEachField(line, [&](std::string_view field) {
    double value = 0;
    if (!given && parseNumber(field, value)) {
      throw Failure(there, "there are numbers where the columns' names should be",
                    "a first line like t,x,y,z or --columns t,x,y,z");
    }
    names_.emplace_back(field);
  });
  if (names_.size() == 1 && line.find(';') != std::string_view::npos) {
    throw Failure(there, "semicolons part its columns", "commas or blanks, and a point in numbers");
  }
  if (names_.size() > kMaxColumns)
    throw Failure(there, fmt::format("there are {} columns", names_.size()), fmt::format("at most {}", kMaxColumns));
}

void Table::addRow(std::string_view line, std::size_t number) {
  if (lines_.size() == kMaxRows) {
    throw Failure(fmt::format("{}, line {}", where_, number), fmt::format("there are more than {} rows", kMaxRows),
                  "a shorter piece of it");
  }
  std::size_t column = 0;
  forEachField(line, [&](std::string_view field) {
    double value = 0;
    if (!parseNumber(field, value)) value = field.empty() ? kEmpty : (isUnknown(field) ? kUnknown : kText);
    ++column;
    values_.push_back(value);
  });
  if (column != names_.size()) {
    throw Failure(fmt::format("{}, line {}", where_, number),
                  fmt::format("it has {} columns, {} have names", column, names_.size()), "every row whole");
  }
  lines_.push_back(number);
}

Table Table::parse(std::string_view text, std::string where, const std::string& names) {
  Table table;
  table.where_ = std::move(where);
  if (!names.empty()) table.setNames(names, 0, true);
  bool may_be_names = !names.empty();  // The file's own, which those that are given stand in for.
  if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);  // Byte order mark.
  if (text.substr(0, 4096).find('\0') != std::string_view::npos)
    throw Failure(table.where_, "it is no plain text", "text in UTF-8, as spreadsheets and editors save it");
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    const std::size_t first = line.find_first_not_of(kBlanks);
    if (first == std::string_view::npos || line[first] == '#' || line[first] == '%') continue;
    if (line.substr(0, line.find_last_not_of(kBlanks)).find('\r') != std::string_view::npos) {
      throw Failure(fmt::format("{}, line {}", table.where_, number), "carriage returns alone part its lines",
                    "line feeds, as CSV in UTF-8 has them");
    }
    if (std::exchange(may_be_names, false) && isWords(line)) continue;
    if (table.names_.empty()) {
      table.setNames(line, number, false);
    } else {
      table.addRow(line, number);
    }
  }
  if (!table.lines_.empty()) table.first_line_ = table.lines_.front();
  if (table.lines_.empty())
    throw Failure(table.where_, "there are no rows in it", "a first line of names, then numbers");
  return table;
}

Table Table::read(const std::string& path, const std::string& names) {
  if (std::error_code none; std::filesystem::is_directory(path, none))  // Which opens, and seems endless.
    throw Failure(path, "it is a folder", "the name of a file");
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (size < 0) throw Failure(path, "it cannot be read", "a file that is there");
  if (size > static_cast<std::streamoff>(kMaxBytes))
    throw Failure(path, "it is larger than 1 GiB", "a shorter piece of it");
  std::string text(static_cast<std::size_t>(size), '\0');
  file.seekg(0);
  if (!file.read(text.data(), size)) throw Failure(path, "it cannot be read", "a regular file");
  Table table = parse(text, path, names);
  if (text.back() != '\n') {  // Which a file made by hand may lack, too.
    tellOnce(table.at(table.rows() - 1) + ": its last line does not end; was it cut off, its last number is wrong");
  }
  return table;
}

Table::Column Table::lookUp(std::string_view names) const {
  Column found;
  forEachField(names, [&](std::string_view name) {
    for (std::size_t c = 0; c < names_.size(); ++c) {
      const std::string_view have = names_[c];
      double scale = have == name ? 1 : 0;
      for (const Unit& unit : kUnits) {
        if (have.size() == name.size() + unit.suffix.size() && have.substr(0, name.size()) == name &&
            have.substr(name.size()) == unit.suffix) {
          scale = unit.scale;
        }
      }
      if (scale == 0) continue;
      if (found && scale != found.scale_) {  // One quantity in two units: the finer one has more digits.
        if (scale > found.scale_) continue;
      } else if (found) {
        throw Failure(where_,
                      fmt::format("columns {} and {} ({} and {}) are the same quantity", found.column_ + 1, c + 1,
                                  names_[found.column_], have),
                      "name one of them otherwise with --columns");
      }
      found.table_ = this;
      found.column_ = c;
      found.scale_ = scale;
    }
  });
  return found;
}

Table::Column Table::find(std::string_view names) const {
  const Column found = lookUp(names);
  for (std::size_t row = 0; found && row < rows(); ++row) {
    const double value = values_[row * names_.size() + found.column_];
    if (std::isfinite(value)) continue;
    throw Failure(fmt::format("{}, column {} ({})", at(row), found.column_ + 1, names_[found.column_]),
                  value == kEmpty ? "there is no number" : "it is not a finite number",
                  names_given_ && lines_[row] == first_line_ ? "without --columns, if names stand there"
                                                             : "numbers like 0.001 or 1e-3");
  }
  return found;
}

Table::Column Table::need(std::string_view names) const {
  const Column found = find(names);
  if (found) return found;
  std::string all;
  for (const std::string& name : names_) all += (all.empty() ? "" : ",") + name;
  throw Failure(
      where_, fmt::format("there is no column {}", names.substr(0, names.find(' '))),
      fmt::format("it has {}; name it in the first line, or with --columns, as t,x_mm,y_mm,z_mm", all.substr(0, 200)));
}

void Table::keepOnly(std::string_view name, unsigned number) {
  const Column column = find(name);
  if (!column) return;
  if (keepRows([&](std::size_t row) { return column[row] == number; })) return;
  throw Failure(where_, fmt::format("it has no row of {} {}", name, number),
                fmt::format("--{} and another number", name));
}

void Table::leaveOutUnknown(std::string_view names) {
  const Column column = lookUp(names);
  if (!column) return;
  const auto known = [&](std::size_t row) { return !std::isnan(values_[row * names_.size() + column.column_]); };
  if (keepRows(known)) return;
  throw Failure(where_, fmt::format("no row of it has a number in column {}", names_[column.column_]),
                "a session in which the device worked");
}

template <class F>
bool Table::keepRows(F keeps) {
  const std::size_t width = names_.size();
  std::size_t kept = 0;
  for (std::size_t row = 0; row < lines_.size(); ++row) {
    if (!keeps(row)) continue;
    std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>(row * width), width,
                values_.begin() + static_cast<std::ptrdiff_t>(kept * width));
    lines_[kept++] = lines_[row];
  }
  values_.resize(kept * width);
  lines_.resize(kept);
  return kept > 0;
}

std::vector<double> readTimes(const Table& table, double rate_hz, double max_gap_s) {
  std::vector<double> t_s(table.rows());
  if (rate_hz > 0) {
    for (std::size_t i = 0; i < t_s.size(); ++i) t_s[i] = static_cast<double>(i) / rate_hz;
    return t_s;
  }
  const Table::Column t = table.need("t time");
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    t_s[i] = t[i] - t[0];
    if (i > 0 && !(t_s[i] > t_s[i - 1])) {
      throw Failure(table.at(i), fmt::format("time goes from {:.9g} s to {:.9g} s", t[i - 1], t[i]), "rising times");
    }
  }
  constexpr double kLongest = 1e6;  // Eleven days.
  if (!t_s.empty() && t_s.back() > kLongest) {
    throw Failure(table.at(t_s.size() - 1), fmt::format("the times span {:.4g} s", t_s.back()),
                  "name the column of times with its unit, as t_ns");
  }
  constexpr double kShortest = 1e-6;  // A thousand times the servo's rate.
  if (t_s.size() > 1 && t_s.back() < kShortest * static_cast<double>(t_s.size() - 1)) {
    throw Failure(table.at(t_s.size() - 1), fmt::format("{} rows span {:.4g} s", t_s.size(), t_s.back()),
                  "name the column of times with its unit, as t_ms");
  }
  if (t_s.size() < (max_gap_s > 0 ? 2 : 3)) return t_s;  // Nothing is usual yet.
  std::vector<double> steps;
  for (std::size_t i = 1; i < t_s.size(); ++i) steps.push_back(t_s[i] - t_s[i - 1]);
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  const double gap = max_gap_s > 0 ? max_gap_s : 10 * steps[steps.size() / 2];
  for (std::size_t i = 1; i < t_s.size(); ++i) {
    if (t_s[i] - t_s[i - 1] <= gap) continue;
    throw Failure(
        table.at(i),
        fmt::format("a gap of {:.4g} s where {:.4g} s are usual", t_s[i] - t_s[i - 1], steps[steps.size() / 2]),
        "cut the file there, or allow it with --max-gap (of measured data: max_gap=)");
  }
  return t_s;
}

void checkForce(const Table& table, std::size_t row, const hapticd::Vec3& force) {
  constexpr double kMaxForce = 1e6;  // [N]
  if (force.cwiseAbs().maxCoeff() <= kMaxForce) return;
  throw Failure(table.at(row), fmt::format("the force is {:.4g} N", force.cwiseAbs().maxCoeff()),
                "name the column with its unit, as fx_mN");
}

void checkPosition(const Table& table, std::size_t row, const hapticd::Vec3& position) {
  constexpr double kFarthest = 100;  // [m]
  if (position.cwiseAbs().maxCoeff() <= kFarthest) return;
  throw Failure(table.at(row), fmt::format("the position is {:.4g} m away", position.norm()),
                fmt::format("at most {} m: name the column with its unit, as x_mm", kFarthest));
}

}  // namespace haptic_bench
