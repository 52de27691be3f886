// ITK reads what is missing at the end of a NIfTI file as zeros, and takes no notice of gzip's checksum.
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

void requireWholeNifti(const std::string& path, std::uint64_t values) {
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
}

}  // namespace hapticctl_import
