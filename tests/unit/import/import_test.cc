// Images of a ball in every format, and the surface about it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <map>
#include <numbers>

#include "tools/hapticctl-import/image_file.h"
#include "tools/hapticctl-import/isosurface.h"

namespace hapticctl_import {
namespace {

constexpr std::array<std::uint32_t, 3> kSize{24, 20, 16};
constexpr Double3 kSpacing{1, 1.5, 2};

/** 1000 less 100 for each millimetre from the middle of the lattice. */
short valueAt(std::size_t x, std::size_t y, std::size_t z) {
  const double d[3] = {(static_cast<double>(x) - 11.5) * 1, (static_cast<double>(y) - 9.5) * 1.5,
                       (static_cast<double>(z) - 7.5) * 2};
  return static_cast<short>(std::lround(1000 - 100 * std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])));
}

std::string samples(bool big_endian = false) {
  std::string bytes;
  for (std::size_t z = 0; z < kSize[2]; ++z)
    for (std::size_t y = 0; y < kSize[1]; ++y)
      for (std::size_t x = 0; x < kSize[0]; ++x) {
        const auto v = static_cast<std::uint16_t>(valueAt(x, y, z));
        const char low = static_cast<char>(v & 0xff), high = static_cast<char>(v >> 8);
        bytes += big_endian ? high : low;
        bytes += big_endian ? low : high;
      }
  return bytes;
}

std::string compressed(const std::string& bytes) {
  std::string out(compressBound(bytes.size()), '\0');
  uLongf size = out.size();
  EXPECT_EQ(
      compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()),
      Z_OK);
  out.resize(size);
  return out;
}

std::string metaImage(const std::string& more = {}) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 24 20 16\nElementSpacing = 1 1.5 2\nOffset = 10 20 30\n"
         "ElementType = MET_SHORT\n" +
         more + "ElementDataFile = LOCAL\n";
}

std::string nrrd(const std::string& more) {
  return "NRRD0004\n# made by a test\ntype: short\ndimension: 3\nsizes: 24 20 16\n" + more + "\n";
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

std::string nifti() {
  std::string h(352, '\0');
  put<std::int32_t>(h, 0, 348);
  const std::int16_t dim[] = {3, 24, 20, 16, 1};
  std::memcpy(h.data() + 40, dim, sizeof dim);
  put<std::int16_t>(h, 70, 4);
  const float pixdim[] = {1, 1, 1.5f, 2};
  std::memcpy(h.data() + 76, pixdim, sizeof pixdim);
  put<float>(h, 108, 352);
  h[123] = 2;
  std::memcpy(h.data() + 344, "n+1\0", 4);
  return h;
}

std::string noFile(const std::string& name) { throw ImportError(name, "is not there"); }

void expectBall(const Image& image, const Double3& origin, const std::array<Double3, 3>& step) {
  EXPECT_EQ(image.size, kSize);
  ASSERT_EQ(image.values.size(), 24u * 20 * 16);
  for (std::size_t z = 0; z < 16; ++z)
    for (std::size_t y = 0; y < 20; ++y)
      for (std::size_t x = 0; x < 24; ++x) ASSERT_EQ(image.values[x + 24 * (y + 20 * z)], valueAt(x, y, z));
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(image.origin[k], origin[k], 1e-5);
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(image.step[k][a], step[k][a], 1e-5) << k << a;
  }
}

constexpr std::array<Double3, 3> kPlain{{{1, 0, 0}, {0, 1.5, 0}, {0, 0, 2}}};

TEST(Import, readsMetaImages) {
  expectBall(parseImage(metaImage() + samples(), noFile), {10, 20, 30}, kPlain);
  expectBall(parseImage(metaImage("BinaryDataByteOrderMSB = True\n") + samples(true), noFile), {10, 20, 30}, kPlain);
  expectBall(parseImage(metaImage("CompressedData = True\n") + compressed(samples()), noFile), {10, 20, 30}, kPlain);
  std::string header = metaImage("TransformMatrix = 0 1 0 -1 0 0 0 0 1\n");
  header.replace(header.find("LOCAL"), 5, "ball.raw");
  const Image turned = parseImage(header, [](const std::string& name) {
    EXPECT_EQ(name, "ball.raw");
    return samples();
  });
  expectBall(turned, {10, 20, 30}, {{{0, 1, 0}, {-1.5, 0, 0}, {0, 0, 2}}});
}

