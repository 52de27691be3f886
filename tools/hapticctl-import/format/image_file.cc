#include "tools/hapticctl-import/format/image_file.h"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

namespace hapticctl_import {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 34;

constexpr std::size_t kSampleBytes[] = {1, 1, 2, 2, 4, 4, 4, 8};

template <class T>
void decodeAs(std::string_view bytes, bool swap, Image& image) {
  takeValues(image, [&](std::size_t i) {
    char raw[sizeof(T)];
    std::memcpy(raw, bytes.data() + i * sizeof(T), sizeof(T));
    if (swap) std::reverse(raw, raw + sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof value);
    return value;
  });
}

}  // namespace

std::string inflated(std::string_view packed, std::size_t most) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) throw ImportError("compressed data", "cannot be unpacked");
  std::string out;
  char block[1 << 16];
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  std::size_t left = packed.size();
  int code = Z_OK;
  while ((code == Z_OK || code == Z_STREAM_END) && out.size() < most) {
    if (stream.avail_in == 0) {
      const std::size_t part = std::min<std::size_t>(left, 1u << 30);
      stream.avail_in = static_cast<uInt>(part);
      left -= part;
    }
    if (code == Z_STREAM_END &&  // Another member of a gzip file may follow; anything else is none of it.
        (stream.avail_in == 0 || *stream.next_in != 0x1f || inflateReset(&stream) != Z_OK))
      break;
    stream.next_out = reinterpret_cast<Bytef*>(block);
    stream.avail_out = sizeof block;
    code = inflate(&stream, Z_NO_FLUSH);
    out.append(block, sizeof block - stream.avail_out);
  }
  inflateEnd(&stream);
  if (code != Z_STREAM_END && out.size() < most)
    throw ImportError("compressed data", "is damaged or cut short", "fetch the file again");
  return out;
}

ImportError notRead(const std::string& path, int code) {
  return {path, std::string("cannot be read: ") + std::strerror(code), "name a file that you may read"};
}

std::string readFile(const std::string& path, std::optional<std::size_t> plain) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw notRead(path, errno);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.size() != plain && bytes.size() > 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b')
    return inflated(bytes, kMostBytes);
  return bytes;
}

std::optional<Sample> sampleOf(std::string_view word) {
  struct Spelling {
    Sample sample;
    std::string_view words;
  };
  static constexpr Spelling kSpellings[] = {{Sample::kInt8, " int8 int8_t signed_char "},
                                            {Sample::kUint8, " uint8 uint8_t uchar unsigned_char "},
                                            {Sample::kInt16, " int16 int16_t short met_short signed_short "},
                                            {Sample::kUint16, " uint16 uint16_t ushort unsigned_short "},
                                            {Sample::kInt32, " int32 int32_t int met_int signed_int "},
                                            {Sample::kUint32, " uint32 uint32_t uint unsigned_int "},
                                            {Sample::kFloat, " float float32 "},
                                            {Sample::kDouble, " double float64 "}};
  std::string key = " ";
  for (const char c : word) key += c == ' ' ? '_' : static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  key += ' ';
  for (const auto& [sample, words] : kSpellings)
    if (words.find(key) != std::string_view::npos) return sample;
  return {};
}

std::size_t bytesOf(const std::array<std::uint32_t, 3>& size, Sample sample) {
  std::size_t count = 1;
  for (const std::uint32_t n : size) {
    if (n < 2 || n > 65536) throw ImportError("size", fmt::format("{} values along an axis", n), "2 to 65536 can be");
    count *= n;
    if (count > kMostValues) throw ImportError("size", "more than 2^31 values", "shrink the image elsewhere first");
  }
  return count * kSampleBytes[static_cast<std::size_t>(sample)];
}

void decode(std::string_view bytes, Sample sample, bool big_endian, Image& image) {
  const std::size_t needed = bytesOf(image.size, sample);
  if (bytes.size() < needed)
    throw ImportError("data", fmt::format("{} bytes are there, {} are needed", bytes.size(), needed), "is it whole?");
  image.values.resize(std::size_t{image.size[0]} * image.size[1] * image.size[2]);
  const bool swap = big_endian != (std::endian::native == std::endian::big);
  switch (sample) {
    case Sample::kInt8:
      return decodeAs<std::int8_t>(bytes, swap, image);
    case Sample::kUint8:
      return decodeAs<std::uint8_t>(bytes, swap, image);
    case Sample::kInt16:
      return decodeAs<std::int16_t>(bytes, swap, image);
    case Sample::kUint16:
      return decodeAs<std::uint16_t>(bytes, swap, image);
    case Sample::kInt32:
      return decodeAs<std::int32_t>(bytes, swap, image);
    case Sample::kUint32:
      return decodeAs<std::uint32_t>(bytes, swap, image);
    case Sample::kFloat:
      return decodeAs<float>(bytes, swap, image);
    case Sample::kDouble:
      return decodeAs<double>(bytes, swap, image);
  }
}

std::vector<double> numbersIn(std::string_view text, const std::string& where, std::size_t count, const char* remedy) {
  std::vector<double> numbers;
  std::size_t at = 0;
  while (at < text.size()) {
    if (std::string_view(" \t\r\n,()[]").find(text[at]) != std::string_view::npos) {
      ++at;
      continue;
    }
    double value = 0;
    // DICOM may write a sign that from_chars does not know.
    if (text[at] == '+' && at + 1 < text.size() && text[at + 1] != '-') ++at;
    const auto [end, problem] = std::from_chars(text.data() + at, text.data() + text.size(), value);
    if (problem != std::errc() || !std::isfinite(value)) {
      throw ImportError(where, fmt::format("'{}' is not a number", text.substr(at, 20)),
                        remedy != nullptr ? remedy : "correct the header");
    }
    at = static_cast<std::size_t>(end - text.data());
    numbers.push_back(value);
  }
  if (numbers.size() != count) {
    throw ImportError(where, fmt::format("{} numbers stand there, {} must", numbers.size(), count),
                      remedy != nullptr ? remedy : "only images of three axes and one component can be used");
  }
  return numbers;
}

std::array<std::uint32_t, 3> sizesIn(std::string_view text, const std::string& where, const char* remedy) {
  const std::vector<double> numbers = numbersIn(text, where, 3, remedy);
  std::array<std::uint32_t, 3> size{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(numbers[k] >= 2 && numbers[k] <= 65536 && numbers[k] == std::floor(numbers[k])))
      throw ImportError(where, fmt::format("{} values along an axis", numbers[k]), "2 to 65536 can be");
    size[k] = static_cast<std::uint32_t>(numbers[k]);
  }
  return size;
}

Image parseRaw(std::string_view bytes, const RawLayout& layout) {
  Image image;
  image.format = "raw numbers";
  image.size = layout.size;
  if (const std::size_t needed = bytesOf(image.size, layout.sample); bytes.size() > needed)
    throw ImportError("data", fmt::format("{} bytes are there, {} are needed", bytes.size(), needed), "no header");
  for (std::size_t k = 0; k < 3; ++k) image.step[k][k] = layout.spacing[k];
  decode(bytes, layout.sample, layout.big_endian, image);
  checkPlace(image);
  return image;
}

}  // namespace hapticctl_import
