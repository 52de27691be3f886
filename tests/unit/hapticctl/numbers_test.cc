// Numbers of the command line: exact, locale-free, refused with their place.
#include "tools/hapticctl/numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <clocale>
#include <cmath>
#include <string>

#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string refusal(void (*call)()) {
  try {
    call();
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.exit, kExitUsage);
    return failure.where + ": " + failure.what;
  }
  return "not refused";
}

TEST(Numbers, ParseTheWholeTextOrNothing) {
  EXPECT_EQ(parseNumber("0.5"), 0.5);
  EXPECT_EQ(parseNumber("+1e-3"), 1e-3);
  EXPECT_EQ(parseNumber("-2"), -2.0);
  EXPECT_EQ(parseNumber("-1e-400"), 0.0) << "too small to be told from it";
  EXPECT_EQ(parseNumber("4e-320"), 4e-320);
  for (const char* bad :
       {"", "+", "+-2", "++2", "1,5", "1.5x", " 1", "nan", "inf", "1e999", "1e-400x", "1e99999", "0x10"})
    EXPECT_FALSE(parseNumber(bad)) << bad;
}

TEST(Numbers, KeepThePointInEveryLocale) {
  // Where no comma locale is installed this is the C locale, and the test says less.
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C"}) {
    if (std::setlocale(LC_ALL, name) != nullptr) break;
  }
  EXPECT_EQ(parseNumber("0.25"), 0.25);
  EXPECT_EQ(exact(0.1), "0.1");
  EXPECT_EQ(fixed(1234.5, 1), "1234.5");
  std::setlocale(LC_ALL, "C");
}

TEST(Numbers, VectorsNameTheFieldAtFault) {
  EXPECT_THAT(parseNumbers("--at", "1,2.5,-3", 3), ElementsAre(1, 2.5, -3));
  EXPECT_THAT(parseNumbers("--at", "1, 2.5,  -3", 3), ElementsAre(1, 2.5, -3));
  EXPECT_THAT(refusal([] { (void)parseNumbers("--at", "1, ,3", 3); }),
              HasSubstr("'' is not a finite number (field 2)"));
  EXPECT_THAT(refusal([] { (void)parseNumbers("--at", "1,x,3", 3); }),
              HasSubstr("--at: 'x' is not a finite number (field 2)"));
  EXPECT_THAT(refusal([] { (void)parseNumbers("--at", "1,2", 3); }), HasSubstr("3 numbers are wanted"));
  EXPECT_THAT(refusal([] { (void)parseNumbers("--at", "1,2,3,", 3); }), HasSubstr("field 4"));
}

TEST(Numbers, RotationsAreUnitQuaternions) {
  const double h = std::sqrt(0.5);
  EXPECT_THAT(parseRotation("--rotate", "x,90"), ElementsAre(DoubleNear(h, 1e-15), DoubleNear(h, 1e-15), 0, 0));
  for (const char* const turned : {"x,3600000000000090", "x,-630"}) {
    const auto turn = parseRotation("--rotate", turned);
    EXPECT_NEAR(turn[0] * turn[1], 0.5, 1e-15) << "whole turns are none";
  }
  EXPECT_THAT(parseRotation("--rotate", "2,0,0,0"), ElementsAre(1, 0, 0, 0));
  // First about x, then about z: x goes to y, and y (by way of z) stays z.
  const auto q = multiply(parseRotation("--rotate", "z,90"), parseRotation("--rotate", "x,90"));
  EXPECT_THAT(
      q, ElementsAre(DoubleNear(0.5, 1e-15), DoubleNear(0.5, 1e-15), DoubleNear(0.5, 1e-15), DoubleNear(0.5, 1e-15)));
  // By Hamilton's table: ij = k, jk = i, ki = j.
  constexpr std::size_t kOf[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};
  constexpr double kSign[4][4] = {{1, 1, 1, 1}, {1, -1, 1, -1}, {1, -1, -1, 1}, {1, 1, -1, -1}};
  const std::array<double, 4> a{0.1, -0.7, 0.3, 0.6}, b{0.5, 0.2, -0.8, 0.4}, ab = multiply(a, b);
  std::array<double, 4> expected{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k) expected[kOf[i][k]] += kSign[i][k] * a[i] * b[k];
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(ab[i], expected[i], 1e-15) << i;
  EXPECT_THAT(refusal([] { (void)parseRotation("--rotate", "0,0,0,0"); }), HasSubstr("no length"));
  EXPECT_THAT(refusal([] { (void)parseRotation("--rotate", "w,90"); }), HasSubstr("is no rotation"));
}

TEST(Numbers, AreShownWithTheirUnit) {
  EXPECT_EQ(duration(870), "870 ns");
  EXPECT_EQ(duration(12'345), "12.3 us");
  EXPECT_EQ(duration(999'600), "1.00 ms");
  EXPECT_EQ(duration(3.02e9), "3.02 s");
  EXPECT_EQ(length(0.95), "950 mm");
  EXPECT_EQ(length(950), "950 m");
  EXPECT_EQ(length(2e-5), "20.0 um");
  EXPECT_EQ(length(9.9999e-3), "10.0 mm");
  EXPECT_EQ(length(99.999e-3), "100 mm");
  EXPECT_EQ(bytes(1023), "1023 B");
  EXPECT_EQ(bytes(3 * 1024 * 1024 / 2), "1.50 MiB");
  EXPECT_EQ(grouped(1234567), "1 234 567");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(fixed(-0.001, 2), "0.00");
  EXPECT_EQ(fixed(std::nan(""), 2), "-");
}

}  // namespace
}  // namespace hapticctl
