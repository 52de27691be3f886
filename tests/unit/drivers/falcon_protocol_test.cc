#include "drivers/falcon/falcon_protocol.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "tests/support/seeds.h"

namespace hapticd::falcon {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::vector<Reading> parse(Parser& parser, const Bytes& bytes) {
  parser.feed(bytes);
  std::vector<Reading> out;
  Reading reading;
  while (parser.next(reading)) out.push_back(reading);
  return out;
}

// Packets captured from devices, as libnifalcon's translate_packet.py decodes them.
struct Captured {
  Bytes bytes;
  std::array<std::int16_t, 3> encoder;
};
const std::vector<Captured> kCaptured = {
    {{0x3c, 0x50, 0x50, 0x50, 0x41, 0x43, 0x45, 0x50, 0x41, 0x43, 0x4d, 0x50, 0x41, 0x45, 0x41, 0x3e},
     {4095, 3906, 4034}},
    {{0x3c, 0x41, 0x4d, 0x4b, 0x41, 0x4d, 0x4e, 0x4b, 0x41, 0x49, 0x45, 0x4c, 0x41, 0x45, 0x41, 0x3e},
     {2752, 2780, 2888}},
    {{0x3c, 0x4d, 0x4b, 0x45, 0x50, 0x4c, 0x42, 0x41, 0x41, 0x42, 0x4b, 0x44, 0x41, 0x45, 0x41, 0x3e},
     {-2900, 27, 929}},
    {{0x3c, 0x50, 0x49, 0x42, 0x41, 0x42, 0x50, 0x44, 0x50, 0x50, 0x47, 0x45, 0x41, 0x45, 0x41, 0x3e},
     {399, -3087, 1135}},
    {{0x3c, 0x4a, 0x46, 0x4e, 0x50, 0x42, 0x4f, 0x4a, 0x41, 0x4b, 0x4c, 0x49, 0x50, 0x45, 0x41, 0x3e},
     {-679, 2529, -1862}},
};

TEST(FalconProtocol, ReadsCapturedPackets) {
  for (const Captured& captured : kCaptured) {
    Parser parser;
    const auto readings = parse(parser, captured.bytes);
    ASSERT_EQ(readings.size(), 1u);
    EXPECT_EQ(readings[0].encoder, captured.encoder);
    EXPECT_EQ(readings[0].buttons, 4);
    EXPECT_EQ(readings[0].homed, 0);
    EXPECT_EQ(parser.dropped(), 0u);
  }
}

TEST(FalconProtocol, StateByteIsUnsignedAndReachesAllHomedWithAllButtons) {
  Bytes packet = kCaptured[0].bytes;
  packet[13] = 0xc0;
  Parser parser;
  const auto readings = parse(parser, packet);
  ASSERT_EQ(readings.size(), 1u);
  EXPECT_TRUE(readings[0].allHomed());
  EXPECT_EQ(readings[0].buttons, 15);
}

/** Nibbles from 0x41 to 0x50, a state from 0x41 to 0xc0, whatever the last byte says. */
TEST(FalconProtocol, AByteBeyondItsRangeMakesNoPacket) {
  const auto reads = [](std::size_t at, std::uint8_t byte) {
    Bytes packet = kCaptured[1].bytes;
    packet[at] = byte;
    Parser parser;
    return parse(parser, packet).size() == 1;
  };
  for (std::size_t at = 1; at <= 13; ++at) {
    const std::uint8_t greatest = at < 13 ? 0x50 : 0xc0;
    EXPECT_TRUE(reads(at, 0x41) && reads(at, greatest)) << at;
    EXPECT_FALSE(reads(at, 0x40) || reads(at, static_cast<std::uint8_t>(greatest + 1))) << at;
  }
  EXPECT_TRUE(reads(14, 0x00) && reads(14, 0xff));
  EXPECT_FALSE(reads(0, 0x3d) || reads(15, 0x3f));
}

TEST(FalconProtocol, AnIdleOrderIsThatOfTheVendor) {
  const auto bytes = encode({});
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "<AAAAAAAAAAAAAA>");
}

