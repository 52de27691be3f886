// Lengths of the command line: in metres, or in the unit that stands behind them.
#include "tools/hapticctl/lengths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string refusal(const char* text, std::size_t count = 1) {
  try {
    (void)parseLengths("--size", text, count);
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.exit, kExitUsage);
    return failure.where + ": " + failure.what + ": " + failure.remedy;
  }
  return "not refused";
}

std::string noted(const char* text, std::size_t count) {
  ::testing::internal::CaptureStderr();
  (void)parseLengths("--size", text, count);
  return ::testing::internal::GetCapturedStderr();
}

TEST(Lengths, HaveAUnitOrAreMetres) {
  // 9mm and 0.009 are the same number: what the daemon tells of it is as short as what was written.
  EXPECT_THAT(parseLengths("--size", "9mm,-0.5cm,0", 3), ElementsAre(0.009, -0.005, 0.0));
  EXPECT_THAT(parseLengths("--size", "9mm, 9mm", 2), ElementsAre(0.009, 0.009));
  EXPECT_THAT(parseLengths("--size", "1e2um,2m,1in,1inch,1ft", 0),
              ElementsAre(1e-4, 2.0, DoubleEq(0.0254), DoubleEq(0.0254), DoubleEq(0.3048)));
}

TEST(Lengths, OfOptionsInMillimetresMayHaveAUnitToo) {
  for (const char* half : {"0.5mm", "5e-1mm", "0.05cm", "500um", "0.0005m"})
    EXPECT_THAT(std::stod(hapticd_options::millimetres(half)), DoubleEq(0.5)) << half;
  EXPECT_EQ(hapticd_options::millimetres("0.1mm"), "0.1");
  for (const char* as_it_is : {"0.5", "", "mm", "0.5kg", "1mm2", "nanmm"})
    EXPECT_EQ(hapticd_options::millimetres(as_it_is), as_it_is);
}

TEST(Lengths, AreRefusedInWords) {
  EXPECT_THAT(refusal("10mn"), HasSubstr("--size: 'mn' in '10mn' is no unit: units are um, mm"));
  EXPECT_THAT(refusal("10 mm"), HasSubstr("without a space"));
  EXPECT_THAT(refusal("1,2mm", 2), HasSubstr("'1,2mm' has a unit for some of its lengths"));  // Not 1 m by 2 mm.
  EXPECT_THAT(refusal("10mm,5"), HasSubstr("one length is wanted"));
  for (const char* bad : {"", "mm", "nan", "inf", "0x10", "1mm2", "mm1", "1e999mm"})
    EXPECT_THAT(refusal(bad), HasSubstr("is not a finite number")) << bad;
  EXPECT_THROW((void)parseLength("--depth", "0mm"), Failure);
  EXPECT_THROW((void)parseLength("--depth", "-1mm"), Failure);
}

TEST(Lengths, OfAMetreWithoutAUnitAreNoted) {
  EXPECT_EQ(noted("10", 1),
            "hapticctl: --size: 10 without a unit is 10.0 m; write 10mm or 10m to say which you mean\n");
  EXPECT_THAT(noted("-1,2,3", 3), HasSubstr("-1 without a unit"));
  for (const char* plain : {"0.999", "10m", "1000mm", "10mm"}) EXPECT_THAT(noted(plain, 1), IsEmpty()) << plain;
}

}  // namespace
}  // namespace hapticctl
