#include "tools/haptic-bench/result/results.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

constexpr const char* kRemedy =
    "what --csv prints of all but collide, zwidth, sixdof and stability, which have columns of their own";

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

}  // namespace

std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

Results Results::parse(std::string_view text, const std::string& where) {
  Results results;
  std::vector<std::string> fields;
  for (std::size_t number = 1; !text.empty(); ++number) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line == kResultsHeader) continue;
    if (line[0] == '#') {
      results.machine.emplace_back(line.substr(std::min<std::size_t>(2, line.size())));
      continue;
    }
    double round = 0, value = 0;
    const bool fits = splitLine(line, fields) && fields.size() == 5 && parseNumber(fields[3], round);
    if (!fits || !parseNumber(fields[4], value)) {
      throw Failure(fmt::format("{}, line {}", where, number), "it is no result", kRemedy);
    }
    if (results.all.empty() || results.all.back().benchmark != fields[0] ||
        results.all.back().series.name != fields[1]) {
      if (results.find(fields[0], fields[1]) != nullptr) {
        throw Failure(fmt::format("{}, line {}", where, number), "this quantity stands above already",
                      "each benchmark once in a file");
      }
      results.all.push_back({fields[0], {fields[1], fields[2], {}}});
    }
    std::vector<double>& rounds = results.all.back().series.rounds;
    if (round != static_cast<double>(rounds.size() + 1)) {
      throw Failure(fmt::format("{}, line {}", where, number),
                    fmt::format("round {} follows {} rounds", fields[3], rounds.size()), "a file as it was printed");
    }
    rounds.push_back(value);
  }
  if (results.all.empty()) throw Failure(where, "there are no results in it", kRemedy);
  return results;
}

Results Results::read(const std::string& path) {
  if (std::error_code none; std::filesystem::is_character_file(path, none))
    throw Failure(path, "it is a device, without an end", kRemedy);
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (!file || !(text << file.rdbuf())) throw Failure(path, "it cannot be read or is empty", kRemedy);
  return parse(text.str(), path);
}

const Series* Results::find(const std::string& benchmark, const std::string& quantity) const {
  for (const StoredResult& r : all) {
    if (r.series.name == quantity && r.benchmark == benchmark) return &r.series;
  }
  return nullptr;
}

}  // namespace haptic_bench
