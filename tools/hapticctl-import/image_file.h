/** @file
 * Image files that no library reads: projects of InVesalius, and raw numbers.
 */
#pragma once

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

/** The whole file; gzip is unpacked. Throws ImportError. */
[[nodiscard]] std::string readFile(const std::string& path);

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
