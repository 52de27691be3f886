// What the sample device says, byte by byte, and its own watchdog.
#include <gtest/gtest.h>

#include "tests/conformance/sample_rig.h"

namespace hapticd::test {
namespace {

TEST(SampleProtocol, TheSumIsTheOnePublished) {
  const std::uint8_t digits[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(sample::crc16(digits), 0x29b1) << "check value of CRC-16/CCITT-FALSE";
}

TEST(SampleProtocol, OnlyAWholePacketIsRead) {
  haptic_emu::SampleModel model;
  model.hand.place({0.01, -0.02, 0.03});
  model.buttons = 2;
  const auto packet = *model.in(64);
  const auto reading = sample::decode(packet);
  ASSERT_TRUE(reading.has_value());
  EXPECT_EQ(reading->position, (std::array<std::int16_t, 3>{1000, -2000, 3000}));
  EXPECT_EQ(reading->buttons, 2);
  for (std::size_t length = 0; length < packet.size(); ++length) {
    EXPECT_FALSE(sample::decode(std::span(packet).first(length)));
  }
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    auto wrong = packet;
    wrong[bit / 8] = static_cast<std::uint8_t>(wrong[bit / 8] ^ 1u << bit % 8);
    EXPECT_FALSE(sample::decode(wrong)) << bit;
  }
}

TEST(SampleModel, ItsWatchdogTakesTheForceBack) {
  haptic_emu::SampleModel model;
  model.out(sample::encode({1, {2000, 0, 0}, sample::kEnable}));
  model.advance(90'000'000);
  EXPECT_EQ(model.force().x(), 2);
  model.advance(101'000'000);
  EXPECT_EQ(model.force().x(), 0);
}

}  // namespace
}  // namespace hapticd::test
