#include "tools/hapticctl-import/header/stream_length.h"

#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {
namespace {

constexpr std::size_t kBlock = 1 << 16;

class Unpacker {
 public:
  Unpacker() {
    if (inflateInit2(&stream_, 15 + 32) != Z_OK) throw std::bad_alloc();
  }
  Unpacker(const Unpacker&) = delete;
  Unpacker& operator=(const Unpacker&) = delete;
  ~Unpacker() { inflateEnd(&stream_); }

  /** False: the stream has ended, well or not. */
  bool take(char* bytes, std::size_t size) {
    stream_.next_in = reinterpret_cast<Bytef*>(bytes);
    stream_.avail_in = static_cast<uInt>(size);
    do {
      if (between_ && !begin()) return false;
      stream_.next_out = reinterpret_cast<Bytef*>(block_.data());
      stream_.avail_out = static_cast<uInt>(kBlock);
      const int code = inflate(&stream_, Z_NO_FLUSH);
      const std::size_t made = kBlock - stream_.avail_out;
      if (length_.head.size() < kBlock)
        length_.head.append(block_.data(), std::min(made, kBlock - length_.head.size()));
      length_.bytes += made;
      length_.end = code == Z_STREAM_END ? StreamEnd::kWhole : StreamEnd::kCut;
      between_ = code == Z_STREAM_END;
      if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR) {
        length_.end = StreamEnd::kDamaged;
        return false;
      }
    } while (stream_.avail_in > 0 || stream_.avail_out == 0);
    return true;
  }
  StreamLength length() { return std::move(length_); }

 private:
  /** Another member of a gzip file; anything else behind a stream is none of it. */
  bool begin() {
    if (stream_.avail_in == 0 || *stream_.next_in != 0x1f) return false;
    between_ = false;
    return inflateReset(&stream_) == Z_OK;
  }

  z_stream stream_{};
  std::vector<char> block_ = std::vector<char>(kBlock);
  bool between_ = false;
  StreamLength length_{0, StreamEnd::kCut, {}};
};

}  // namespace

StreamLength lengthOf(const std::string& path, std::uint64_t first, std::uint64_t most, bool packed) {
  std::ifstream file(path, std::ios::binary);
  std::error_code problem;
  const std::uint64_t size = std::filesystem::file_size(path, problem);
  if (!file || problem) throw ImportError(path, "cannot be read", "is the file of values there?");
  std::uint64_t left = size > first ? size - first : 0;
  if (most > 0) left = std::min(left, most);
  file.seekg(static_cast<std::streamoff>(first));
  std::vector<char> block(kBlock);
  if (!packed) {
    file.read(block.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(left, kBlock)));
    return {left, StreamEnd::kWhole, std::string(block.data(), static_cast<std::size_t>(file.gcount()))};
  }
  Unpacker unpacker;
  while (left > 0) {
    const std::size_t part = std::min<std::uint64_t>(left, kBlock);
    file.read(block.data(), static_cast<std::streamsize>(part));
    const auto got = static_cast<std::size_t>(file.gcount());
    if (got == 0 || !unpacker.take(block.data(), got)) break;
    left -= got;
  }
  return unpacker.length();
}

const char* inWords(StreamEnd end) {
  switch (end) {
    case StreamEnd::kCut:
      return ": the compressed data are cut short";
    case StreamEnd::kDamaged:
      return ": the compressed data are damaged";
    case StreamEnd::kWhole:
      break;
  }
  return "";
}

}  // namespace hapticctl_import