TEST(Import, readsNrrd) {
  expectBall(parseImage(nrrd("encoding: raw\nendian: little\nspacings: 1 1.5 2\n") + samples(), noFile), {0, 0, 0},
             kPlain);
  expectBall(parseImage(nrrd("encoding: raw\nendian: big\nspace: right-anterior-superior\n"
                             "space directions: (1,0,0) (0,1.5,0) (0,0,2)\nspace origin: (1,2,3)\n") +
                            samples(true),
                        noFile),
             {-1, -2, 3}, {{{-1, 0, 0}, {0, -1.5, 0}, {0, 0, 2}}});
}

TEST(Import, readsNifti) {
  // Without an orientation the axes are right, anterior, superior.
  expectBall(parseImage(nifti() + samples(), noFile), {0, 0, 0}, {{{-1, 0, 0}, {0, -1.5, 0}, {0, 0, 2}}});
  std::string turned = nifti();
  put<std::int16_t>(turned, 252, 1);  // A quarter turn about z: x to y, y to -x.
  put<float>(turned, 264, static_cast<float>(std::sqrt(0.5)));
  put<float>(turned, 268, 7);
  expectBall(parseImage(turned + samples(), noFile), {-7, 0, 0}, {{{0, -1, 0}, {1.5, 0, 0}, {0, 0, 2}}});
  put<std::int16_t>(turned, 254, 1);
  const float rows[12] = {1, 0, 0, 5, 0, 1.5f, 0, 6, 0, 0, 2, 7};
  std::memcpy(turned.data() + 280, rows, sizeof rows);
  expectBall(parseImage(turned + samples(), noFile), {-5, -6, 7}, {{{-1, 0, 0}, {0, -1.5, 0}, {0, 0, 2}}});
  std::string scaled = nifti();
  put<float>(scaled, 112, 2);
  put<float>(scaled, 116, -5);
  EXPECT_EQ(parseImage(scaled + samples(), noFile).values[0], 2.0f * valueAt(0, 0, 0) - 5);
}

std::string tarFile(const std::string& name, const std::string& bytes) {
  std::string head(512, '\0');
  std::memcpy(head.data(), name.data(), name.size());
  std::snprintf(head.data() + 124, 12, "%011zo", bytes.size());
  std::memcpy(head.data() + 257, "ustar", 5);
  return head + bytes + std::string((512 - bytes.size() % 512) % 512, '\0');
}

std::string invesalius() {
  return tarFile("tmp/main.plist",
                 "<?xml version=\"1.0\"?><plist><dict><key>matrix</key><dict><key>dtype</key><string>int16</string>"
                 "<key>filename</key><string>matrix.dat</string><key>shape</key><array><integer>16</integer>"
                 "<integer>20</integer><integer>24</integer></array></dict><key>spacing</key><array><real>1</real>"
                 "<real>1.5</real><real>2</real></array></dict></plist>") +
         tarFile("tmp/matrix.dat", samples()) + std::string(1024, '\0');
}

TEST(Import, readsInvesaliusProjects) { expectBall(parseImage(invesalius(), noFile), {0, 0, 0}, kPlain); }

TEST(Import, shorterFilesAreRefusedNotRead) {
  for (const std::string& whole : {metaImage() + samples(), nrrd("encoding: raw\nspacings: 1 1 1\n") + samples(),
                                   nifti() + samples(), metaImage("CompressedData = True\n") + compressed(samples())}) {
    for (std::size_t n = 0; n < whole.size(); n += 1 + whole.size() / 97)
      EXPECT_THROW((void)parseImage(std::string_view(whole).substr(0, n), noFile), ImportError) << n;
  }
  const std::string project = invesalius();
  for (std::size_t n = 0; n + 1536 < project.size(); n += 311)
    EXPECT_THROW((void)parseImage(std::string_view(project).substr(0, n), noFile), ImportError) << n;
}

