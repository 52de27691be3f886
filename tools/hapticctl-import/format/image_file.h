/** @file
 * Image files that no library reads: projects of InVesalius, and raw numbers.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

inline constexpr std::size_t kMostValues = std::size_t{1} << 31;  ///< Of an image.

enum class Sample : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

/** What a raw file cannot say itself. */
struct RawLayout {
  std::array<std::uint32_t, 3> size{};
  Double3 spacing{1, 1, 1};  ///< [mm]
  Sample sample = Sample::kInt16;
  bool big_endian = false;
};

/** Why a file could not be opened, by errno. */
[[nodiscard]] ImportError notRead(const std::string& path, int code);
/**
 * The whole file; gzip is unpacked, unless the file has just `plain` bytes: then these are what is looked for, however
 * they begin. Throws ImportError.
 */
[[nodiscard]] std::string readFile(const std::string& path, std::optional<std::size_t> plain = {});

/** Whether that is an archive as InVesalius packs its projects. */
[[nodiscard]] bool isInvesalius(std::string_view bytes);
/** Throws ImportError that says what is wrong and where. */
[[nodiscard]] Image parseInvesalius(std::string_view tar);
[[nodiscard]] Image parseRaw(std::string_view bytes, const RawLayout& layout);
/** "int16", "short", "float", ... */
[[nodiscard]] std::optional<Sample> sampleOf(std::string_view word);

// What they share.
/** Unpacks zlib or gzip, the latter of any number of members, to at most `most` bytes. Throws ImportError. */
[[nodiscard]] std::string inflated(std::string_view packed, std::size_t most);
/** Bytes of so many values of that kind; throws ImportError if a size is below 2 or all are too many. */
[[nodiscard]] std::size_t bytesOf(const std::array<std::uint32_t, 3>& size, Sample sample);
/**
 * Fills image.values, whose size stands, with valueAt(0), valueAt(1), ... What is no finite number is nothing solid: it
 * becomes the lowest value, infinity the highest, and image.no_numbers counts them. Whole numbers that floats round, as
 * an atlas may have for labels, are kept in image.exact, too. Throws ImportError if there is no finite number.
 */
template <class ValueAt>
void takeValues(Image& image, const ValueAt& valueAt) {
  bool rounded = false;
  float lowest = INFINITY, highest = -INFINITY;
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    const auto value = static_cast<double>(valueAt(i));
    const auto v = static_cast<float>(valueAt(i));
    image.values[i] = v;
    if (!std::isfinite(v)) {
      ++image.no_numbers;
      continue;
    }
    lowest = std::min(lowest, v);
    highest = std::max(highest, v);
    rounded = rounded || (static_cast<double>(v) != value && std::floor(value) == value);
  }
  if (image.no_numbers > 0) {
    if (lowest > highest) throw ImportError("values", "none of them is a finite number", "is the file whole?");
    for (float& v : image.values)
      if (!std::isfinite(v)) v = v > 0 ? highest : lowest;
  }
  if (!rounded) return;
  image.exact.resize(image.values.size());
  for (std::size_t i = 0; i < image.exact.size(); ++i) image.exact[i] = static_cast<double>(valueAt(i));
}
/** Fills image.values from the bytes; throws ImportError if bytes are missing. */
void decode(std::string_view bytes, Sample sample, bool big_endian, Image& image);
/**
 * Numbers between blanks, commas, brackets; throws ImportError unless `count` finite ones stand there. `remedy` is for
 * those of the command line; null: they are from a header.
 */
[[nodiscard]] std::vector<double> numbersIn(std::string_view text, const std::string& where, std::size_t count,
                                            const char* remedy = nullptr);
[[nodiscard]] std::array<std::uint32_t, 3> sizesIn(std::string_view text, const std::string& where,
                                                   const char* remedy = nullptr);

}  // namespace hapticctl_import
