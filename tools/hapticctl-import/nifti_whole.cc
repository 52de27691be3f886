// ITK reads what is missing at the end of a NIfTI file as zeros, and takes no notice of gzip's checksum.
#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "tools/hapticctl-import/itk_values.h"

namespace hapticctl_import {
namespace {

/** How many bytes a file holds, unpacked if it is gzip, and the first of them. */
std::uint64_t unpackedBytes(const std::string& path, std::string& head) {
  const gzFile file = ::gzopen(path.c_str(), "rb");
  if (file == nullptr) throw ImportError(path, "cannot be read", "does it exist?");
  char block[1 << 16];
  std::uint64_t bytes = 0;
  int n = 0;
  while ((n = ::gzread(file, block, sizeof block)) > 0) {
    if (bytes == 0) head.assign(block, static_cast<std::size_t>(n));
    bytes += static_cast<std::uint64_t>(n);
  }
  if (::gzclose(file) != Z_OK || n < 0)
    throw ImportError("compressed data", "is damaged or cut short", "fetch the file again");
  return bytes;
}

}  // namespace

void requireWholeNifti(const std::string& path, std::uint64_t values) {
  std::string head;
  std::uint64_t bytes = unpackedBytes(path, head);
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
      if (std::filesystem::exists(data)) bytes = unpackedBytes(data, head);
  }
  const double needed = std::max(0.0, offset) + static_cast<double>(values) * bits / 8;
  if (!(bits > 0 && static_cast<double>(bytes) >= needed)) {
    throw ImportError("data", fmt::format("{} bytes are there, {:.0f} are needed", bytes, needed),
                      "is the file whole?");
  }
}

}  // namespace hapticctl_import
