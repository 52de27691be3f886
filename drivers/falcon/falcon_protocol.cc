#include "drivers/falcon/falcon_protocol.h"

#include <algorithm>

namespace hapticd::falcon {
namespace {

constexpr std::uint8_t kBegin = '<', kEnd = '>';
constexpr std::uint8_t kZero = 0x41;  ///< Every payload byte is this plus its value.

/** Sixteen bits as four nibbles, the lowest first. */
void putNibbles(std::uint16_t value, std::uint8_t* out) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(kZero + (value >> (4 * i) & 0xf));
}

bool isNibble(std::uint8_t byte) { return byte >= kZero && byte < kZero + 16; }

std::int16_t takeNibbles(const std::uint8_t* in) {
  unsigned value = 0;
  for (int i = 0; i < 4; ++i) value |= static_cast<unsigned>(in[i] - kZero) << (4 * i);
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(value));
}

/** Byte 14 means nothing that we know; all others have their range. */
bool isPacket(const std::uint8_t* p) {
  return p[0] == kBegin && p[kPacket - 1] == kEnd && std::all_of(p + 1, p + 13, isNibble) && p[13] >= kZero &&
         p[13] < kZero + 0x80;
}

}  // namespace

std::array<std::uint8_t, kPacket> encode(const Order& order) noexcept {
  std::array<std::uint8_t, kPacket> out{};
  out[0] = kBegin;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto counts = std::clamp<std::int16_t>(order.motor[i], -kMostCounts, kMostCounts);
    putNibbles(static_cast<std::uint16_t>(counts), &out[1 + 4 * i]);
  }
  out[13] = static_cast<std::uint8_t>(kZero + (order.lights & 0xf));
  out[14] = kZero;
  out[15] = kEnd;
  return out;
}

void Parser::drop(std::size_t n) noexcept {
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(n), bytes_.begin() + static_cast<std::ptrdiff_t>(size_),
            bytes_.begin());
  size_ -= n;
}

void Parser::feed(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() > kMost) {
    dropped_ += bytes.size() - kMost;
    bytes = bytes.last(kMost);
  }
  if (size_ + bytes.size() > kMost) {
    const std::size_t excess = size_ + bytes.size() - kMost;
    dropped_ += excess;
    drop(excess);
  }
  std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
}

bool Parser::next(Reading& reading) noexcept {
  std::size_t at = 0;
  while (at + kPacket <= size_ && !isPacket(&bytes_[at])) ++at;
  dropped_ += at;
  drop(at);
  if (size_ < kPacket) return false;
  for (std::size_t i = 0; i < 3; ++i) reading.encoder[i] = takeNibbles(&bytes_[1 + 4 * i]);
  const auto state = static_cast<std::uint8_t>(bytes_[13] - kZero);
  reading.buttons = state & 0xf;
  reading.homed = state >> 4;
  drop(kPacket);
  return true;
}

}  // namespace hapticd::falcon
