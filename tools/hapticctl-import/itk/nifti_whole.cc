// ITK reads what is missing at the end of a NIfTI file as zeros, and takes no notice of gzip's checksum. It takes a
// spacing that is none for 1, and puts spacings into millimetres, but not origins. Values of scan.nii.gz it reads from
// scan.nii if that is there.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/header/header_lines.h"
#include "tools/hapticctl-import/header/stream_length.h"
#include "tools/hapticctl-import/itk/itk_values.h"

namespace hapticctl_import {
namespace {

StreamLength lengthOfAll(const std::string& path) {
  char magic[2] = {};
  std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
  return lengthOf(path, 0, 0, magic[0] == '\x1f' && magic[1] == '\x8b');
}

/** Takes an ending away, in small letters or capitals; false: it is another one. */
bool take(std::string& path, const std::string& ending) {
  if (path.size() <= ending.size() || lower(path.substr(path.size() - ending.size())) != ending) return false;
  path.resize(path.size() - ending.size());
  return true;
}

/** The first of these that is there, in the order in which ITK looks; empty: none. */
std::string firstOf(const std::string& base, const char* ending, bool capitals) {
  for (const std::string more : {"", ".gz"}) {
    std::string path = ending + more;
    if (capitals)
      for (char& c : path) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
    path.insert(0, base);
    if (std::filesystem::exists(path)) return path;
  }
  return {};
}

}  // namespace

std::string niftiHeader(const std::string& path) {
  std::string base = path;
  (void)take(base, ".gz");
  const bool capitals = base.back() == 'G';
  if (!take(base, ".img")) return path;
  const std::string header = firstOf(base, ".hdr", capitals);
  return header.empty() ? path : header;
}

void requireOwnValues(const std::string& path) {
  std::string plain = path;
  if (!take(plain, ".gz") || lower(std::filesystem::path(plain).extension().string()) != ".nii") return;
  if (!std::filesystem::is_regular_file(plain) || readFile(plain) == readFile(path)) return;
  throw ImportError(std::filesystem::path(plain).filename().string(),
                    "lies beside it, is another image, and would be read in its place",
                    "move or rename one of the two");
}

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
    std::string base = path;
    (void)take(base, ".gz");
    const bool capitals = base.back() == 'R';
    if (take(base, ".hdr"))
      if (const std::string data = firstOf(base, ".img", capitals); !data.empty()) length = lengthOfAll(data);
  } else if (head.compare(344, 3, "n+1") != 0) {
    throw ImportError({}, "is ANALYZE 7.5, which does not say how it lies; of its kind NIfTI-1 is read",
                      "convert it to NIfTI-1");
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
