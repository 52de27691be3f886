#include "tools/hapticctl-import/header/data_place.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "tools/hapticctl-import/header/data_files.h"
#include "tools/hapticctl-import/header/header_lines.h"
#include "tools/hapticctl-import/header/stream_length.h"
#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {
namespace {

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
    place.binary = binary;
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
      if (!place.in_several) continue;
      place.several = value;
      place.list = std::min<std::uint64_t>(lines.passed(), head.size());
      if (value.substr(0, 4) == "LIST") break;  // Names follow.
    }
  }
  if (!away) place.skip = lines.passed();
  place.binary = binary && !lines_skipped;
  place.countable = place.binary && !place.in_several;
  return place;
}

namespace {

void requireWhole(const std::string& path, const std::string& file, const DataPlace& place, std::uint64_t needed) {
  const std::string values =
      file.empty() ? path : (std::filesystem::path(path).parent_path() / file).lexically_normal().string();
  if (!std::filesystem::is_regular_file(values))
    throw ImportError(file, "cannot be read", "is the file of values there that it names?");
  const StreamLength length = lengthOf(values, place.skip, place.bytes, place.packed);
  const std::uint64_t there = length.bytes - std::min(length.bytes, place.unpacked_skip);
  if (there >= needed && length.end == StreamEnd::kWhole) return;
  throw ImportError(file.empty() ? "values" : file,
                    fmt::format("{} bytes {}, {} are needed{}", there, place.packed ? "can be unpacked" : "are there",
                                needed, inWords(length.end)),
                    "is the file whole? Fetch it again");
}

}  // namespace

void requireWhole(const std::string& path, const std::string& format, std::uint64_t needed) {
  const std::string head = headOf(path);
  const DataPlace place = format == "NRRD" ? nrrdPlace(head) : metaImagePlace(head);
  if (place.countable && place.packed && place.file.empty() && format != "NRRD" && place.bytes == 0) {
    throw ImportError("CompressedDataSize", "is missing, and MetaIO unpacks nothing behind the header without it",
                      fmt::format("put a line CompressedDataSize = {} before that of ElementDataFile",
                                  std::filesystem::file_size(path) - place.skip));
  }
  if (place.countable) return requireWhole(path, place.file, place, needed);
  if (!place.in_several || !place.binary) return;
  if (format == "NRRD") {
    if (head.size() == kMostHeader) return;  // The list may be longer.
    const std::vector<std::string> files = nrrdFiles(place.several, std::string_view(head).substr(place.list));
    for (const std::string& one : files) requireWhole(path, one, place, needed / files.size());
    return;
  }
  if (place.packed && (place.bytes > 0 || place.skip > 0)) {
    throw ImportError(place.bytes > 0 ? "CompressedDataSize" : "HeaderSize",
                      "is one for several compressed files, and MetaIO would read too little of each",
                      "take that line out, or write the values into one file");
  }
  const std::vector<std::string> files = metaImageFiles(head);
  for (const std::string& one : files) requireWhole(path, one, place, needed / files.size());
}

}  // namespace hapticctl_import