TEST(Import, liesInHeadersAreRefusedInWords) {
  const auto refusal = [](std::string header, const std::string& what, const std::string& lie) {
    header.replace(header.find(what), what.size(), lie);
    try {
      (void)parseImage(header + samples(), noFile);
    } catch (const ImportError& error) {
      return error.where + ": " + error.what();
    }
    return std::string("not refused");
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal(metaImage(), "24 20 16", "24 20"), HasSubstr("2 numbers stand there"));
  EXPECT_THAT(refusal(metaImage(), "24 20 16", "24 20 1"), HasSubstr("along an axis"));
  EXPECT_THAT(refusal(metaImage(), "24 20 16", "60000 60000 60000"), HasSubstr("2^31"));
  EXPECT_THAT(refusal(metaImage(), "1 1.5 2", "1 0 2"), HasSubstr("spacing"));
  EXPECT_THAT(refusal(metaImage(), "1 1.5 2", "1 nan 2"), HasSubstr("is not a number"));
  EXPECT_THAT(refusal(metaImage(), "MET_SHORT", "MET_COMPLEX"), HasSubstr("ElementType"));
  EXPECT_THAT(refusal(metaImage(), "LOCAL", "away.raw"), HasSubstr("away.raw"));
  EXPECT_THAT(refusal(metaImage("TransformMatrix = 1 0 0 1 0 0 0 0 1\n"), "NDims", "NDims"), HasSubstr("one plane"));
  EXPECT_THAT(refusal(nrrd("encoding: bzip2\n"), "short", "short"), HasSubstr("bzip2"));
}

TEST(Surface, isClosedManifoldAndOfTheBallsVolume) {
  for (const bool mirrored : {false, true}) {
    Image image = parseImage(metaImage() + samples(), noFile);
    if (mirrored) image.step[1] = {0, -1.5, 0};
    const Surface surface = isosurface(image, 200);  // 8 mm
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : surface.triangles)
      for (std::size_t e = 0; e < 3; ++e) ++edges[{t[e], t[(e + 1) % 3]}];
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
    const double ball = 4.0 / 3 * std::numbers::pi * 512;
    EXPECT_NEAR(volumeOf(surface), ball, 0.02 * ball);
    const double y = mirrored ? 20 - 9.5 * 1.5 : 20 + 9.5 * 1.5;
    for (const auto& v : surface.vertices) EXPECT_NEAR(std::hypot(v[0] - 21.5, v[1] - y, v[2] - 45), 8, 0.25);
  }
}

TEST(Surface, whatTheImageCutsOffIsClosed) {
  const Surface surface = isosurface(parseImage(metaImage() + samples(), noFile), -1e6f);  // All of it.
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : surface.triangles)
    for (std::size_t e = 0; e < 3; ++e) ++edges[{t[e], t[(e + 1) % 3]}];
  for (const auto& [edge, count] : edges) EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
  const double box = 23 * 1 * 19 * 1.5 * 15 * 2;
  EXPECT_NEAR(volumeOf(surface), box, 0.01 * box);
}

TEST(Surface, noisyValuesStayManifold) {
  Image image = parseImage(metaImage() + samples(), noFile);
  std::uint32_t state = 1;
  for (float& v : image.values) v = static_cast<float>((state = state * 1664525u + 1013904223u) >> 24 & 3);
  Surface surface = isosurface(image, 2);  // Values equal to iso abound.
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : surface.triangles)
    for (std::size_t e = 0; e < 3; ++e) ++edges[{t[e], t[(e + 1) % 3]}];
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
  }
  EXPECT_GT(keepLargest(surface), 1u);
  EXPECT_GT(surface.triangles.size(), 100u);
}

TEST(Image, cropsShrinksAndSmoothsInPlace) {
  const Image image = parseImage(metaImage() + samples(), noFile);
  const Image part = crop(image, {4, 2, 3}, {20, 18, 99});
  EXPECT_EQ(part.size, (std::array<std::uint32_t, 3>{16, 16, 13}));
  EXPECT_EQ(part.origin, (Double3{14, 23, 36}));
  EXPECT_EQ(part.values[0], valueAt(4, 2, 3));
  const Image half = shrink(image, 2);
  EXPECT_EQ(half.origin, (Double3{10.5, 20.75, 31}));
  EXPECT_EQ(half.step[2], (Double3{0, 0, 4}));
  const double ball = 4.0 / 3 * std::numbers::pi * 512;
  EXPECT_NEAR(volumeOf(isosurface(half, 200)), ball, 0.15 * ball);
  Image smoothed = image;
  for (float& v : smoothed.values) v = 3;
  smooth(smoothed, 2);
  for (const float v : smoothed.values) ASSERT_NEAR(v, 3, 1e-5);
  EXPECT_THROW((void)crop(image, {0, 0, 0}, {1, 9, 9}), ImportError);
  EXPECT_THROW((void)shrink(image, 9), ImportError);
}

}  // namespace
}  // namespace hapticctl_import
