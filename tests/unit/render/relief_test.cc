#include "rt/render/surface/relief.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/seeds.h"
#include "tests/support/shape/test_surface.h"

namespace hapticd {
namespace {

using test::TestRelief;

SurfaceParameters laid(double depth, double width, double height) {
  SurfaceParameters s{};
  s.relief_depth = depth;
  s.relief_size[0] = width;
  s.relief_size[1] = height;
  return s;
}

TEST(Relief, ARampIsARamp) {
  // Grey rises to the right and falls downward: seen along z, height rises with x and with y.
  const TestRelief t(100, 50, [](auto x, auto y) { return (x + 0.5) / 200 + (49.5 - y) / 100; });
  const SurfaceParameters s = laid(1e-3, 0.1, 0.05);
  for (const double x : {-0.03, 0.0, 0.0217, 0.04}) {
    for (const double y : {-0.02, 0.0, 0.0113}) {
      const ReliefPoint p = reliefAt(t.view.relief, s, {x, y, 123.4}, Vec3::UnitZ());
      // Half a grey over 0.1 m and half over 0.05 m; a 16-bit step of grey is 1.5e-5 of the depth.
      EXPECT_NEAR(p.height, 1e-3 * (0.5 + x / 0.2 + y / 0.1 - 1), 2e-8);
      EXPECT_NEAR(p.gradient.x(), 1e-3 / 0.2, 2e-5);
      EXPECT_NEAR(p.gradient.y(), 1e-3 / 0.1, 2e-5);
      EXPECT_EQ(p.gradient.z(), 0);
    }
  }
}

TEST(Relief, EachAxisShowsTheSamePicture) {
  std::mt19937 random(seedOf(3));
  std::uniform_real_distribution<double> grey;
  const TestRelief t(16, 8, [&](auto, auto) { return grey(random); });
  const SurfaceParameters s = laid(1e-3, 0.02, 0.01);
  const double u = 0.0031, v = -0.0012;
  const ReliefPoint z = reliefAt(t.view.relief, s, {u, v, 1}, Vec3::UnitZ());
  const ReliefPoint y = reliefAt(t.view.relief, s, {u, 1, v}, -Vec3::UnitY());
  const ReliefPoint x = reliefAt(t.view.relief, s, {1, u, v}, Vec3::UnitX());
  EXPECT_EQ(z.height, y.height);
  EXPECT_EQ(z.height, x.height);
  EXPECT_EQ(z.gradient.x(), y.gradient.x());
  EXPECT_EQ(z.gradient.y(), y.gradient.z());
  EXPECT_EQ(z.gradient.x(), x.gradient.y());
}

/** The gradient is the height's, continuous over all borders, and no steeper than the steepest step. */
TEST(Relief, GradientIsTheHeightsAndBounded) {
  std::mt19937 random(seedOf(5));
  std::uniform_real_distribution<double> number(-1, 1), grey;
  const TestRelief t(9, 7, [&](auto, auto) { return grey(random); });
  const SurfaceParameters s = laid(2e-3, 0.018, 0.014);  // Pixels of 2 mm.
  double across = 0, down = 0;
  for (std::uint32_t y = 0; y < 7; ++y) {
    for (std::uint32_t x = 0; x < 9; ++x) {
      if (x < 8) across = std::max(across, std::abs(t.pixels[9 * y + x + 1] - double(t.pixels[9 * y + x])));
      if (y < 6) down = std::max(down, std::abs(t.pixels[9 * y + 9 + x] - double(t.pixels[9 * y + x])));
    }
  }
  across *= 2e-3 / 65535 / 2e-3;
  down *= 2e-3 / 65535 / 2e-3;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 x(0.1 * number(random), 0.1 * number(random), 0.1 * number(random));  // Over many mirrored copies.
    const Vec3 n = Vec3(number(random), number(random), number(random)).normalized();
    const ReliefPoint p = reliefAt(t.view.relief, s, x, n);
    ASSERT_LE(p.height, 0);
    ASSERT_GE(p.height, -2e-3);
    const double e = 1e-8;
    for (int axis = 0; axis < 3; ++axis) {
      const double higher = reliefAt(t.view.relief, s, x + e * Vec3::Unit(axis), n).height;
      const double lower = reliefAt(t.view.relief, s, x - e * Vec3::Unit(axis), n).height;
      ASSERT_NEAR(p.gradient[axis], (higher - lower) / (2 * e), 1e-5);
    }
    const ReliefPoint flat = reliefAt(t.view.relief, s, x, Vec3::UnitZ());
    ASSERT_LE(std::abs(flat.gradient.x()), across * (1 + 1e-12));
    ASSERT_LE(std::abs(flat.gradient.y()), down * (1 + 1e-12));
  }
}

TEST(Relief, FarFromTheOriginAllIsFinite) {
  const TestRelief t(2, 2, [](auto x, auto y) { return x == y ? 1 : 0; });
  for (const double far : {1e3, -1e3, 1e9, -1e9}) {
    const ReliefPoint p = reliefAt(t.view.relief, laid(1e-3, 1e-4, 1e-4), {far, far, far}, Vec3(1, 1, 1).normalized());
    EXPECT_TRUE(std::isfinite(p.height) && isFinite(p.gradient));
    EXPECT_LE(p.height, 0);
    EXPECT_GE(p.height, -1e-3 * (1 + 1e-12));
  }
}

TEST(Relief, NoPlaceAndNoSizeReadsBesideThePicture) {
  // Sizes and places as only a recording that somebody made up can have them; the address sanitizer watches.
  const TestRelief t(3, 2, [](auto x, auto) { return x / 3.0; });
  for (const double size : {1e-310, 1e-300, 1e-17, 0.01, 1e300}) {
    for (const double x : {0.0, -0.3, 1e9, -1e17, 1e300}) {
      const ReliefPoint p = reliefAt(t.view.relief, laid(1e-3, size, size), {x, -x, x}, Vec3(0.6, 0, 0.8));
      EXPECT_TRUE(std::isnan(p.height) || p.height <= 1e-9 || size != 0.01) << size << " " << x;
    }
  }
}

}  // namespace
}  // namespace hapticd
