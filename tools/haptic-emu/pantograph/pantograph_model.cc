#include "tools/haptic-emu/pantograph/pantograph_model.h"

#include <cmath>
#include <cstring>
#include <numbers>

namespace haptic_emu {
namespace {

constexpr double kShort = 0.05, kLong = 0.07, kApart = 0.02, kCentre = 0.07;
/** Newton metres for one that it is told: its makers' programs tell a tenth. */
constexpr double kGain = 10;

float floatAt(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  float value = 0;
  std::memcpy(&value, &bytes[at], sizeof value);  // These machines are little-endian as the board is.
  return value;
}

}  // namespace

PantographModel::PantographModel() : hand(HandParameters{}) { armsOut(); }

void PantographModel::armsOut() {
  const double half = kShort + kApart / 2;
  hand.place(Vec3(std::sqrt(kLong * kLong - half * half) - kCentre, 0, 0));
}

std::array<double, 2> PantographModel::angles(const Vec3& p) {
  // The board's plane: x to the operator's left, y toward them.
  const double x = -p.y() + kApart / 2, y = p.x() + kCentre;
  std::array<double, 2> out{};
  for (int i = 0; i < 2; ++i) {
    const double dx = x - (i == 0 ? 0 : kApart), reach = std::hypot(dx, y);
    const double bend = std::acos((kShort * kShort + reach * reach - kLong * kLong) / (2 * kShort * reach));
    out[static_cast<std::size_t>(i)] = std::atan2(y, dx) + (i == 0 ? bend : -bend);
  }
  return out;
}

Vec3 PantographModel::force() const {
  constexpr double kStep = 1e-7;
  Vec3 force = Vec3::Zero();
  for (int axis = 0; axis < 2; ++axis) {
    const Vec3 step = kStep * Vec3::Unit(axis);
    const auto up = angles(hand.position() + step), down = angles(hand.position() - step);
    for (std::size_t i = 0; i < 2; ++i) force[axis] += kGain * torque_[i] * (up[i] - down[i]) / (2 * kStep);
  }
  return force;
}

void PantographModel::advance(std::int64_t t_ns) {
  now_ns_ = std::max(now_ns_, t_ns);
  if (!plugged()) {
    ready_ = false;
    torque_ = {};
    heard_.clear();
    said.clear();
    answer_ns_ = -1;
    stepped_ns_ = now_ns_;
    return;
  }
  for (; stepped_ns_ + Hand::kStep_ns <= now_ns_; stepped_ns_ += Hand::kStep_ns) hand.step(force());
  if (answer_ns_ >= 0 && now_ns_ >= answer_ns_) answer();
}

void PantographModel::hear(std::span<const std::uint8_t> bytes) {
  heard_.insert(heard_.end(), bytes.begin(), bytes.end());
  const std::size_t lengths[] = {2, 26, 10};
  while (!heard_.empty()) {
    if (heard_[0] > 2) {
      heard_.erase(heard_.begin());
      continue;
    }
    const std::size_t length = lengths[heard_[0]];
    if (heard_.size() < length) return;
    if (heard_[1] == 5 && heard_[0] == 0) {
      ready_ = false;
      torque_ = {};
    } else if (heard_[1] == 5 && heard_[0] == 1) {
      const auto now = angles(hand.position());
      for (std::size_t i = 0; i < 2; ++i) {
        offset_deg_[i] = floatAt(heard_, 10 + 8 * i);
        counts_[i] = floatAt(heard_, 14 + 8 * i);
        zero_[i] = now[i];
      }
      ready_ = heard_[2] == 3 && heard_[5] == 3 && heard_[8] == 0 && heard_[9] == 0;
    } else if (heard_[1] == 5 && ready_) {
      ++orders_;
      for (std::size_t i = 0; i < 2; ++i) torque_[i] = floatAt(heard_, 2 + 4 * i);
      answer_ns_ = now_ns_ + 300'000;
    }
    heard_.erase(heard_.begin(), heard_.begin() + static_cast<std::ptrdiff_t>(length));
  }
}

void PantographModel::answer() {
  answer_ns_ = -1;
  if (faults.active(FaultKind::kSilence, now_ns_)) return;
  std::vector<std::uint8_t> bytes = {5};
  const auto now = angles(hand.position());
  for (std::size_t i = 0; i < 2; ++i) {
    const double turn = std::round((now[i] - zero_[i]) / (2 * std::numbers::pi) * counts_[i]) / counts_[i];
    auto degrees = static_cast<float>(offset_deg_[i] + 360 * turn);
    if (i == 0 && faults.active(FaultKind::kEncoderJump, now_ns_)) degrees += 40;
    std::uint8_t raw[4];
    std::memcpy(raw, &degrees, sizeof raw);
    bytes.insert(bytes.end(), raw, raw + 4);
  }
  if (faults.active(FaultKind::kGarbage, now_ns_) && noise_.byte() < 64) {
    for (int n = noise_.byte() % 8; n >= 0; --n)
      bytes.insert(bytes.begin(), static_cast<std::uint8_t>(noise_.byte() | 0x80));
  }
  if (faults.active(FaultKind::kTruncation, now_ns_) && noise_.byte() < 64) bytes.resize(1 + noise_.byte() % 8);
  said.insert(said.end(), bytes.begin(), bytes.end());
}

}  // namespace haptic_emu
