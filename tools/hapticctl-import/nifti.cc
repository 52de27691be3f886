// NIfTI-1 in one file (.nii, .nii.gz): a header of 348 bytes, whose place for the data and for the patient is in it.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tools/hapticctl-import/image_file.h"

namespace hapticctl_import {
namespace {

/** Fields at their offsets (nifti1.h), turned if the file comes from a machine of the other order. */
class Header {
 public:
  explicit Header(std::string_view bytes) : bytes_(bytes) {
    swap_ = get<std::int32_t>(0) != 348;
    if (get<std::int32_t>(0) != 348) throw ImportError("header", "has not the 348 bytes of NIfTI-1");
  }
  template <class T>
  [[nodiscard]] T get(std::size_t at) const {
    char raw[sizeof(T)];
    std::memcpy(raw, bytes_.data() + at, sizeof raw);
    if (swap_) std::reverse(raw, raw + sizeof raw);
    T value;
    std::memcpy(&value, raw, sizeof value);
    return value;
  }
  [[nodiscard]] double real(std::size_t at) const { return static_cast<double>(get<float>(at)); }
  [[nodiscard]] bool swapped() const { return swap_; }

 private:
  std::string_view bytes_;
  bool swap_ = false;
};

/** The quaternion's rotation with the pixels' sizes (method 2 of nifti1.h). */
void placeByQuaternion(const Header& h, Image& image) {
  const double b = h.real(256), c = h.real(260), d = h.real(264);
  const double a = std::sqrt(std::max(0.0, 1 - b * b - c * c - d * d));
  const double r[3][3] = {{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
                          {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)},
                          {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c}};
  for (std::size_t k = 0; k < 3; ++k) {
    const double size = h.real(80 + 4 * k) * (k == 2 && h.real(76) < 0 ? -1 : 1);
    for (std::size_t row = 0; row < 3; ++row) image.step[k][row] = r[row][k] * size;
    image.origin[k] = h.real(268 + 4 * k);
  }
}

}  // namespace

Image parseNifti(std::string_view bytes) {
  const Header h(bytes);
  Image image;
  image.format = "NIfTI-1";
  const int axes = h.get<std::int16_t>(40);
  for (int k = 4; k <= std::min(axes, 7); ++k)
    if (h.get<std::int16_t>(40 + 2 * static_cast<std::size_t>(k)) > 1)
      throw ImportError("dim", "has more than three axes", "take one time or component out of it first");
  for (std::size_t k = 0; k < 3; ++k) {
    const int n = h.get<std::int16_t>(42 + 2 * k);
    image.size[k] = n > 0 ? static_cast<std::uint32_t>(n) : 0;
  }
  Sample sample{};
  switch (h.get<std::int16_t>(70)) {
    case 2:
      sample = Sample::kUint8;
      break;
    case 4:
      sample = Sample::kInt16;
      break;
    case 8:
      sample = Sample::kInt32;
      break;
    case 16:
      sample = Sample::kFloat;
      break;
    case 64:
      sample = Sample::kDouble;
      break;
    case 256:
      sample = Sample::kInt8;
      break;
    case 512:
      sample = Sample::kUint16;
      break;
    case 768:
      sample = Sample::kUint32;
      break;
    default:
      throw ImportError("datatype", fmt::format("{} is not known", h.get<std::int16_t>(70)), "convert the image");
  }
  if (h.get<std::int16_t>(254) > 0) {  // sform: three rows of the matrix
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t k = 0; k < 3; ++k) image.step[k][row] = h.real(280 + 16 * row + 4 * k);
      image.origin[row] = h.real(280 + 16 * row + 12);
    }
  } else if (h.get<std::int16_t>(252) > 0) {
    placeByQuaternion(h, image);
  } else {
    for (std::size_t k = 0; k < 3; ++k) image.step[k][k] = h.real(80 + 4 * k);
  }
  // From right-anterior-superior to left-posterior-superior, and to millimetres.
  const int unit = h.get<std::uint8_t>(123) & 7;
  const double mm = unit == 1 ? 1000 : unit == 3 ? 0.001 : 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const double by = a < 2 ? -mm : mm;
    image.origin[a] *= by;
    for (Double3& s : image.step) s[a] *= by;
  }
  const double start = h.real(108), slope = h.real(112), offset = h.real(116);
  if (!(start >= 348 && start <= static_cast<double>(bytes.size())))
    throw ImportError("vox_offset", fmt::format("is {}", start), "is it whole?");
  const bool scaled = slope != 0 && std::isfinite(slope) && std::isfinite(offset);
  decode(bytes.substr(static_cast<std::size_t>(start)), sample, h.swapped(), scaled ? slope : 1, scaled ? offset : 0,
         image);
  checkPlace(image);
  return image;
}

}  // namespace hapticctl_import
