/** @file
 * The image of a ball, as files of every format, written here byte by byte: no reader's own writer.
 */
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/process/temporary_directory.h"
#include "tests/support/random.h"
#include "tools/hapticctl-import/image.h"

namespace hapticctl_import::test {

inline constexpr std::array<std::uint32_t, 3> kSize{24, 20, 16};
inline constexpr std::array<Double3, 3> kPlain{{{1, 0, 0}, {0, 1.5, 0}, {0, 0, 2}}};

/** 1000 less 100 for each millimetre from the middle of the lattice. */
inline short valueAt(std::size_t x, std::size_t y, std::size_t z) {
  const double d[3] = {(static_cast<double>(x) - 11.5) * 1, (static_cast<double>(y) - 9.5) * 1.5,
                       (static_cast<double>(z) - 7.5) * 2};
  return static_cast<short>(std::lround(1000 - 100 * std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])));
}

/** All of them, x fastest. */
inline std::vector<float> ballValues() {
  std::vector<float> values;
  for (std::size_t z = 0; z < kSize[2]; ++z)
    for (std::size_t y = 0; y < kSize[1]; ++y)
      for (std::size_t x = 0; x < kSize[0]; ++x) values.push_back(valueAt(x, y, z));
  return values;
}

inline void append(std::string& bytes, short value, bool big_endian = false) {
  const auto v = static_cast<std::uint16_t>(value);
  const char low = static_cast<char>(v & 0xff), high = static_cast<char>(v >> 8);
  bytes += big_endian ? high : low;
  bytes += big_endian ? low : high;
}

inline std::string samples(bool big_endian = false) {
  std::string bytes;
  for (const float value : ballValues()) append(bytes, static_cast<short>(value), big_endian);
  return bytes;
}

/** By zlib, or as gzip (31 window bits). */
inline std::string compressed(const std::string& bytes, int window_bits = 15) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(deflateBound(&stream, bytes.size()) + 32, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

inline std::string metaImage(const std::string& more = {}) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 24 20 16\nElementSpacing = 1 1.5 2\nOffset = 10 20 30\n"
         "ElementType = MET_SHORT\n" +
         more + "ElementDataFile = LOCAL\n";
}

inline std::string nrrd(const std::string& more) {
  return "NRRD0004\n# made by a test\ntype: short\ndimension: 3\nsizes: 24 20 16\n" + more + "\n";
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

inline std::string nifti() {
  std::string h(352, '\0');
  put<std::int32_t>(h, 0, 348);
  const std::int16_t dim[] = {3, 24, 20, 16, 1, 1, 1, 1};
  std::memcpy(h.data() + 40, dim, sizeof dim);
  put<std::int16_t>(h, 70, 4);
  put<std::int16_t>(h, 72, 16);
  const float pixdim[] = {1, 1, 1.5f, 2};
  std::memcpy(h.data() + 76, pixdim, sizeof pixdim);
  put<float>(h, 108, 352);
  h[123] = 2;
  std::memcpy(h.data() + 344, "n+1\0", 4);
  return h;
}

inline void expectBall(const Image& image, const Double3& origin, const std::array<Double3, 3>& step) {
  EXPECT_EQ(image.size, kSize);
  EXPECT_EQ(image.values, ballValues());
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(image.origin[k], origin[k], 1e-5);
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(image.step[k][a], step[k][a], 1e-5) << k << a;
  }
}

/** A folder that goes with the test. */
class Folder : public hapticd::test::TemporaryDirectory {
 public:
  /** Writes a file and gives its path. */
  std::string put(const std::string& name, const std::string& bytes) const {
    std::string file = path() + "/" + name;
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
};

/** The ball as an image of plain steps, its corner at (10, 20, 30) mm. */
inline Image ballImage() {
  Image image;
  image.size = kSize;
  image.origin = {10, 20, 30};
  image.step = kPlain;
  image.values = ballValues();
  return image;
}

/** Turns one bit of a byte. */
inline void flip(std::string& bytes, std::size_t at, hapticd::Random& random) {
  bytes[at] = static_cast<char>(bytes[at] ^ (1u << random.below(8)));
}

/** Why something is refused, in words; "read" if it is not. */
template <class Work>
std::string refusal(Work&& work) {
  try {
    (void)work();
  } catch (const ImportError& error) {
    return error.where + ": " + error.what();
  }
  return "read";
}

}  // namespace hapticctl_import::test
