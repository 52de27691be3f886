// What is done to an image before its surface is drawn, and the surface.
#include <map>
#include <numbers>

#include "tests/support/seeds.h"
#include "tests/unit/import/ball.h"
#include "tools/hapticctl-import/isosurface.h"

namespace hapticctl_import::test {
namespace {

/** Each edge has one triangle on either side; `once`: and no other edge lies on it. */
void expectClosed(const Surface& surface, bool once) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : surface.triangles)
    for (std::size_t e = 0; e < 3; ++e) ++edges[{t[e], t[(e + 1) % 3]}];
  for (const auto& [edge, count] : edges) {
    if (once) {
      EXPECT_EQ(count, 1);
    }
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
  }
}

TEST(Surface, isClosedManifoldAndOfTheBallsVolume) {
  for (const bool mirrored : {false, true}) {
    Image image = ballImage();
    if (mirrored) image.step[1] = {0, -1.5, 0};
    const Surface surface = isosurface(image, 200);  // 8 mm
    expectClosed(surface, true);
    const double ball = 4.0 / 3 * std::numbers::pi * 512;
    EXPECT_NEAR(volumeOf(surface), ball, 0.02 * ball);
    const double y = mirrored ? 20 - 9.5 * 1.5 : 20 + 9.5 * 1.5;
    for (const auto& v : surface.vertices) EXPECT_NEAR(std::hypot(v[0] - 21.5, v[1] - y, v[2] - 45), 8, 0.25);
  }
}

TEST(Surface, whatTheImageCutsOffIsClosed) {
  const Surface surface = isosurface(ballImage(), -1e6f);  // All of it.
  expectClosed(surface, false);
  const double box = 23 * 1 * 19 * 1.5 * 15 * 2;
  EXPECT_NEAR(volumeOf(surface), box, 0.01 * box);
}

TEST(Surface, noisyValuesStayManifold) {
  Image image = ballImage();
  hapticd::Random random(hapticd::seedOf(1));
  for (float& v : image.values) v = static_cast<float>(random.below(4));
  for (const float iso : {1.0F, 2.0F, 3.0F}) {  // Values equal to iso abound.
    Surface surface = isosurface(image, iso);
    expectClosed(surface, true);
    const std::size_t parts = keepLargest(surface);
    if (iso == 3) {
      EXPECT_GT(parts, 1u) << "of a quarter of the voxels some stand alone, of more perhaps none";
    }
    EXPECT_GT(surface.triangles.size(), 100u);
  }
}

// As a resampled needle or the lattice of a long rod is: keys of 18 bits an axis made one vertex of two.
TEST(Surface, longOnesStayManifold) {
  LatticeSolid solid;
  solid.size = {2, 2, 300'000};
  std::vector<float> values(std::size_t{4} * 300'000, 0);
  std::fill(values.end() - 40, values.end(), 1.0f);  // The last ten layers.
  solid.layers = {values};
  solid.iso = 0.5f;
  solid.place = [](const Double3& at) { return Double3{at[0], at[1], at[2] - 299'990}; };
  const Surface surface = isosurface(solid);
  expectClosed(surface, false);
  EXPECT_EQ(2 * surface.vertices.size(), surface.triangles.size() + 4) << "Euler's formula";
  EXPECT_NEAR(volumeOf(surface), 9.8, 0.2);
  solid.size[2] = 1u << 20;
  EXPECT_THROW((void)isosurface(solid), ImportError);
}

TEST(Image, cropsShrinksAndSmoothsInPlace) {
  const Image image = ballImage();
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
  smoothed = image;
  smooth(smoothed, 1e-300);  // Whose square is 0: all values were none.
  EXPECT_EQ(smoothed.values, image.values);
  EXPECT_THROW((void)crop(image, {0, 0, 0}, {1, 9, 9}), ImportError);
  EXPECT_THROW((void)shrink(image, 9), ImportError);
}

// All its vertices were one.
TEST(Image, isRefusedWhereFloatsDoNotTellItsValuesApart) {
  Image image = ballImage();
  image.origin = {0, 9e5, 0};
  EXPECT_NO_THROW(checkPlace(image));
  EXPECT_NEAR(volumeOf(isosurface(image, 200)), volumeOf(isosurface(ballImage(), 200)), 20);
  image.origin = {0, -1e12, 0};
  EXPECT_THAT(refusal([&] { return checkPlace(image), 0; }), testing::HasSubstr("origin: is 1e+12 mm away"));
}

TEST(Image, resamplesToEvenSteps) {
  Image image = ballImage();
  for (std::size_t z = 0; z < 16; ++z)
    for (std::size_t y = 0; y < 20; ++y)
      for (std::size_t x = 0; x < 24; ++x)
        image.values[x + 24 * (y + 20 * z)] = static_cast<float>(3 * x + 2 * y * 1.5 - z * 2.0);  // Linear in space.
  const Image fine = resample(image, 0.8);
  EXPECT_EQ(fine.size, (std::array<std::uint32_t, 3>{29, 36, 38}));
  for (std::size_t z = 0; z < fine.size[2]; z += 3)
    for (std::size_t y = 0; y < fine.size[1]; y += 5)
      for (std::size_t x = 0; x < fine.size[0]; x += 4) {
        Double3 p = fine.origin;
        for (std::size_t a = 0; a < 3; ++a)
          p[a] += static_cast<double>(x) * fine.step[0][a] + static_cast<double>(y) * fine.step[1][a] +
                  static_cast<double>(z) * fine.step[2][a];
        ASSERT_NEAR(fine.values[x + fine.size[0] * (y + fine.size[1] * z)],
                    3 * (p[0] - 10) + 2 * (p[1] - 20) - (p[2] - 30), 1e-4);
      }
  const Image coarse = resample(ballImage(), 3);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(spacing(coarse, k), 3, 1e-9);
  const double volume = 4.0 / 3 * std::numbers::pi * 512;
  EXPECT_NEAR(volumeOf(isosurface(resample(ballImage(), 1), 200)), volume, 0.03 * volume);
  EXPECT_NEAR(volumeOf(isosurface(coarse, 200)), volume, 0.2 * volume);
  EXPECT_THROW((void)resample(ballImage(), 25), ImportError);
  EXPECT_THROW((void)resample(ballImage(), 1e-3), ImportError);
}

}  // namespace
}  // namespace hapticctl_import::test
