/** @file
 * CSV to PoseTrack. Every fault names file, line and column.
 */
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <span>

#include "drivers/number.h"
#include "drivers/pose_track.h"

namespace hapticd {
namespace {

enum Column : std::size_t { kTime, kX, kY, kZ, kQw, kQx, kQy, kQz, kGripper, kButtons, kColumns };
constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);
constexpr std::size_t kMaxFields = 256;
constexpr double kMaxPosition_m = 10;
constexpr double kMaxGripper_rad = 10;
constexpr double kMaxTime_s = 1e7, kLeastStep_s = 1e-12;  ///< Less would be speeds beyond any number.

struct Layout {
  std::array<std::size_t, kColumns> field;
  std::array<double, kColumns> scale;  ///< To SI.
  std::size_t device = kAbsent;        ///< Which of several, of an exported recording.
  std::string_view first_device;
  std::int64_t origin_ns = 0;  ///< Time of the first row, whichever of the two is in use.
  double origin_s = 0;
  bool integer_time = false;
};

constexpr std::string_view kNames[kColumns] = {"t", "x", "y", "z", "qw", "qx", "qy", "qz", "gripper_rad", "buttons"};

constexpr const char* kCommas = "write commas between them, and a point in numbers: 0.5,0.01,0,0";

/** As parseNumber(), and with the plus that some programs write before what is not negative. */
std::optional<double> number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return parseNumber(text);
}

