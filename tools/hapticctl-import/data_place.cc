#include "tools/hapticctl-import/data_place.h"

#include <fmt/core.h>

#include <charconv>
#include <filesystem>
#include <fstream>

#include "tools/hapticctl-import/image.h"
#include "tools/hapticctl-import/stream_length.h"

namespace hapticctl_import {
namespace {

constexpr std::size_t kMostHeader = 1 << 20;

std::string_view stripped(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const auto first = text.find_first_not_of(kBlanks);
  return first == std::string_view::npos ? "" : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return out;
}

/** What is no count, or negative, is 0. */
std::uint64_t countIn(std::string_view text) {
  std::uint64_t n = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), n);
  return problem == std::errc() ? n : 0;
}

/** Lines of a header one after the other. */
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    const auto end = std::min(text_.find('\n', at_), text_.size());
    line = text_.substr(at_, end - at_);
    at_ = end + 1;
    return true;
  }
  [[nodiscard]] std::uint64_t passed() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

/** Of several files "LIST", or "name%03d.raw 1 9 1". */
void takeFile(DataPlace& place, std::string_view name) {
  place.in_several = name.substr(0, 4) == "LIST" || name.find('%') != std::string_view::npos;
  if (!place.in_several) place.file = name;
}

}  // namespace

DataPlace metaImagePlace(std::string_view head) {
  DataPlace place;
  bool binary = true;
  Lines lines(head);
  std::string_view line;
  while (lines.next(line)) {
    const auto sign = line.find_first_of("=:");
    if (sign == std::string_view::npos) continue;
    const std::string_view key = stripped(line.substr(0, sign)), value = stripped(line.substr(sign + 1));
    const bool yes = !value.empty() && std::string_view("Tt1").find(value[0]) != std::string_view::npos;
    if (key == "CompressedData") place.packed = yes;
    if (key == "CompressedDataSize") place.bytes = countIn(value);
    if (key == "BinaryData") binary = yes;
    if (key == "HeaderSize") place.skip = countIn(value);
    if (key != "ElementDataFile") continue;
    if (lower(value) != "local") {
      takeFile(place, value);
    } else if (place.skip == 0) {
      place.skip = lines.passed();
    }
    if (!place.packed) place.bytes = 0;
    place.countable = binary && !place.in_several;
    break;
  }
  return place;
}

DataPlace nrrdPlace(std::string_view head) {
  DataPlace place;
  bool binary = false, lines_skipped = false, away = false;
  Lines lines(head);
  std::string_view line;
  while (lines.next(line) && !stripped(line).empty()) {
    const auto sign = line.find(':');
    if (sign == std::string_view::npos || line[0] == '#' || line.substr(sign, 2) == ":=") continue;
    const std::string key = lower(stripped(line.substr(0, sign)));
    const std::string_view value = stripped(line.substr(sign + 1));
    if (key == "encoding") {
      place.packed = lower(value) == "gzip" || lower(value) == "gz";
      binary = place.packed || lower(value) == "raw";
    }
    if (key == "byte skip" || key == "byteskip") place.unpacked_skip = countIn(value);
    if (key == "line skip" || key == "lineskip") lines_skipped = countIn(value) > 0;
    if (key == "data file" || key == "datafile") {
      away = true;
      takeFile(place, value);
      if (place.in_several) break;  // A list follows.
    }
  }
  if (!away) place.skip = lines.passed();
  place.countable = binary && !lines_skipped && !place.in_several;
  return place;
}

void requireWhole(const std::string& path, const std::string& format, std::uint64_t needed) {
  std::string head(kMostHeader, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  const DataPlace place = format == "NRRD" ? nrrdPlace(head) : metaImagePlace(head);
  if (place.in_several && place.packed && format == "MetaImage") {
    throw ImportError("values", "are compressed in several files, and nothing would tell that one is cut short",
                      "write them uncompressed, or into one file");
  }
  if (!place.countable) return;
  const std::string values =
      place.file.empty() ? path : (std::filesystem::path(path).parent_path() / place.file).lexically_normal().string();
  if (!std::filesystem::is_regular_file(values))
    throw ImportError(place.file, "cannot be read", "is the file of values there that it names?");
  const StreamLength length = lengthOf(values, place.skip, place.bytes, place.packed);
  const std::uint64_t there = length.bytes - std::min(length.bytes, place.unpacked_skip);
  if (there >= needed && length.end == StreamEnd::kWhole) return;
  throw ImportError(place.file.empty() ? "values" : place.file,
                    fmt::format("{} bytes {}, {} are needed{}", there, place.packed ? "can be unpacked" : "are there",
                                needed, inWords(length.end)),
                    "is the file whole? Fetch it again");
}

}  // namespace hapticctl_import
