#include "tools/haptic-bench/result/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

constexpr const char* kRemedy = "a file that haptic-bench has written with --csv";
constexpr const char* kAsPrinted = "the file as it was printed, or measure again";

/** Fields of a CSV line; a quote within quotes is doubled. False where quotes do not close. */
bool splitLine(std::string_view line, std::vector<std::string>& fields) {
  fields.assign(1, "");
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return !quoted;
}

/** Reads line by line; a header says what the lines below it are. */
class ResultsReader {
 public:
  explicit ResultsReader(std::string where) : where_(std::move(where)) {}

  void line(std::string_view text) {
    ++number_;
    if (text.empty()) return;
    if (text[0] == '#') {
      comment(text.substr(std::min<std::size_t>(2, text.size())));
    } else if (const TableForm* form = formOfHeader(text); form != nullptr || text == kResultsHeader) {
      endOfTable();
      form_ = form;
      header_ = number_;
      rows_ = 0;
    } else {
      if (!splitLine(text, fields_)) fault("its quotes do not close", kAsPrinted);
      if (const std::string wrong = faultOfHeader(fields_); !wrong.empty())
        fault(wrong, "measure again with this version, and compare files of one version");
      ++rows_;
      form_ != nullptr ? row() : round();
    }
  }

  /** What follows the last line break is cut off, as the number in it may be. */
  [[noreturn]] void cutOff() {
    ++number_;
    fault("it is cut off: it does not end", kAsPrinted);
  }

  [[nodiscard]] Results finish() {
    endOfTable();
    if (out_.all.empty() && header_ == 0) throw Failure(where_, "there are no results in it", kRemedy);
    if (out_.all.empty()) number_ = header_, fault("nothing follows this header", kAsPrinted);
    return std::move(out_);
  }

 private:
  [[noreturn]] void fault(const std::string& what, const std::string& remedy) const {
    throw Failure(fmt::format("{}, line {}", where_, number_), what, remedy);
  }

  void endOfTable() {
    if (form_ != nullptr && rows_ == 0) number_ = header_, fault("no row follows this header", kAsPrinted);
  }

  void comment(std::string_view text) {
    constexpr std::string_view kSettings = "settings of ";
    const std::size_t colon = text.find(": ");
    if (text.compare(0, kSettings.size(), kSettings) != 0 || colon == std::string_view::npos) {
      out_.machine.emplace_back(text);
      return;
    }
    const auto [known, fresh] =
        out_.settings.emplace(text.substr(kSettings.size(), colon - kSettings.size()), text.substr(colon + 2));
    if (!fresh && known->second != text.substr(colon + 2))
      fault(fmt::format("{} stands above with other settings", known->first), "a file for each");
  }

  /** A line of kResultsHeader. */
  void round() {
    double round = 0, value = 0;
    if (fields_.size() != 5 || !parseNumber(fields_[3], round) || !parseNumber(fields_[4], value))
      fault("it is no result", kRemedy);
    if (out_.all.empty() || out_.all.back().benchmark != fields_[0] || out_.all.back().series.name != fields_[1]) {
      if (out_.find(fields_[0], fields_[1]) != nullptr)
        fault("this quantity stands above already", "each benchmark once in a file");
      out_.all.push_back({fields_[0], {fields_[1], fields_[2], {}}, nullptr, number_, {}, false});
    }
    std::vector<double>& rounds = out_.all.back().series.rounds;
    if (round != static_cast<double>(rounds.size() + 1))
      fault(fmt::format("round {} follows {} rounds", fields_[3], rounds.size()), kAsPrinted);
    rounds.push_back(value);
  }

  /** A line of a table: one round of all its columns. */
  void row() {
    const std::span<const TableColumn> columns = form_->columns;
    if (fields_.size() != columns.size()) {
      fault(fmt::format("it has {} fields, and {} the header in line {}", fields_.size(), columns.size(), header_),
            kAsPrinted);
    }
    std::string name = form_->benchmark, group = name;
    std::vector<double> values(columns.size());
    bool calm = false;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const bool grouped = columns[i].role == TableColumn::Role::kGroup;
      const bool key = grouped || columns[i].role == TableColumn::Role::kKey;
      const bool words = key && columns[i].unit[0] == '\0';
      if (!words && !readCell(fields_[i], values[i]))
        fault(fmt::format("\"{}\" in column {} is no number", fields_[i], columns[i].name), kAsPrinted);
      if (key) name += fmt::format(" {}={}", columns[i].name, fields_[i]);
      calm = calm || (form_->calm_key != nullptr && std::string_view(columns[i].name) == form_->calm_key &&
                      values[i] <= form_->calm_most);
      if (grouped) group += fmt::format(" {}={}", columns[i].name, fields_[i]);
    }
    if (out_.holds(name)) fault("this row stands above already", "each row once in a file");
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const TableColumn& column = columns[i];
      if (column.role <= TableColumn::Role::kGroup || column.role == TableColumn::Role::kAside) continue;
      out_.all.push_back({name,
                          {column.name, column.unit, {values[i]}},
                          column.role == TableColumn::Role::kTimed ? nullptr : &column,
                          number_,
                          group,
                          calm});
    }
  }

  std::string where_;
  Results out_;
  std::vector<std::string> fields_;
  const TableForm* form_ = nullptr;
  std::size_t number_ = 0, header_ = 0, rows_ = 0;  // Lines from 1; rows since the header.
};

}  // namespace

std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

Results Results::parse(std::string_view text, const std::string& where) {
  ResultsReader reader(where);
  if (constexpr std::string_view kMark = "\xef\xbb\xbf"; text.substr(0, kMark.size()) == kMark)
    text.remove_prefix(kMark.size());  // Byte order mark, as of spreadsheets.
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) reader.cutOff();
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    reader.line(line);
  }
  return reader.finish();
}

Results Results::read(const std::string& path) {
  if (std::error_code none; std::filesystem::is_character_file(path, none))
    throw Failure(path, "it is a device, without an end", kRemedy);
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (!file || !(text << file.rdbuf())) throw Failure(path, "it cannot be read or is empty", kRemedy);
  return parse(text.str(), path);
}

const StoredResult* Results::find(const std::string& benchmark, const std::string& quantity) const {
  for (const StoredResult& r : all) {
    if (r.series.name == quantity && r.benchmark == benchmark) return &r;
  }
  return nullptr;
}

bool Results::holds(const std::string& benchmark) const {
  return std::any_of(all.begin(), all.end(), [&](const StoredResult& r) { return r.benchmark == benchmark; });
}

}  // namespace haptic_bench
