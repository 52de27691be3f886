// ITK reads what is missing at the end of a NIfTI file as zeros, and takes no notice of gzip's checksum. It takes a
// spacing that is none for 1, and puts spacings into millimetres, but not origins.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tools/hapticctl-import/itk_values.h"
#include "tools/hapticctl-import/stream_length.h"

namespace hapticctl_import {
namespace {

StreamLength lengthOfAll(const std::string& path) {
  char magic[2] = {};
  std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
  return lengthOf(path, 0, 0, magic[0] == '\x1f' && magic[1] == '\x8b');
}

}  // namespace

bool isNifti2(const std::string& path) {
  const std::string head = lengthOfAll(path).head;
  return head.size() >= 8 && (head.compare(4, 3, "n+2") == 0 || head.compare(4, 3, "ni2") == 0);
}

void checkNifti(const std::string& path, Image& image) {
  const std::size_t values = image.values.size();
  StreamLength length = lengthOfAll(path);
  const std::string head = std::move(length.head);
  if (head.size() < 348) throw ImportError("header", "is cut short", "is the file whole?");
  std::int32_t header_bytes = 0;
  std::memcpy(&header_bytes, head.data(), 4);
  const auto get = [&](std::size_t at, auto value) {  // nifti1.h; turned if from a machine of the other order.
    char raw[sizeof value];
    std::memcpy(raw, head.data() + at, sizeof raw);
    if (header_bytes != 348) std::reverse(raw, raw + sizeof raw);
    std::memcpy(&value, raw, sizeof raw);
    return value;
  };
  const std::int16_t bits = get(72, std::int16_t{});
  const double offset = static_cast<double>(get(108, float{}));
  if (head.compare(344, 3, "ni1") == 0) {  // The data are in a file beside it.
    for (const std::filesystem::path& data :
         {std::filesystem::path(path).replace_extension("img"),
          std::filesystem::path(path).replace_extension("").replace_extension("img.gz")})
      if (std::filesystem::exists(data)) length = lengthOfAll(data);
  }
  const double needed = std::max(0.0, offset) + static_cast<double>(values) * bits / 8;
  if (!(bits > 0 && static_cast<double>(length.bytes) >= needed && length.end == StreamEnd::kWhole)) {
    throw ImportError("data",
                      fmt::format("{} bytes are there, {:.0f} are needed{}", length.bytes, needed, inWords(length.end)),
                      "is the file whole? Fetch it again");
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const float spacing = get(80 + 4 * k, float{});
    if (!std::isfinite(spacing) || spacing == 0)
      throw ImportError("spacing", fmt::format("is {} along axis {}", spacing, k + 1), "correct the header");
  }
  const int unit = head[123] & 7;  // 1: metres, 3: micrometres.
  if (unit != 1 && unit != 3) return;
  for (const std::size_t at : {292, 268}) {  // Of the sform, a row after the other, and of the qform.
    bool as_said = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const double said = static_cast<double>(get(at + k * (at == 292 ? 16 : 4), float{}));
      as_said = as_said && std::abs(std::abs(image.origin[k]) - std::abs(said)) <= 1e-6 * std::abs(said);
    }
    if (!as_said) continue;
    for (double& x : image.origin) x *= unit == 1 ? 1e3 : 1e-3;
    return;
  }
}

}  // namespace hapticctl_import
