// NRRD (.nrrd, .nhdr): "key: value" lines, an empty one, then the data or the name of its file among the keys.
#include <fmt/core.h>

#include <map>

#include "tools/hapticctl-import/image_file.h"

namespace hapticctl_import {

Image parseNrrd(std::string_view bytes, const OpenFile& open) {
  std::map<std::string, std::string, std::less<>> fields;
  std::size_t at = bytes.find('\n');
  for (;;) {
    const std::size_t begin = at + 1, end = at == std::string_view::npos ? at : bytes.find('\n', begin);
    if (end == std::string_view::npos) {
      if (at != std::string_view::npos && fields.count("data file") + fields.count("datafile") > 0) break;
      throw ImportError("header", "does not end", "is it whole?");
    }
    at = end;
    std::string_view line = bytes.substr(begin, end - begin);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty()) break;
    const std::size_t colon = line.find(": ");
    if (line[0] != '#' && colon != std::string_view::npos)
      fields.emplace(line.substr(0, colon), line.substr(colon + 2));
  }
  const auto field = [&](const char* name) -> std::string {
    const auto f = fields.find(name);
    return f == fields.end() ? std::string() : f->second;
  };
  Image image;
  image.format = "NRRD";
  if (field("dimension") != "3")
    throw ImportError("dimension", fmt::format("is '{}'", field("dimension")), "only three axes can be used");
  image.size = sizesIn(field("sizes"), "sizes");
  const auto sample = sampleOf(field("type"));
  if (!sample) throw ImportError("type", fmt::format("'{}' is not known", field("type")), "convert the image");
  if (!field("spacings").empty()) {
    const auto numbers = numbersIn(field("spacings"), "spacings", 3);
    for (std::size_t k = 0; k < 3; ++k) image.step[k][k] = numbers[k];
  }
  if (!field("space directions").empty()) {
    const auto numbers = numbersIn(field("space directions"), "space directions", 9);
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t a = 0; a < 3; ++a) image.step[k][a] = numbers[3 * k + a];
  }
  if (!field("space origin").empty()) {
    const auto numbers = numbersIn(field("space origin"), "space origin", 3);
    for (std::size_t k = 0; k < 3; ++k) image.origin[k] = numbers[k];
  }
  const std::string space = field("space");
  // To left-posterior-superior.
  const bool flip_x = space == "right-anterior-superior" || space == "RAS";
  const bool flip_y = flip_x || space == "left-anterior-superior" || space == "LAS";
  for (std::size_t a = 0; a < 2; ++a) {
    if (!(a == 0 ? flip_x : flip_y)) continue;
    image.origin[a] = -image.origin[a];
    for (Double3& s : image.step) s[a] = -s[a];
  }
  std::string own;
  std::string_view values = bytes.substr(std::min(bytes.size(), at == std::string_view::npos ? at : at + 1));
  const std::string data = field("data file").empty() ? field("datafile") : field("data file");
  if (!data.empty()) {
    own = open(data);
    values = own;
  }
  const std::string encoding = field("encoding");
  if (encoding == "gzip" || encoding == "gz") {
    // A data file of its own was unpacked when it was read.
    if (values.size() > 2 && values[0] == '\x1f' && values[1] == '\x8b') {
      own = inflated(values, bytesOf(image.size, *sample));
      values = own;
    }
  } else if (encoding != "raw") {
    throw ImportError("encoding", fmt::format("'{}' is not known", encoding), "raw and gzip are");
  }
  decode(values, *sample, field("endian") == "big", 1, 0, image);
  checkPlace(image);
  return image;
}

}  // namespace hapticctl_import
