/** @file
 * How much of a stream of bytes is there: counted by unpacking it, kept nowhere.
 */
#pragma once

#include <cstdint>
#include <string>

namespace hapticctl_import {

/** How compressed data end. */
enum class StreamEnd {
  kWhole,    ///< It ends as it should, checksum included; what is not packed always does.
  kCut,      ///< It ends in its middle.
  kDamaged,  ///< It cannot be unpacked beyond `bytes`, or is not what it was.
};

struct StreamLength {
  std::uint64_t bytes = 0;  ///< Unpacked.
  StreamEnd end = StreamEnd::kWhole;
  std::string head;  ///< The first bytes, at most 64 kB.
};

/**
 * The part of a file from `first` on, of at most `most` bytes (0: to the end). `packed`: zlib or gzip, the latter of
 * any number of members. Throws ImportError if the file cannot be read.
 */
[[nodiscard]] StreamLength lengthOf(const std::string& path, std::uint64_t first, std::uint64_t most, bool packed);

/** "", or what is wrong, to be put behind a message. */
[[nodiscard]] const char* inWords(StreamEnd end);

}  // namespace hapticctl_import
