// Report descriptors written by hand, item by item, and what they say.
#include "drivers/hid/report_descriptor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace hapticd {
namespace {

using Bytes = std::vector<std::uint8_t>;

HidReports parsed(const Bytes& bytes) {
  Result<HidReports> reports = HidReports::parse(bytes);
  EXPECT_TRUE(reports.ok()) << (reports.ok() ? "" : toString(reports.error()));
  return reports.ok() ? std::move(*reports) : HidReports{};
}

/** Three axes of 16 bits in report 1, a feature of 10 bits in report 5, choices in report 2. */
const Bytes kExample = {0x05, 0x01,                                      // Usage Page (Generic Desktop)
                        0x09, 0x08,                                      // Usage (Multi-axis Controller)
                        0xa1, 0x01,                                      // Collection (Application)
                        0xa1, 0x00,                                      //   Collection (Physical), without a usage
                        0x85, 0x01,                                      //     Report ID 1
                        0x16, 0xa2, 0xfe,                                //     Logical Minimum -350
                        0x26, 0x5e, 0x01,                                //     Logical Maximum 350
                        0x75, 0x10, 0x95, 0x03,                          //     16 bits, three of them
                        0x09, 0x30, 0x09, 0x31, 0x09, 0x32, 0x81, 0x06,  // X, Y, Z; Input (Variable, Relative)
                        0xc0,                                            //   End
                        0x85, 0x05,                                      //   Report ID 5
                        0x05, 0x0f,                                      //   Usage Page (Physical Interface)
                        0x09, 0xab, 0xa1, 0x02,                          //   Create New Effect, Collection (Logical)
                        0x75, 0x06, 0x95, 0x01, 0xb1, 0x03,              //     6 bits of padding, Feature
                        0x15, 0x00, 0x26, 0xff, 0x03,                    //     0 to 1023
                        0x75, 0x0a, 0x0b, 0x3b, 0x00, 0x01, 0x00,  //     10 bits; usage 0x3b of page 1, written in full
                        0xb1, 0x02,                                //     Feature
                        0xc0,                                      //   End
                        0x85, 0x02,                                //   Report ID 2
                        0x09, 0x25, 0xa1, 0x02,                    //   Effect Type, Collection (Logical)
                        0x09, 0x26, 0x09, 0x40, 0x09, 0x41,        //     Constant, Spring, Damper
                        0x15, 0x01, 0x25, 0x03, 0x75, 0x08, 0x95, 0x01,  //     1 to 3, 8 bits, one
                        0x91, 0x00,                                      //     Output (Array)
                        0xc0, 0xc0};

/** HID 1.11, 6.2.2.8: a usage is of the page that is in force at its main item. */
TEST(ReportDescriptor, AUsageIsOfThePageThatStandsAtItsMainItem) {
  const HidReports late = parsed({0x05, 0x01, 0x09, 0x04, 0xa1, 0x01,  // Generic Desktop, Joystick, Collection
                                  0x15, 0x00, 0x25, 0x7f, 0x75, 0x08,  // 0 to 127, 8 bits
                                  0x05, 0x09, 0x95, 0x03,              // Usage Page (Button), three of them
                                  0x09, 0x30, 0x09, 0x31,              // 0x30 and 0x31 ...
                                  0x0b, 0x32, 0x00, 0x02, 0x00,        // ... and 0x32 of page 2, written in full
                                  0x05, 0x01, 0x81, 0x02,              // Usage Page (Generic Desktop), Input
                                  0xc0});
  EXPECT_NE(late.find(HidKind::kInput, hidUsage(1, 0x30)), nullptr);
  EXPECT_NE(late.find(HidKind::kInput, hidUsage(1, 0x31)), nullptr);
  EXPECT_NE(late.find(HidKind::kInput, hidUsage(2, 0x32)), nullptr);
  EXPECT_EQ(late.find(HidKind::kInput, hidUsage(9, 0x30)), nullptr);
  // One item for two pages: each keeps its own, as the kernel has it.
  const HidReports mixed =
      parsed({0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x15, 0x00, 0x25, 0x7f, 0x75, 0x08, 0x95, 0x02, 0x09, 0x30,  // X
              0x05, 0x02, 0x09, 0xc4, 0x81, 0x02,  // Simulation, Accelerator; Input
              0xc0});
  EXPECT_NE(mixed.find(HidKind::kInput, hidUsage(1, 0x30)), nullptr);
  EXPECT_NE(mixed.find(HidKind::kInput, hidUsage(2, 0xc4)), nullptr);
}

TEST(ReportDescriptor, FindsFieldsWhereTheItemsPutThem) {
  const HidReports reports = parsed(kExample);
  EXPECT_TRUE(reports.numbered());
  const HidField* y = reports.find(HidKind::kInput, hidUsage(1, 0x31));
  ASSERT_NE(y, nullptr);
  EXPECT_EQ(y->report_id, 1);
  EXPECT_EQ(y->bit_offset, 16);
  EXPECT_EQ(y->bits, 16);
  EXPECT_TRUE(y->is_relative);
  EXPECT_EQ(y->logical_min, -350);
  EXPECT_EQ(y->logical_max, 350);
  EXPECT_TRUE(reports.isWithin(*y, hidUsage(1, 8)));
  EXPECT_FALSE(reports.isWithin(*y, hidUsage(0x0f, 0xab)));
  EXPECT_EQ(reports.reportBytes(HidKind::kInput, 1), 7u);
  EXPECT_EQ(reports.reportBytes(HidKind::kFeature, 5), 3u);
  EXPECT_EQ(reports.reportBytes(HidKind::kOutput, 1), 0u);

  const HidField* bytes = reports.find(HidKind::kFeature, hidUsage(1, 0x3b), hidUsage(0x0f, 0xab));
  ASSERT_NE(bytes, nullptr);
  EXPECT_EQ(bytes->bit_offset, 6);
  EXPECT_EQ(bytes->bits, 10);
  EXPECT_EQ(reports.find(HidKind::kFeature, hidUsage(1, 0x3b), hidUsage(0x0f, 0x21)), nullptr);

  const HidField* type = reports.findChoice(HidKind::kOutput, hidUsage(0x0f, 0x40), hidUsage(0x0f, 0x25));
  ASSERT_NE(type, nullptr);
  EXPECT_EQ(valueOfChoice(*type, hidUsage(0x0f, 0x26)), 1);
  EXPECT_EQ(valueOfChoice(*type, hidUsage(0x0f, 0x41)), 3);
  EXPECT_EQ(valueOfChoice(*type, hidUsage(0x0f, 0x42)), 0);
}

TEST(ReportDescriptor, NumbersGoInAndComeOutWhereTheyBelong) {
  const HidReports reports = parsed(kExample);
  const HidField& x = *reports.find(HidKind::kInput, hidUsage(1, 0x30));
  EXPECT_EQ(extract(x, Bytes{0xa2, 0xfe, 0, 0, 0, 0}), -350);
  EXPECT_EQ(extract(x, Bytes{0x2c, 0x01, 0, 0, 0, 0}), 300);
  EXPECT_EQ(extract(x, Bytes{0x2c}), 0);  // torn
  const HidField& bytes = *reports.find(HidKind::kFeature, hidUsage(1, 0x3b));
  Bytes data = {0xff, 0xff};
  insert(bytes, 0x155, data);
  EXPECT_EQ(data, (Bytes{0x7f, 0x55}));  // the six bits of padding stay
  EXPECT_EQ(extract(bytes, data), 0x155);
  insert(bytes, 5000, data);  // clamped
  EXPECT_EQ(extract(bytes, data), 1023);
  insert(bytes, -1, data);
  EXPECT_EQ(data, (Bytes{0x3f, 0x00}));
}

TEST(ReportDescriptor, WithoutNumbersReportsHaveNoId) {
  const HidReports reports =
      parsed({0x06, 0xab, 0xff, 0x0a, 0x00, 0x02, 0xa1, 0x01, 0x75, 0x08, 0x15, 0x00, 0x26, 0xff,
              0x00, 0x95, 0x40, 0x09, 0x01, 0x81, 0x02, 0x95, 0x40, 0x09, 0x02, 0x91, 0x02, 0xc0});
  EXPECT_FALSE(reports.numbered());
  EXPECT_EQ(reports.reportBytes(HidKind::kOutput, 0), 64u);
  EXPECT_EQ(reports.fields().size(), 128u);
}

TEST(ReportDescriptor, AMaximumOf255InOneByteIsNotMinusOne) {
  const HidReports reports =
      parsed({0x05, 0x0f, 0x09, 0x01, 0x15, 0x00, 0x25, 0xff, 0x75, 0x08, 0x95, 0x01, 0x91, 0x02});
  ASSERT_EQ(reports.fields().size(), 1u);
  EXPECT_EQ(reports.fields()[0].logical_max, 255);
}

TEST(ReportDescriptor, ARangeIsNoLargerThanItsBits) {
  // -10000 to 10000 in 8 bits: the largest value must not come out as 16, nor 128 as -128.
  const HidReports reports = parsed({0x05, 0x0f, 0x09, 0x01, 0x16, 0xf0, 0xd8, 0x26, 0x10, 0x27, 0x75, 0x08, 0x95,
                                     0x01, 0x91, 0x02, 0x09, 0x02, 0x15, 0x00, 0x91, 0x02, 0x09, 0x03, 0x17, 0x00,
                                     0x00, 0x00, 0x80, 0x27, 0xff, 0xff, 0xff, 0x7f, 0x75, 0x20, 0x91, 0x02});
  ASSERT_EQ(reports.fields().size(), 3u);
  const HidField &both = reports.fields()[0], &positive = reports.fields()[1], &whole = reports.fields()[2];
  EXPECT_EQ(both.logical_min, -128);
  EXPECT_EQ(both.logical_max, 127);
  EXPECT_EQ(positive.logical_min, 0);
  EXPECT_EQ(positive.logical_max, 255);
  EXPECT_EQ(whole.logical_min, std::numeric_limits<std::int32_t>::min());
  EXPECT_EQ(whole.logical_max, std::numeric_limits<std::int32_t>::max());
  for (const std::int32_t value : {10'000, 128, -10'000, 5}) {
    Bytes data(6);
    insert(both, value, data);
    EXPECT_EQ(extract(both, data), std::clamp(value, -128, 127));
  }
}

TEST(ReportDescriptor, ChoicesThatNoValueSelectsAreNone) {
  // Of three usages the second would be told as the largest number there is and one, the third as two more.
  for (const bool largest : {true, false}) {
    Bytes bytes = {0x05, 0x0f, 0x09, 0x26, 0x09, 0x40, 0x09, 0x41, 0x75, 0x20, 0x95, 0x01};
    const Bytes range =
        largest ? Bytes{0x17, 0xff, 0xff, 0xff, 0x7f, 0x27, 0xff, 0xff, 0xff, 0x7f} : Bytes{0x15, 0x01, 0x25, 0x01};
    bytes.insert(bytes.end(), range.begin(), range.end());
    bytes.insert(bytes.end(), {0x91, 0x00});
    const HidReports reports = parsed(bytes);
    EXPECT_NE(reports.findChoice(HidKind::kOutput, hidUsage(0x0f, 0x26)), nullptr);
    EXPECT_EQ(reports.findChoice(HidKind::kOutput, hidUsage(0x0f, 0x40)), nullptr);
  }
}

TEST(ReportDescriptor, ARangeOfUsagesEndsWithTheLastThereIs) {
  const HidReports reports = parsed({0x1b, 0xfe, 0xff, 0xff, 0xff, 0x2b, 0xff, 0xff, 0xff, 0xff,
                                     0x15, 0x00, 0x25, 0x7f, 0x75, 0x08, 0x95, 0x01, 0x91, 0x00});
  ASSERT_EQ(reports.fields().size(), 1u);
  EXPECT_EQ(reports.fields()[0].choices, (std::vector<HidUsage>{0xffff'fffe, 0xffff'ffff}));
}

/** HID 1.11, 6.2.2.3: its length stands in its second byte; nobody has ever given one a meaning. */
TEST(ReportDescriptor, ALongItemIsPassedOver) {
  const Bytes around = {0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x15, 0x00, 0x25, 0x7f,
                        0x75, 0x08, 0x95, 0x01, 0x09, 0x30, 0x81, 0x02, 0xc0};
  const Bytes item = {0xfe, 0x02, 0xf0, 0xc0, 0xc0};  // Within it two bytes that would end collections.
  for (std::size_t at = 0; at <= around.size(); at += at == 18 ? 1 : 2) {
    Bytes all = around;
    all.insert(all.begin() + static_cast<std::ptrdiff_t>(at), item.begin(), item.end());
    const HidReports reports = parsed(all);
    const HidField* x = reports.find(HidKind::kInput, hidUsage(1, 0x30));
    ASSERT_NE(x, nullptr) << at;
    EXPECT_EQ(x->bits, 8) << at;
  }
  for (std::size_t of_it = 1; of_it < item.size(); ++of_it) {
    Bytes cut = around;
    cut.insert(cut.end(), item.begin(), item.begin() + static_cast<std::ptrdiff_t>(of_it));
    EXPECT_FALSE(HidReports::parse(cut).ok()) << of_it;
  }
}

TEST(ReportDescriptor, AUnitsExponentHasFourBitsInHoweverManyItIsWritten) {
  const HidReports reports = parsed({0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x15, 0x00, 0x25, 0x7f, 0x75, 0x08,
                                     0x95, 0x01, 0x66, 0x03, 0x10, 0x55, 0x0d, 0x09, 0x30, 0x81, 0x02,  // X: 10^-3 s
                                     0x55, 0xfd, 0x09, 0x31, 0x81, 0x02,                                // Y: the same
                                     0x55, 0x07, 0x65, 0x00, 0x09, 0x32, 0x81, 0x02, 0xc0});
  const HidField *x = reports.find(HidKind::kInput, hidUsage(1, 0x30)),
                 *y = reports.find(HidKind::kInput, hidUsage(1, 0x31)),
                 *z = reports.find(HidKind::kInput, hidUsage(1, 0x32));
  ASSERT_TRUE(x != nullptr && y != nullptr && z != nullptr);
  EXPECT_EQ(x->unit, 0x1003u);
  EXPECT_EQ(x->unit_exponent, -3);
  EXPECT_EQ(y->unit, 0x1003u);
  EXPECT_EQ(y->unit_exponent, -3);
  EXPECT_EQ(z->unit, 0u);
  EXPECT_EQ(z->unit_exponent, 7);
}

TEST(ReportDescriptor, APhysicalRangeIsThatOfTheFieldsAfterIt) {
  const HidReports reports = parsed({0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x15, 0x00, 0x25,
                                     0x7f, 0x75, 0x08, 0x95, 0x01, 0x09, 0x30, 0x81, 0x02,  // X, without one
                                     0x36, 0x4c, 0xff, 0x46, 0x10, 0x27,                    // -180 to 10000
                                     0x09, 0x31, 0x81, 0x02, 0xc0});                        // Y
  const HidField *x = reports.find(HidKind::kInput, hidUsage(1, 0x30)),
                 *y = reports.find(HidKind::kInput, hidUsage(1, 0x31));
  ASSERT_TRUE(x != nullptr && y != nullptr);
  EXPECT_EQ(x->physical_min, 0);
  EXPECT_EQ(x->physical_max, 0);
  EXPECT_EQ(y->physical_min, -180);
  EXPECT_EQ(y->physical_max, 10000);
}

TEST(ReportDescriptor, PushAndPopBringTheOldStateBack) {
  const HidReports reports = parsed({0x05, 0x0f, 0x75, 0x08, 0x95, 0x01, 0x25, 0x64, 0xa4, 0x75,
                                     0x10, 0x09, 0x01, 0x91, 0x02, 0xb4, 0x09, 0x02, 0x91, 0x02});
  ASSERT_EQ(reports.fields().size(), 2u);
  EXPECT_EQ(reports.fields()[0].bits, 16);
  EXPECT_EQ(reports.fields()[1].bits, 8);
  EXPECT_EQ(reports.fields()[1].bit_offset, 16);
}

struct Broken {
  const char* name;
  Bytes bytes;
  ErrorCode code;
};
void PrintTo(const Broken& broken, std::ostream* out) { *out << broken.name; }  // Else its bytes, pointers among them.
struct BrokenDescriptor : testing::TestWithParam<Broken> {};

TEST_P(BrokenDescriptor, IsRefusedWithItsPlace) {
  const Result<HidReports> reports = HidReports::parse(GetParam().bytes);
  ASSERT_FALSE(reports.ok());
  EXPECT_EQ(reports.error().code, GetParam().code) << toString(reports.error());
  EXPECT_NE(reports.error().where.find("byte "), std::string::npos);
  EXPECT_FALSE(reports.error().what.empty());
}

Bytes deep() {
  Bytes bytes;
  for (int i = 0; i < 17; ++i) bytes.insert(bytes.end(), {0xa1, 0x00});
  return bytes;
}

INSTANTIATE_TEST_SUITE_P(
    Hid, BrokenDescriptor,
    testing::Values(
        Broken{"torn", {0x26, 0x5e}, ErrorCode::kInvalidArgument},
        Broken{"open", {0xa1, 0x01}, ErrorCode::kInvalidArgument},
        Broken{"closed_twice", {0xc0}, ErrorCode::kInvalidArgument}, Broken{"pop", {0xb4}, ErrorCode::kInvalidArgument},
        Broken{"id_zero", {0x85, 0x00}, ErrorCode::kInvalidArgument},
        Broken{"long_item", {0xfe, 0x10, 0x00, 0x01}, ErrorCode::kInvalidArgument},
        Broken{"upside_down",
               {0x05, 0x0f, 0x09, 0x01, 0x15, 0x05, 0x25, 0x02, 0x75, 0x08, 0x95, 0x01, 0x91, 0x02},
               ErrorCode::kInvalidArgument},
        Broken{"deep", deep(), ErrorCode::kUnsupported},
        Broken{"huge",
               {0x05, 0x0f, 0x09, 0x01, 0x77, 0xff, 0xff, 0xff, 0xff, 0x97, 0xff, 0xff, 0xff, 0xff, 0x91, 0x02},
               ErrorCode::kUnsupported},
        Broken{"many",
               {0x05, 0x0f, 0x09, 0x01, 0x25, 0x01, 0x75, 0x01, 0x96, 0x01, 0x04, 0x91, 0x02},
               ErrorCode::kUnsupported}),
    [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace hapticd
