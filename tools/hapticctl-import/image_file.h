/** @file
 * Image files: MetaImage, NRRD, NIfTI-1, projects of InVesalius, and raw numbers.
 */
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

enum class Sample : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

/** What a raw file cannot say itself. */
struct RawLayout {
  std::array<std::uint32_t, 3> size{};
  Double3 spacing{1, 1, 1};  ///< [mm]
  Sample sample = Sample::kInt16;
  bool big_endian = false;
};

/** Gives the bytes of a file that another names (a header its data), unpacked; throws ImportError. */
using OpenFile = std::function<std::string(const std::string& name)>;

/** The whole file; gzip is unpacked. Throws ImportError. */
[[nodiscard]] std::string readFile(const std::string& path);

/**
 * Recognises the format by the content, not by the name. Orientation and spacing are honoured; of several components or
 * times only one is allowed. Throws ImportError that says what is wrong and where.
 */
[[nodiscard]] Image parseImage(std::string_view bytes, const OpenFile& open);
[[nodiscard]] Image parseRaw(std::string_view bytes, const RawLayout& layout);
/** "int16", "short", "MET_SHORT", ... as the formats spell them. */
[[nodiscard]] std::optional<Sample> sampleOf(std::string_view word);

// The formats one by one.
[[nodiscard]] Image parseMetaImage(std::string_view bytes, const OpenFile& open);
[[nodiscard]] Image parseNrrd(std::string_view bytes, const OpenFile& open);
[[nodiscard]] Image parseNifti(std::string_view bytes);
[[nodiscard]] Image parseInvesalius(std::string_view tar);

// What they share.
/** Unpacks zlib or gzip, to at most `most` bytes. Throws ImportError. */
[[nodiscard]] std::string inflated(std::string_view packed, std::size_t most);
/** Bytes of so many values of that kind; throws ImportError if a size is below 2 or all are too many. */
[[nodiscard]] std::size_t bytesOf(const std::array<std::uint32_t, 3>& size, Sample sample);
/** Fills image.values from the bytes, times `slope` plus `offset`; throws ImportError if bytes are missing. */
void decode(std::string_view bytes, Sample sample, bool big_endian, double slope, double offset, Image& image);
/** Throws ImportError unless every number is finite and the steps span a space. */
void checkPlace(const Image& image);
/** Numbers between blanks, commas, brackets; throws ImportError unless `count` finite ones stand there. */
[[nodiscard]] std::vector<double> numbersIn(std::string_view text, const std::string& where, std::size_t count);
[[nodiscard]] std::array<std::uint32_t, 3> sizesIn(std::string_view text, const std::string& where);

}  // namespace hapticctl_import
