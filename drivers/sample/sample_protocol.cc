#include "drivers/sample/sample_protocol.h"

namespace hapticd::sample {
namespace {

constexpr std::uint8_t kReading = 0xa5, kOrder = 0x5a;
constexpr std::size_t kSummed = kBytes - 2;

std::uint16_t takeU16(const std::uint8_t* in) { return static_cast<std::uint16_t>(in[0] | in[1] << 8); }
void putU16(std::uint16_t value, std::uint8_t* out) {
  out[0] = static_cast<std::uint8_t>(value);
  out[1] = static_cast<std::uint8_t>(value >> 8);
}

}  // namespace

std::uint16_t crc16(std::span<const std::uint8_t> bytes) noexcept {
  std::uint16_t crc = 0xffff;
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ byte << 8);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc & 0x8000) != 0 ? crc << 1 ^ 0x1021 : crc << 1);
    }
  }
  return crc;
}

std::optional<Reading> decode(std::span<const std::uint8_t> packet) noexcept {
  if (packet.size() != kBytes || packet[0] != kReading) return {};
  if (takeU16(&packet[kSummed]) != crc16(packet.first(kSummed))) return {};
  Reading reading;
  reading.number = packet[1];
  for (std::size_t i = 0; i < 3; ++i) reading.position[i] = static_cast<std::int16_t>(takeU16(&packet[2 + 2 * i]));
  reading.buttons = packet[8];
  return reading;
}

std::array<std::uint8_t, kBytes> encode(const Order& order) noexcept {
  std::array<std::uint8_t, kBytes> out{kOrder, order.number};
  for (std::size_t i = 0; i < 3; ++i) putU16(static_cast<std::uint16_t>(order.force_mN[i]), &out[2 + 2 * i]);
  out[8] = order.lights;
  putU16(crc16(std::span<const std::uint8_t>(out).first(kSummed)), &out[kSummed]);
  return out;
}

}  // namespace hapticd::sample
