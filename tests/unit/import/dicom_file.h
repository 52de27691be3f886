/** @file
 * One CT slice as a DICOM file, explicit VR little endian (PS3.5 section 7, PS3.10 section 7), written byte by byte.
 */
#pragma once

#include <fmt/core.h>

#include <optional>

#include "tests/unit/import/ball.h"

namespace hapticctl_import::test {

struct CtSlice {
  std::string series = "1.2.3.4", description = "Ball";
  std::string kind = "1.2.840.10008.5.1.4.1.1.2";  ///< SOP class: CT.
  int frames = 0;                                  ///< Of an image of several; 0: the file does not say.
  int number = 1;                                  ///< Instance number; says nothing of the place.
  std::uint16_t columns = 24, rows = 20;
  Double3 position{}, row{1, 0, 0}, column{0, 1, 0};
  double column_spacing = 1, row_spacing = 1.5, slope = 1, intercept = 0;
  std::string values;  ///< 16 bits each ...
  int bits_stored = 16, high_bit = 15;
  std::string photometric = "MONOCHROME2";
  double between = 0;  ///< Spacing between frames; 0: the file does not say.
  std::optional<int> padding;
  std::string groups;  ///< Functional groups of an enhanced image, see enhanced().
};

/** An element of a data set. Values are padded to an even length by blanks, identifiers by zeros. */
inline std::string element(std::uint16_t group, std::uint16_t number, const char* vr, std::string value) {
  std::string out;
  if (value.size() % 2 != 0) value += std::string(vr) == "UI" || std::string(vr) == "OB" ? '\0' : ' ';
  append(out, static_cast<short>(group));
  append(out, static_cast<short>(number));
  out += vr;
  const auto size = static_cast<std::uint32_t>(value.size());
  const bool large = std::string(vr) == "OB" || std::string(vr) == "OW" || std::string(vr) == "SQ";
  if (large) append(out, 0);
  append(out, static_cast<short>(size));
  if (large) append(out, static_cast<short>(size >> 16));
  return out + value;
}

inline std::string number16(int value) {
  std::string out;
  append(out, static_cast<short>(value));
  return out;
}

inline std::string dicomFile(const CtSlice& s) {
  const std::string &ct = s.kind, instance = fmt::format("{}.{}", s.series, s.number);
  const std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", ct) +
                           element(2, 3, "UI", instance) + element(2, 0x10, "UI", "1.2.840.10008.1.2.1") +
                           element(2, 0x12, "UI", "1.2.3");
  std::string size;
  append(size, static_cast<short>(meta.size()));
  append(size, 0);
  const auto& [r, c, p] = std::tie(s.row, s.column, s.position);
  std::string file(132, '\0');
  file.replace(128, 4, "DICM");
  return file + element(2, 0, "UL", size) + meta + element(8, 0x16, "UI", ct) + element(8, 0x18, "UI", instance) +
         element(8, 0x60, "CS", "CT") + element(8, 0x103e, "LO", s.description) +
         (s.between > 0 ? element(0x18, 0x88, "DS", fmt::format("{:.8g}", s.between)) : "") +
         element(0x20, 0xd, "UI", "1.2.3") + element(0x20, 0xe, "UI", s.series) + element(0x20, 0x11, "IS", "1") +
         element(0x20, 0x13, "IS", fmt::format("{}", s.number)) +
         element(0x20, 0x32, "DS", fmt::format("{:.8g}\\{:.8g}\\{:.8g}", p[0], p[1], p[2])) +
         element(0x20, 0x37, "DS",
                 fmt::format("{:.8g}\\{:.8g}\\{:.8g}\\{:.8g}\\{:.8g}\\{:.8g}", r[0], r[1], r[2], c[0], c[1], c[2])) +
         element(0x20, 0x52, "UI", "1.2.3.9") + element(0x28, 2, "US", number16(1)) +
         element(0x28, 4, "CS", s.photometric) +
         (s.frames > 0 ? element(0x28, 8, "IS", fmt::format("{}", s.frames)) : "") +
         element(0x28, 0x10, "US", number16(s.rows)) + element(0x28, 0x11, "US", number16(s.columns)) +
         (s.row_spacing > 0 ? element(0x28, 0x30, "DS", fmt::format("{:.8g}\\{:.8g}", s.row_spacing, s.column_spacing))
                            : "") +
         element(0x28, 0x100, "US", number16(16)) + element(0x28, 0x101, "US", number16(s.bits_stored)) +
         element(0x28, 0x102, "US", number16(s.high_bit)) + element(0x28, 0x103, "US", number16(1)) +
         (s.padding ? element(0x28, 0x120, "SS", number16(*s.padding)) : "") +
         element(0x28, 0x1052, "DS", fmt::format("{:.8g}", s.intercept)) +
         element(0x28, 0x1053, "DS", fmt::format("{:.8g}", s.slope)) + s.groups + element(0x7fe0, 0x10, "OW", s.values);
}

/** Slice z of the ball. */
inline CtSlice ballSlice(std::size_t z) {
  CtSlice s;
  for (std::size_t y = 0; y < kSize[1]; ++y)
    for (std::size_t x = 0; x < kSize[0]; ++x) append(s.values, valueAt(x, y, z));
  s.number = static_cast<int>(z) + 1;
  s.position = {10, 20, 30 + 2.0 * static_cast<double>(z)};
  return s;
}

/** A sequence of items. */
inline std::string sequence(std::uint16_t group, std::uint16_t number, const std::vector<std::string>& items) {
  std::string all;
  for (const std::string& item : items) {
    append(all, static_cast<short>(0xfffe));
    append(all, static_cast<short>(0xe000));
    append(all, static_cast<short>(item.size()));
    append(all, static_cast<short>(item.size() >> 16));
    all += item;
  }
  return element(group, number, "SQ", all);
}

/** The ball in one file: frame i is slice order[i], with a slope of its own if asked for. */
inline CtSlice enhanced(const std::vector<std::size_t>& order, bool sloping = false) {
  CtSlice all;
  all.kind = "1.2.840.10008.5.1.4.1.1.2.1";
  all.frames = static_cast<int>(order.size());
  std::vector<std::string> each;
  for (const std::size_t z : order) {
    const int slope = sloping ? 2 : 1, intercept = sloping && z % 2 != 0 ? -7 : 0;
    for (std::size_t y = 0; y < kSize[1]; ++y)
      for (std::size_t x = 0; x < kSize[0]; ++x) append(all.values, valueAt(x, y, z));
    each.push_back(sequence(0x20, 0x9113, {element(0x20, 0x32, "DS", fmt::format("10\\20\\{}", 30 + 2 * z))}) +
                   sequence(0x28, 0x9145,
                            {element(0x28, 0x1052, "DS", fmt::format("{}", intercept)) +
                             element(0x28, 0x1053, "DS", fmt::format("{}", slope * (sloping && z % 2 != 0 ? 2 : 1)))}));
  }
  all.groups = sequence(0x5200, 0x9229,
                        {sequence(0x20, 0x9116, {element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")}) +
                         sequence(0x28, 0x9110, {element(0x28, 0x30, "DS", "1.5\\1")})}) +
               sequence(0x5200, 0x9230, each);
  return all;
}

}  // namespace hapticctl_import::test
