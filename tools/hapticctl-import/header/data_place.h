/** @file
 * Where the values of a MetaImage or NRRD file lie, as its header says.
 *
 * Only what counting them needs; whether a header is right is for ITK to say.
 */
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hapticctl_import {

struct DataPlace {
  std::string file;                 ///< Beside the header; empty: behind the header, in the same file.
  std::uint64_t skip = 0;           ///< Bytes of that file before them.
  std::uint64_t bytes = 0;          ///< At most so many of that file's; 0: to its end.
  std::uint64_t unpacked_skip = 0;  ///< Bytes before them, once unpacked.
  bool packed = false;              ///< zlib or gzip.
  bool countable = false;           ///< In one file, as binary numbers.
  bool in_several = false;          ///< Files: metaImageFiles() or nrrdFiles() names them.
  std::string several;              ///< Of a NRRD: what stands behind "data file:" then.
  std::uint64_t list = 0;           ///< Where the lines below that begin.
  bool binary = false;              ///< Not numbers in words, and no lines to be skipped.
};

/** `head` may be cut behind the header. Any bytes can be given. */
[[nodiscard]] DataPlace metaImagePlace(std::string_view head);
[[nodiscard]] DataPlace nrrdPlace(std::string_view head);

/**
 * Throws ImportError, with the file and the bytes found and needed, if the values of an image are not all there, or are
 * packed in a way that ITK reads wrong. `format` as readScan() tells it.
 */
void requireWhole(const std::string& path, const std::string& format, std::uint64_t needed);

}  // namespace hapticctl_import
