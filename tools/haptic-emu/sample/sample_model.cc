#include "tools/haptic-emu/sample/sample_model.h"

#include <algorithm>
#include <cmath>

namespace haptic_emu {
namespace {

/** CRC-16 by polynomial division over the bits, most significant first, with the start value written out. */
std::uint16_t sumOf(const std::uint8_t* bytes, int count) {
  std::uint32_t remainder = 0xffff;
  for (int bit = 0; bit < 8 * count; ++bit) {
    const std::uint32_t next = bytes[bit / 8] >> (7 - bit % 8) & 1u;
    const bool carry = ((remainder >> 15 & 1u) ^ next) != 0;
    remainder = (remainder << 1 & 0xffffu) ^ (carry ? 0x1021u : 0u);
  }
  return static_cast<std::uint16_t>(remainder);
}

}  // namespace

void SampleModel::advance(std::int64_t t_ns) {
  for (; now_ns_ + Hand::kStep_ns <= t_ns; now_ns_ += Hand::kStep_ns) {
    if (!plugged() || now_ns_ - ordered_ns_ > kWatchdog_ns) force_.setZero();
    hand.step(force_);
  }
}

void SampleModel::out(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != 12 || bytes[0] != 0x5a || sumOf(bytes.data(), 10) != (bytes[10] | bytes[11] << 8)) return;
  ordered_ns_ = now_ns_;
  for (int axis = 0; axis < 3; ++axis) {
    int value = bytes[2 + 2 * axis] + 256 * bytes[3 + 2 * axis];
    if (value > 32767) value -= 65536;
    force_[axis] = (bytes[8] & 1) != 0 ? value / 1000.0 : 0.0;
  }
}

std::optional<std::vector<std::uint8_t>> SampleModel::in(std::size_t) {
  const std::int64_t ms = now_ns_ / 1'000'000;
  if (ms == said_ms_ || faults.active(FaultKind::kSilence, now_ns_)) return {};
  said_ms_ = ms;
  std::vector<std::uint8_t> packet(12);
  packet[0] = 0xa5;
  packet[1] = ++number_;
  const double jump = faults.active(FaultKind::kEncoderJump, now_ns_) ? 25'000 : 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double counts = std::clamp(hand.position()[axis] * 1e5 + jump, -32768.0, 32767.0);
    const auto value = static_cast<unsigned>(std::lround(counts)) & 0xffffu;
    std::uint8_t* const at = &packet[2 + 2 * static_cast<std::size_t>(axis)];
    at[0] = static_cast<std::uint8_t>(value & 0xff);
    at[1] = static_cast<std::uint8_t>(value >> 8);
  }
  packet[8] = buttons;
  const std::uint16_t sum = sumOf(packet.data(), 10);
  packet[10] = static_cast<std::uint8_t>(sum & 0xff);
  packet[11] = static_cast<std::uint8_t>(sum >> 8);
  if (faults.active(FaultKind::kGarbage, now_ns_) && noise_.byte() % 4 == 0) packet[noise_.byte() % 12] ^= 0x21;
  if (faults.active(FaultKind::kTruncation, now_ns_) && noise_.byte() % 4 == 0) packet.resize(noise_.byte() % 12);
  return packet;
}

}  // namespace haptic_emu