std::string_view nextLine(std::string_view& rest) {
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

/** Without blanks and the quotes that some programs put every field in. */
std::string_view bare(std::string_view field) {
  field = trimmed(field);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
  return trimmed(field);
}

/** Splits at commas; false if there are more than kMaxFields. */
bool split(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  for (std::size_t begin = 0; begin <= line.size();) {
    if (fields.size() == kMaxFields) return false;
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(bare(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return true;
}

struct Unit {
  std::string_view suffix;
  double scale;
};

constexpr double kNanoseconds = 0;  ///< In the place of a scale: those are integers.
constexpr Unit kTimes[] = {{"", 1}, {"_s", 1}, {"_ms", 1e-3}, {"_us", 1e-6}, {"_ns", kNanoseconds}};
constexpr Unit kLengths[] = {{"", 1}, {"_m", 1}, {"_mm", 1e-3}, {"_um", 1e-6}};

/** The scale of `name`, if it is one of `names` with one of `units` behind it. */
std::optional<double> scaleOf(std::string_view name, std::initializer_list<std::string_view> names,
                              std::span<const Unit> units) {
  for (const Unit& unit : units) {
    if (!name.ends_with(unit.suffix)) continue;
    const std::string_view plain = name.substr(0, name.size() - unit.suffix.size());
    if (std::find(names.begin(), names.end(), plain) != names.end()) return unit.scale;
  }
  return {};
}

Column columnOf(std::string_view name, double& scale) {
  std::optional<double> found = scaleOf(name, {"t", "time"}, kTimes);
  Column column = kTime;
  if (!found && (found = scaleOf(name, {"x", "px", "p_x"}, kLengths))) column = kX;
  if (!found && (found = scaleOf(name, {"y", "py", "p_y"}, kLengths))) column = kY;
  if (!found && (found = scaleOf(name, {"z", "pz", "p_z"}, kLengths))) column = kZ;
  scale = found.value_or(1);
  if (found) return column;
  if (name == "gripper") return kGripper;
  for (std::size_t i = kQw; i < kColumns; ++i) {
    if (name == kNames[i]) return static_cast<Column>(i);
  }
  return kColumns;
}

class Parser {
 public:
  Parser(std::string_view text, std::string_view name, const std::atomic<bool>* given_up)
      : rest_(text), name_(name), given_up_(given_up) {}

  Result<void> run(std::vector<PoseRow>& rows, Layout& layout) {
    if (rest_.substr(0, 8) == "HRBLOCK1") {  // daemon/recording/block.h
      return Error{ErrorCode::kInvalidArgument, std::string(name_), "it is a recording, not rows of text",
                   "make them of it: haptic-bench replay FILE --export rows.csv"};
    }
    if (rest_.substr(0, 3) == "\xef\xbb\xbf") rest_.remove_prefix(3);  // Byte order mark.
    bool started = false;
    while (!rest_.empty()) {
      if (given_up_ != nullptr && given_up_->load(std::memory_order_relaxed))
        return Error{ErrorCode::kCancelled, std::string(name_), "nobody waits for it any more", {}};
      const std::string_view line = trimmed(nextLine(rest_));
      ++line_;
      if (line.empty() || line.front() == '#') continue;
      if (!split(line, fields_)) return fault(0, fmt::format("more than {} columns", kMaxFields), "is it a CSV file?");
      if (!started) {
        started = true;
        const bool header = !number(fields_.front());
        Result<void> read = header ? readHeader(layout) : assumeLayout(layout);
        if (!read) return read;
        width_ = fields_.size();
        if (header) continue;
      }
      if (rows.size() == PoseTrack::kMaxRows) {
        return fault(0, fmt::format("more than {} rows", PoseTrack::kMaxRows), "split the file or thin it out");
      }
      PoseRow row;
      Result<void> read = readRow(layout, row, rows);
      if (!read) return read;
      rows.push_back(row);
    }
    if (rows.empty()) return fault(0, "there are no rows", "give rows of t,x,y,z in s and m");
    return {};
  }

 private:
  Error fault(std::size_t field, std::string what, std::string remedy) const {
    std::string where = fmt::format("{}, line {}", name_, line_);
    if (field > 0) where += fmt::format(", column {}", field);
    return {ErrorCode::kInvalidArgument, std::move(where), std::move(what), std::move(remedy)};
  }

  /** What a spreadsheet may have put where commas belong. */
  std::optional<std::string_view> parting() const {
    for (const std::string_view field : fields_) {
      if (field.find(';') != std::string_view::npos) return "semicolons";
      if (field.find('\t') != std::string_view::npos) return "tabs";
    }
    return {};
  }

  Result<void> assumeLayout(Layout& layout) const {
    layout.field.fill(kAbsent);
    layout.scale.fill(1);
    if (fields_.size() != 4 && fields_.size() != 8) {
      if (const auto parts = parting()) return fault(0, fmt::format("{} part its columns", *parts), kCommas);
      return fault(0, fmt::format("{} columns without a header", fields_.size()),
                   "give t,x,y,z or t,x,y,z,qw,qx,qy,qz, or name the columns in the first line");
    }
    for (std::size_t i = 0; i < fields_.size(); ++i) layout.field[i] = i;
    return {};
  }

  Result<void> readHeader(Layout& layout) const {
    layout.field.fill(kAbsent);
    layout.scale.fill(1);
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if (fields_[i] == "device") layout.device = i;
      double scale = 1;
      const Column column = columnOf(fields_[i], scale);
      if (column == kColumns) continue;
      const bool nanoseconds = column == kTime && scale == kNanoseconds;
      if (column == kTime && layout.field[kTime] != kAbsent && nanoseconds != layout.integer_time) {
        // Both t_s and t_ns, as hapticctl monitor writes: nanoseconds lose nothing.
        if (nanoseconds) layout.field[kTime] = i;
        layout.integer_time = true;
        continue;
      }
      if (layout.field[column] != kAbsent) {
        if (scale != 1 && !nanoseconds) continue;  // The same in another unit besides: the first counts.
        return fault(i + 1, fmt::format("a second column for {}", kNames[column]), "keep one of them");
      }
      layout.field[column] = i;
      layout.scale[column] = scale;
      if (nanoseconds) layout.integer_time = true;
    }
    for (const Column column : {kTime, kX, kY, kZ}) {
      if (layout.field[column] == kAbsent) {
        if (const auto parts = parting()) return fault(0, fmt::format("{} part its columns", *parts), kCommas);
        return fault(0, fmt::format("the header names no column {}", kNames[column]),
                     "name time t or t_ns and position x, y, z (or px, py, pz), or with a unit: t_ms, x_mm");
      }
    }
    const bool any = layout.field[kQw] != kAbsent || layout.field[kQx] != kAbsent || layout.field[kQy] != kAbsent ||
                     layout.field[kQz] != kAbsent;
    for (const Column column : {kQw, kQx, kQy, kQz}) {
      if (any && layout.field[column] == kAbsent) {
        return fault(0, fmt::format("the header names no column {}", kNames[column]), "give all of qw, qx, qy, qz");
      }
    }
    return {};
  }

  Result<void> readRow(Layout& layout, PoseRow& row, const std::vector<PoseRow>& earlier) const {
    if (fields_.size() != width_) {
      return fault(0, fmt::format("{} columns where the first line has {}", fields_.size(), width_),
                   "is the file complete?");
    }
    if (layout.device != kAbsent) {
      if (earlier.empty()) layout.first_device = fields_[layout.device];
      if (fields_[layout.device] != layout.first_device)
        return fault(layout.device + 1, "this row is of another device than the first", "keep the rows of one device");
    }
    std::array<double, kColumns> value{};
    for (std::size_t i = 0; i < kColumns; ++i) {
      if (layout.field[i] == kAbsent) continue;
      const std::string_view text = fields_[layout.field[i]];
      if (i == kTime && layout.integer_time) {
        const std::optional<std::uint64_t> t_ns = parseInteger(text);
        if (!t_ns || *t_ns > (std::uint64_t{1} << 62)) {
          return fault(layout.field[i] + 1, "the time is no whole number of nanoseconds from 0 to 4.6e18",
                       "write digits alone, or seconds under the name t_s");
        }
        // Differences of integers: nanoseconds since boot do not fit a double for long.
        if (earlier.empty()) layout.origin_ns = static_cast<std::int64_t>(*t_ns);
        value[i] = static_cast<double>(static_cast<std::int64_t>(*t_ns) - layout.origin_ns) * 1e-9;
        continue;
      }
      const std::optional<double> read = number(text);
      if (!read) return badNumber(layout, i, text);
      value[i] = *read * layout.scale[i];
    }
    return check(layout, value, row, earlier);
  }

  Error badNumber(const Layout& layout, std::size_t column, std::string_view text) const {
    // The text itself stays out of the message: the daemon may read files that the one who names them may not.
    return fault(layout.field[column] + 1,
                 text.empty() ? "there is no number" : fmt::format("{} is not a finite number", kNames[column]),
                 "write numbers like -0.0125 or 1e-3");
  }

  Result<void> check(Layout& layout, const std::array<double, kColumns>& value, PoseRow& row,
                     const std::vector<PoseRow>& earlier) const {
    if (!layout.integer_time && earlier.empty()) layout.origin_s = value[kTime];
    row.t_s = value[kTime] - layout.origin_s;
    const bool rises = earlier.empty() || row.t_s - earlier.back().t_s >= kLeastStep_s;
    if (!rises || !(row.t_s <= kMaxTime_s)) {
      return fault(layout.field[kTime] + 1, rises ? "the time is too far from the first" : "the time does not rise",
                   "rows must be in order of time, each later than the one before, within 1e7 s");
    }
    row.p = Vec3(value[kX], value[kY], value[kZ]);
    for (int i = 0; i < 3; ++i) {
      if (std::abs(row.p[i]) > kMaxPosition_m) {
        return fault(layout.field[kX + static_cast<std::size_t>(i)] + 1,
                     fmt::format("{} m is more than {} m from the origin", formatNumber(row.p[i]), kMaxPosition_m),
                     "name the column with its unit, as x_mm");
      }
    }
    if (layout.field[kQw] != kAbsent) {
      const Quat q(value[kQw], value[kQx], value[kQy], value[kQz]);
      const double norm = q.norm();
      if (!(norm > 0.5 && norm < 2)) {
        return fault(layout.field[kQw] + 1, "qw,qx,qy,qz is not a unit quaternion", "w comes first");
      }
      row.q = q.normalized();
    }
    if (std::abs(value[kGripper]) > kMaxGripper_rad) {
      return fault(layout.field[kGripper] + 1,
                   fmt::format("{} rad is more than {} rad", formatNumber(value[kGripper]), kMaxGripper_rad),
                   "the gripper's opening is an angle in radians");
    }
    row.gripper_rad = value[kGripper];
    if (layout.field[kButtons] != kAbsent) {
      if (!(value[kButtons] >= 0 && value[kButtons] < 4294967296.0) || std::trunc(value[kButtons]) != value[kButtons]) {
        return fault(layout.field[kButtons] + 1, "buttons is not a bit mask of 32 bits", "0 for none");
      }
      row.buttons = static_cast<std::uint32_t>(value[kButtons]);
    }
    return {};
  }

  std::string_view rest_;
  std::string_view name_;
  const std::atomic<bool>* given_up_;
  std::size_t line_ = 0;
  std::size_t width_ = 0;
  std::vector<std::string_view> fields_;
};

}  // namespace

Result<std::shared_ptr<const PoseTrack>> parsePoseCsv(std::string_view text, std::string_view name,
                                                      const std::atomic<bool>* given_up) {
  auto track = std::make_shared<PoseTrack>();
  Layout layout;
  Result<void> parsed = Parser(text, name, given_up).run(track->rows_, layout);
  if (!parsed) return parsed.error();
  track->rows_.shrink_to_fit();
  // A recording has all columns, whatever the device had: what never changes from its rest was not there.
  for (const PoseRow& row : track->rows_) {
    track->has_rotation_ = track->has_rotation_ || row.q.vec().squaredNorm() > 0;
    track->has_gripper_ = track->has_gripper_ || row.gripper_rad != 0;
    track->has_buttons_ = track->has_buttons_ || row.buttons != 0;
  }
  return std::shared_ptr<const PoseTrack>(std::move(track));
}

}  // namespace hapticd
