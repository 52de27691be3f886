// Reports byte by byte, from the firmware's description.
#include "drivers/woodyhid/woodyhid_protocol.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapticd::woodyhid {
namespace {

TEST(WoodyProtocol, ReadsLittleEndianCounts) {
  const std::vector<std::uint8_t> report = {0x01, 0x00, 0xff, 0xff, 0x70, 0x17, 0x00,
                                            0x80, 0xff, 0x7f, 0x00, 0x04, 0,    0};
  const auto reading = decode(report);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->encoder, (std::array<std::int32_t, 6>{1, -1, 6000, -32768, 32767, 1024}));
  EXPECT_FALSE(reading->button);
  EXPECT_FALSE(reading->calibrate);
}

TEST(WoodyProtocol, TheStylusButtonTravelsInTheFourthEncoder) {
  std::vector<std::uint8_t> report(14);
  report[6] = 0x10;  // 10000 + 0 = 0x2710
  report[7] = 0x27;
  EXPECT_TRUE(decode(report)->button);
  EXPECT_EQ(decode(report)->encoder[3], 0);
  report[6] = 0x88;  // 5000 = 0x1388: not yet
  report[7] = 0x13;
  EXPECT_FALSE(decode(report)->button);
  EXPECT_EQ(decode(report)->encoder[3], 5000);
}

TEST(WoodyProtocol, TheCalibrationButtonIsExactlyOne) {
  std::vector<std::uint8_t> report(64);
  report[12] = 1;
  EXPECT_TRUE(decode(report)->calibrate);
  report[12] = 2;
  EXPECT_FALSE(decode(report)->calibrate);
}

TEST(WoodyProtocol, ATornReportIsNone) {
  for (std::size_t size = 0; size < 14; ++size) EXPECT_FALSE(decode(std::vector<std::uint8_t>(size, 0xff))) << size;
}

TEST(WoodyProtocol, WritesCurrentsBehindTheReportId) {
  const Report report = encodeCurrents({1000, -2, 0x1234});
  EXPECT_EQ(report.size(), 65u);
  const std::vector<std::uint8_t> begin(report.begin(), report.begin() + 15);
  EXPECT_EQ(begin, (std::vector<std::uint8_t>{0, 0xe8, 0x03, 0xfe, 0xff, 0x34, 0x12, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(WoodyProtocol, CountersOfTheGimbalTravelWhereCurrentsDo) {
  const Report report = encodeCounters({1, 2, -3, 4, 5, 6});
  const std::vector<std::uint8_t> begin(report.begin(), report.begin() + 15);
  EXPECT_EQ(begin, (std::vector<std::uint8_t>{0, 4, 0, 5, 0, 6, 0, 1, 0, 1, 0, 2, 0, 0xfd, 0xff}));
}

}  // namespace
}  // namespace hapticd::woodyhid
