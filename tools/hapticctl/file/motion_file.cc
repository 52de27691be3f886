#include "tools/hapticctl/file/motion_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"

namespace hapticctl {
namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = std::min(line.find(','), line.size());
    std::string_view field = line.substr(0, comma);
    constexpr std::string_view kAround = " \t\r\"";  // Some programs put every field in quotes.
    field.remove_prefix(std::min(field.size(), field.find_first_not_of(kAround)));
    field.remove_suffix(field.size() - std::min(field.size(), field.find_last_not_of(kAround) + 1));
    fields.push_back(field);
    if (comma == line.size()) return fields;
    line.remove_prefix(comma + 1);
  }
}

constexpr std::array<std::array<std::string_view, 2>, 4> kColumns{
    {{"t", "time"}, {"x", "px"}, {"y", "py"}, {"z", "pz"}}};

/** SI units per unit of a column of that name, which may have one behind it; 0 if the name is not that of column c. */
double scaleOf(std::string_view name, std::size_t c) {
  struct Unit {
    std::string_view suffix;
    double scale;
  };
  constexpr std::array<Unit, 4> kTimes{{{"", 1}, {"_s", 1}, {"_ms", 1e-3}, {"_us", 1e-6}}};
  constexpr std::array<Unit, 4> kLengths{{{"", 1}, {"_m", 1}, {"_mm", 1e-3}, {"_um", 1e-6}}};
  for (const Unit& unit : c == 0 ? kTimes : kLengths) {
    if (!name.ends_with(unit.suffix)) continue;
    const std::string_view bare = name.substr(0, name.size() - unit.suffix.size());
    if (bare == kColumns[c][0] || bare == kColumns[c][1]) return unit.scale;
  }
  return 0;
}

// As the daemon's for recorded motions. They also keep what lies between two rows finite.
constexpr double kMaxTime_s = 1e7;
constexpr double kMaxPosition_m = 10;

constexpr std::size_t kMostBytes = std::size_t{256} << 20;  // Hours at a thousand rows a second.

/** All of it; a device such as /dev/zero has no end, nor need it have a line's. */
std::istringstream contents(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Failure{kExitFile, path, "cannot be read", "it must exist and be readable for you"};
  std::string text;
  for (std::array<char, 65536> piece; file && text.size() <= kMostBytes;) {
    file.read(piece.data(), piece.size());
    text.append(piece.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (text.size() > kMostBytes)
    throw Failure{kExitFile, path, "is larger than 256 MiB", "cut it into parts, or write fewer rows a second"};
  if (text.starts_with("HRBLOCK1")) {
    throw Failure{kExitFile, path, "is a recording, not rows of text",
                  "make them of it: haptic-bench replay FILE --export rows.csv"};
  }
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // Byte order mark, as of spreadsheets.
  return std::istringstream(std::move(text));
}

}  // namespace

Motion Motion::read(const std::string& path) {
  std::istringstream file = contents(path);
  const auto fail = [&](std::size_t number, std::string what, std::string remedy = {}) {
    throw Failure{kExitFile, fmt::format("{}:{}", path, number), std::move(what), std::move(remedy)};
  };
  Motion out;
  std::optional<std::array<std::size_t, 4>> columns;
  std::array<double, 4> scales{};
  std::size_t device = 0;  // Its column, of an exported recording; beyond all: there is none.
  std::string first_device;
  std::size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.empty() || line == "\r" || line.front() == '#') continue;
    const auto fields = split(line);
    if (!columns && (fields.size() == 4 || fields.size() == 8) && parseNumber(fields[0])) {
      columns = {0, 1, 2, 3};  // No header, as of the daemon's motions: t,x,y,z, and perhaps a quaternion.
      scales.fill(1);
      device = fields.size();
    }
    if (!columns) {
      columns.emplace();
      for (std::size_t c = 0; c < 4; ++c) {
        const auto at =
            std::find_if(fields.begin(), fields.end(), [&](std::string_view f) { return scaleOf(f, c) != 0; });
        if (at == fields.end()) {
          if (const std::size_t parted = line.find_first_of(";\t"); parted != std::string::npos)
            fail(number, fmt::format("{} part its columns", line[parted] == ';' ? "semicolons" : "tabs"),
                 "write commas between them, and a point in numbers: 0.5,0.01,0,0");
          fail(number, fmt::format("no column '{}'", kColumns[c][0]),
               "the first line names them: t,x,y,z in seconds and metres, or t_ms,x_mm,y_mm,z_mm");
        }
        (*columns)[c] = static_cast<std::size_t>(at - fields.begin());
        scales[c] = scaleOf(*at, c);
      }
      device = static_cast<std::size_t>(std::find(fields.begin(), fields.end(), "device") - fields.begin());
      continue;
    }
    if (device < fields.size()) {
      if (out.rows_.empty()) first_device = fields[device];
      if (fields[device] != first_device)
        fail(number, "it is of another device than the first row", "keep the rows of one device");
    }
    std::array<double, 4> values{};
    for (std::size_t c = 0; c < 4; ++c) {
      if ((*columns)[c] >= fields.size())
        fail(number, fmt::format("it ends before column '{}'", kColumns[c][0]), "is the file whole?");
      const std::string_view field = fields[(*columns)[c]];
      const auto value = parseNumber(field);
      if (!value) {
        fail(number, fmt::format("'{}' in column '{}' is not a finite number", field, kColumns[c][0]),
             "numbers like -0.0125 or 1e-3");
      }
      values[c] = *value * scales[c];
    }
    if (!out.rows_.empty() && !(values[0] > out.rows_.back().t_s))
      fail(number, "time does not rise", "order the rows by time");
    if (!out.rows_.empty() && !(values[0] - out.rows_.front().t_s <= kMaxTime_s))
      fail(number, "time is too far from the first", "times are in seconds, within 1e7 of the first");
    for (std::size_t c = 1; c < 4; ++c) {
      if (!(std::abs(values[c]) <= kMaxPosition_m)) {
        fail(number, fmt::format("{} in column '{}' is more than 10 m", exact(values[c]), kColumns[c][0]),
             "positions are in metres");
      }
    }
    out.rows_.push_back({values[0], {values[1], values[2], values[3]}});
  }
  if (out.rows_.size() < 2) throw Failure{kExitFile, path, "holds fewer than two rows", "rows of t,x,y,z"};
  const double start = out.rows_.front().t_s;
  for (Row& row : out.rows_) row.t_s -= start;
  return out;
}

std::array<double, 3> Motion::at(double t_s) const {
  const auto after =
      std::upper_bound(rows_.begin(), rows_.end(), t_s, [](double t, const Row& row) { return t < row.t_s; });
  if (after == rows_.begin()) return rows_.front().p;
  if (after == rows_.end()) return rows_.back().p;
  const Row &a = *std::prev(after), &b = *after;
  const double part = (t_s - a.t_s) / (b.t_s - a.t_s);
  std::array<double, 3> p{};
  for (std::size_t i = 0; i < 3; ++i) p[i] = a.p[i] + part * (b.p[i] - a.p[i]);
  return p;
}

}  // namespace hapticctl
