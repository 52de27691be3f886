// MetaImage (.mha, .mhd): "Key = value" lines, the last of which names the data.
#include <fmt/core.h>

#include <map>

#include "tools/hapticctl-import/image_file.h"

namespace hapticctl_import {
namespace {

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '\r')) s.remove_suffix(1);
  return s;
}

}  // namespace

Image parseMetaImage(std::string_view bytes, const OpenFile& open) {
  std::map<std::string, std::string, std::less<>> fields;
  std::size_t at = 0;
  while (fields.count("ElementDataFile") == 0) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string_view::npos || end - at > 4096)
      throw ImportError("header", "has no line ElementDataFile", "is it whole?");
    const std::string_view line = bytes.substr(at, end - at);
    at = end + 1;
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    fields.emplace(trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1)));
  }
  const auto field = [&](std::initializer_list<const char*> names) -> const std::string* {
    for (const char* name : names)
      if (const auto f = fields.find(name); f != fields.end()) return &f->second;
    return nullptr;
  };
  const auto isTrue = [&](std::initializer_list<const char*> names) {
    const std::string* value = field(names);
    return value != nullptr && (*value == "True" || *value == "true" || *value == "1");
  };
  Image image;
  image.format = "MetaImage";
  if (const auto* n = field({"ElementNumberOfChannels"}); n != nullptr && *n != "1")
    throw ImportError("ElementNumberOfChannels", fmt::format("is {}", *n), "only one component can be used");
  const auto* size = field({"DimSize"});
  if (size == nullptr) throw ImportError("DimSize", "is missing", "is it whole?");
  image.size = sizesIn(*size, "DimSize");
  Double3 step{1, 1, 1};
  if (const auto* s = field({"ElementSpacing", "ElementSize"})) {
    const auto numbers = numbersIn(*s, "ElementSpacing", 3);
    for (std::size_t k = 0; k < 3; ++k) step[k] = numbers[k];
  }
  for (std::size_t k = 0; k < 3; ++k) image.step[k][k] = step[k];
  if (const auto* m = field({"TransformMatrix", "Orientation", "Rotation"})) {
    const auto numbers = numbersIn(*m, "TransformMatrix", 9);  // Axis by axis.
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t a = 0; a < 3; ++a) image.step[k][a] = numbers[3 * k + a] * step[k];
  }
  if (const auto* o = field({"Offset", "Position", "Origin"})) {
    const auto numbers = numbersIn(*o, "Offset", 3);
    for (std::size_t k = 0; k < 3; ++k) image.origin[k] = numbers[k];
  }
  const auto* type = field({"ElementType"});
  const auto sample = sampleOf(type == nullptr ? "" : *type);
  if (!sample) throw ImportError("ElementType", "is not a kind of number that is known", "convert the image");
  const std::string& data = *field({"ElementDataFile"});
  std::string own;
  std::string_view values = bytes.substr(at);
  if (data != "LOCAL" && data != "local") {
    own = open(data);
    values = own;
  }
  if (isTrue({"CompressedData"})) {
    own = inflated(values, bytesOf(image.size, *sample));
    values = own;
  }
  decode(values, *sample, isTrue({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}), 1, 0, image);
  checkPlace(image);
  return image;
}

}  // namespace hapticctl_import
