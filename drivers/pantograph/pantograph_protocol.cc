#include "drivers/pantograph/pantograph_protocol.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace hapticd::pantograph {
namespace {

constexpr std::uint8_t kReset = 0, kSetup = 1, kTorques = 2;
constexpr std::uint8_t kBothPorts = 0b11;
constexpr float kMostDegrees = 720;

void putFloat(float value, std::uint8_t* to) HD_RT {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (unsigned i = 0; i < 4; ++i) to[i] = static_cast<std::uint8_t>(bits >> (8 * i));
}

float getFloat(const std::uint8_t* from) HD_RT {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < 4; ++i) bits |= static_cast<std::uint32_t>(from[i]) << (8 * i);
  return std::bit_cast<float>(bits);
}

}  // namespace

std::array<std::uint8_t, 2> encodeReset() HD_RT { return {kReset, kDeviceId}; }

std::array<std::uint8_t, 26> encodeSetup(const std::array<Encoder, kJoints>& encoders, bool motors_clockwise) HD_RT {
  std::array<std::uint8_t, 26> out{};
  const auto motor = static_cast<std::uint8_t>(motors_clockwise ? 1 : 0);
  const std::uint8_t head[] = {kSetup, kDeviceId, kBothPorts, motor, motor, kBothPorts};
  std::copy(std::begin(head), std::end(head), out.begin());
  std::size_t at = std::size(head);
  for (const Encoder& encoder : encoders) out[at++] = encoder.clockwise ? 1 : 0;
  at += 2;  // No sensors, no PWM pins.
  for (const Encoder& encoder : encoders) {
    putFloat(encoder.offset_deg, &out[at]);
    putFloat(encoder.counts_per_turn, &out[at + 4]);
    at += 8;
  }
  return out;
}

std::array<std::uint8_t, 10> encodeTorques(const std::array<float, kJoints>& torque_nm) HD_RT {
  std::array<std::uint8_t, 10> out{kTorques, kDeviceId};
  for (std::size_t i = 0; i < kJoints; ++i) putFloat(std::isfinite(torque_nm[i]) ? torque_nm[i] : 0, &out[2 + 4 * i]);
  return out;
}

void Parser::drop(std::size_t bytes) HD_RT {
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(bytes), bytes_.begin() + static_cast<std::ptrdiff_t>(size_),
            bytes_.begin());
  size_ -= bytes;
}

void Parser::feed(std::span<const std::uint8_t> bytes) HD_RT {
  if (bytes.size() > kRoom) {
    dropped_ += bytes.size() - kRoom;
    bytes = bytes.last(kRoom);
  }
  if (bytes.size() > kRoom - size_) {
    const std::size_t old = bytes.size() - (kRoom - size_);
    dropped_ += old;
    drop(old);
  }
  std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
}

std::optional<std::array<float, kJoints>> Parser::next() HD_RT {
  while (size_ >= kAnswerBytes) {
    std::array<float, kJoints> angles{};
    bool good = bytes_[0] == kDeviceId;
    for (std::size_t i = 0; i < kJoints; ++i) {
      angles[i] = getFloat(&bytes_[1 + 4 * i]);
      good = good && std::abs(angles[i]) <= kMostDegrees;  // False for NaN.
    }
    if (good) {
      drop(kAnswerBytes);
      return angles;
    }
    drop(1);
    ++dropped_;
  }
  return std::nullopt;
}

}  // namespace hapticd::pantograph