TEST(FalconProtocol, OrdersCarryMotorsLowNibbleFirstAndLights) {
  const auto bytes = encode({{0x123, -1, 0}, kHome | kRed});
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "<DCBAPPPPAAAAJA>");
}

// libnifalcon masks to sixteen bits, so that a force too large turns round.
TEST(FalconProtocol, AnOrderBeyondTheMotorsIsCutAndNeverChangesSign) {
  for (const int counts : {4096, 8192, 32767, -4096, -32768}) {
    const auto cut = static_cast<std::int16_t>(counts > 0 ? kMostCounts : -kMostCounts);
    EXPECT_EQ(encode({{static_cast<std::int16_t>(counts), 0, 0}, 0}), encode({{cut, 0, 0}, 0})) << counts;
  }
}

// libnifalcon drops sixteen bytes at a wrong mark: one stray byte and it may never be in step again.
TEST(FalconProtocol, OneStrayByteAnywhereCostsOnePacketAtMost) {
  Bytes stream;
  for (const Captured& captured : kCaptured) stream.insert(stream.end(), captured.bytes.begin(), captured.bytes.end());
  for (std::size_t at = 0; at <= stream.size(); ++at) {
    for (const std::uint8_t stray : {0x00, 0x3c, 0x3e, 0x41, 0x50, 0xff}) {
      Bytes with = stream;
      with.insert(with.begin() + static_cast<std::ptrdiff_t>(at), stray);
      with.insert(with.end(), kCaptured[0].bytes.begin(), kCaptured[0].bytes.end());
      Parser parser;
      const auto readings = parse(parser, with);
      ASSERT_GE(readings.size(), kCaptured.size()) << at;
      ASSERT_EQ(readings.back().encoder, kCaptured[0].encoder) << "in step at the end";
    }
  }
}

TEST(FalconProtocol, PacketsSplitAnywhereComeTogether) {
  const Bytes& packet = kCaptured[2].bytes;
  for (std::size_t cut = 0; cut <= packet.size(); ++cut) {
    Parser parser;
    EXPECT_EQ(parse(parser, Bytes(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(cut))).size(),
              cut == packet.size() ? 1u : 0u);
    EXPECT_EQ(parse(parser, Bytes(packet.begin() + static_cast<std::ptrdiff_t>(cut), packet.end())).size(),
              cut == packet.size() ? 0u : 1u);
    EXPECT_EQ(parser.dropped(), 0u);
  }
}

TEST(FalconProtocol, EveryByteIsReadOrDropped) {
  std::mt19937 random(seedOf(5));
  Parser parser;
  std::uint64_t fed = 0, read = 0;
  for (int i = 0; i < 2000; ++i) {
    Bytes bytes(random() % 400);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (random() % 2 != 0) bytes.insert(bytes.end(), kCaptured[0].bytes.begin(), kCaptured[0].bytes.end());
    fed += bytes.size();
    read += kPacket * parse(parser, bytes).size();
    ASSERT_LE(read + parser.dropped(), fed);
    ASSERT_GT(read + parser.dropped() + kPacket, fed) << "no more than a part of a packet waits";
  }
  EXPECT_GT(read, 0u);
}

TEST(FalconProtocol, ThePayloadBeginsAfterTheModemsBytes) {
  const Bytes nothing, one{0x31}, two{0x31, 0x60}, three{0x31, 0x60, 0x3c};
  EXPECT_TRUE(payload(nothing).empty());
  EXPECT_TRUE(payload(one).empty());
  EXPECT_TRUE(payload(two).empty());
  ASSERT_EQ(payload(three).size(), 1u);
  EXPECT_EQ(payload(three)[0], 0x3c);
}

}  // namespace
}  // namespace hapticd::falcon
