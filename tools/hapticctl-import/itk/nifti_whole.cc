// ITK reads what is missing at the end of a NIfTI file as zeros, and takes no notice of gzip's checksum. It takes a
// spacing that is none for 1, and puts spacings into millimetres, but not origins. Of two places that a header names it
// takes one and does not say so. Values of scan.nii.gz it reads from scan.nii if that is there.
#include <fmt/core.h>

#include <algorithm>
#include <array>
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

/** Numbers of a header (nifti1.h); turned if from a machine of the other order. */
class Header {
 public:
  explicit Header(const std::string& bytes) : bytes_(bytes) { other_order_ = get<std::int32_t>(0) != 348; }

  template <class T>
  [[nodiscard]] T get(std::size_t at) const {
    char raw[sizeof(T)];
    std::memcpy(raw, bytes_.data() + at, sizeof raw);
    if (other_order_) std::reverse(raw, raw + sizeof raw);
    T value;
    std::memcpy(&value, raw, sizeof raw);
    return value;
  }
  [[nodiscard]] double number(std::size_t at) const { return static_cast<double>(get<float>(at)); }

 private:
  const std::string& bytes_;
  bool other_order_ = false;
};

/** ITK does that with spacings alone. */
void putIntoMillimetres(const Header& header, double mm_per_unit, Image& image) {
  if (mm_per_unit == 1) return;
  for (const std::size_t at : {292, 268}) {  // Of the sform, a row after the other, and of the qform.
    bool as_said = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const double said = header.number(at + k * (at == 292 ? 16 : 4));
      as_said = as_said && std::abs(std::abs(image.origin[k]) - std::abs(said)) <= 1e-6 * std::abs(said);
    }
    if (!as_said) continue;
    for (double& x : image.origin) x *= mm_per_unit;
    return;
  }
}

/** Where an index stands, in the header's unit: to the right, in front, above. */
struct Place {
  std::array<Double3, 3> rows{};
  Double3 offset{};

  /** In millimetres to the left, behind, above. */
  [[nodiscard]] Double3 of(const Double3& index, double mm_per_unit) const {
    Double3 p = offset;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) p[k] += rows[k][axis] * index[axis];
      p[k] *= k < 2 ? -mm_per_unit : mm_per_unit;
    }
    return p;
  }
};

/** By the rotation, spacings and offset of the header. */
Place byQform(const Header& header) {
  const double b = header.number(256), c = header.number(260), d = header.number(264);
  const double a = std::sqrt(std::max(0.0, 1 - b * b - c * c - d * d));
  const double turn[3][3] = {{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
                             {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)},
                             {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c}};
  std::array<Double3, 3> rows{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double pitch = (axis == 2 && header.number(76) < 0 ? -1 : 1) * header.number(80 + 4 * axis);
    for (std::size_t k = 0; k < 3; ++k) rows[k][axis] = turn[k][axis] * pitch;
  }
  return {rows, {header.number(268), header.number(272), header.number(276)}};
}

/** By the matrix of the header. */
Place bySform(const Header& header) {
  Place place;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t row = 280 + 16 * k;
    for (std::size_t axis = 0; axis < 3; ++axis) place.rows[k][axis] = header.number(row + 4 * axis);
    place.offset[k] = header.number(row + 12);
  }
  return place;
}

double distance(const Double3& a, const Double3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/** Where a header names two places, and they differ: which of them ITK has taken, in words. */
std::string whichPlace(const Header& header, const Image& image, double mm_per_unit) {
  if (header.get<std::int16_t>(252) <= 0 || header.get<std::int16_t>(254) <= 0) return {};
  const Place places[] = {byQform(header), bySform(header)};
  double apart = 0, off[2] = {0, 0};
  for (int corner = 0; corner < 8; ++corner) {
    Double3 i{}, taken = image.origin;
    for (std::size_t k = 0; k < 3; ++k) {
      i[k] = corner >> k & 1 ? image.size[k] - 1 : 0;
      for (std::size_t a = 0; a < 3; ++a) taken[a] += i[k] * image.step[k][a];
    }
    const Double3 by_qform = places[0].of(i, mm_per_unit), by_sform = places[1].of(i, mm_per_unit);
    off[0] = std::max(off[0], distance(by_qform, taken));
    off[1] = std::max(off[1], distance(by_sform, taken));
    apart = std::max(apart, distance(by_qform, by_sform));
  }
  constexpr double kRounding = 0.1;  // Of a step: headers hold floats, and quaternions without their fourth number.
  if (!(apart > kRounding * std::min({spacing(image, 0), spacing(image, 1), spacing(image, 2)}))) return {};
  return fmt::format(", placed by its {}; its {} puts it {:.3g} mm elsewhere", off[0] <= off[1] ? "qform" : "sform",
                     off[0] <= off[1] ? "sform" : "qform", apart);
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
  const Header header(head);
  const auto bits = header.get<std::int16_t>(72);
  const double offset = header.number(108);
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
    const auto step = header.get<float>(80 + 4 * k);
    if (!std::isfinite(step) || step == 0)
      throw ImportError("spacing", fmt::format("is {} along axis {}", step, k + 1), "correct the header");
  }
  const int unit = head[123] & 7;  // 1: metres, 3: micrometres.
  const double mm_per_unit = unit == 1 ? 1e3 : unit == 3 ? 1e-3 : 1;
  putIntoMillimetres(header, mm_per_unit, image);
  image.format += whichPlace(header, image, mm_per_unit);
}

}  // namespace hapticctl_import
