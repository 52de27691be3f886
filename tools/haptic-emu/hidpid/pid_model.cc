#include "tools/haptic-emu/hidpid/pid_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace haptic_emu {
namespace {

constexpr int kConstant = 1, kSpring = 8, kDamper = 9;

int word(std::span<const std::uint8_t> d, std::size_t at) { return d[at] + 256 * d[at + 1]; }
int signedWord(std::span<const std::uint8_t> d, std::size_t at) {
  const int w = word(d, at);
  return w > 32767 ? w - 65536 : w;
}

}  // namespace

PidModel::PidModel(const PidVariant& variant)
    : hand(HandParameters{}), variant_(variant), descriptor_(pidDescriptor(variant)) {
  forget();
}

void PidModel::forget() {
  effects_.clear();
  actuators_ = !variant_.switches;
  new_block_ = 0;
  load_status_ = 3;
  sent_buttons_ = held_buttons_ = 0;
}

void PidModel::advance(std::int64_t t_ns) {
  now_ns_ = std::max(now_ns_, t_ns);
  if (!plugged()) {
    forget();
    queue_.clear();
    stepped_ns_ = next_ns_ = now_ns_;
    return;
  }
  for (; stepped_ns_ + Hand::kStep_ns <= now_ns_; stepped_ns_ += Hand::kStep_ns) {
    hand.step(force());
    velocity_ = (hand.position() - last_position_) / (static_cast<double>(Hand::kStep_ns) * 1e-9);
    last_position_ = hand.position();
  }
  pullTriggers();
  for (; next_ns_ <= now_ns_; next_ns_ += 1'000'000) {
    if (faults.active(FaultKind::kSilence, now_ns_)) continue;
    Bytes report = {1, buttons};
    if (variant_.buttons_apart) {
      if (std::exchange(sent_buttons_, buttons) != buttons) queue_.push_back(report);
      report = {kAxesApart};
    }
    for (int a = 0; a < variant_.axes; ++a) {
      const double at = (a == 0 ? hand.position().y() : hand.position().x()) / kTravel;
      const int counts = static_cast<int>(std::lround(32767 * std::clamp(at, -1.0, 1.0)));
      report.push_back(static_cast<std::uint8_t>(counts & 0xff));
      report.push_back(static_cast<std::uint8_t>((counts >> 8) & 0xff));
    }
    if (faults.active(FaultKind::kTruncation, now_ns_)) report.resize(3);
    queue_.push_back(std::move(report));
    if (queue_.size() > 64) queue_.pop_front();
  }
}

/** A button that goes down starts the effects that have it for their trigger. */
void PidModel::pullTriggers() {
  const unsigned down = buttons & ~unsigned{held_buttons_};
  held_buttons_ = buttons;
  for (auto& [block, e] : effects_) {
    const bool pulled = e.trigger >= 1 && e.trigger <= 8 && (down >> (e.trigger - 1) & 1u) != 0;
    if (pulled) e.ends_ns = now_ns_ + e.duration_ms * 1'000'000;
  }
}

Vec3 PidModel::force() const {
  if (!actuators_ || !power_ || !safety_) return Vec3::Zero();
  // Shares of the full force along X (right) and Y (toward the user).
  std::array<double, 2> share{};
  const std::array<double, 2> place = {hand.position().y() / kTravel, hand.position().x() / kTravel};
  const std::array<double, 2> speed = {velocity_.y(), velocity_.x()};  // full at 1 m/s
  for (const auto& [block, e] : effects_) {
    if (e.ends_ns < now_ns_) continue;
    if (e.type == kConstant) {
      const double angle = e.degrees * std::numbers::pi / 180;
      if (e.axes & 1) share[0] += e.gain * e.magnitude * std::sin(angle);
      if (e.axes & 2) share[1] -= e.gain * e.magnitude * std::cos(angle);
      continue;
    }
    for (std::size_t a = 0; a < 2; ++a) {
      if ((e.axes >> a & 1) == 0) continue;
      const double of = e.type == kSpring ? place[a] - e.centre[a] : speed[a];
      share[a] -= std::clamp(e.gain * e.coefficient[a] * of, -e.saturation[a], e.saturation[a]);
    }
  }
  for (double& s : share) s = std::clamp(s, -1.0, 1.0);
  return kFullForce * Vec3(share[1], share[0], 0);
}

int PidModel::running(int type) const {
  return static_cast<int>(std::count_if(effects_.begin(), effects_.end(), [&](const auto& e) {
    return e.second.type == type && e.second.ends_ns >= now_ns_;
  }));
}

// block, type, duration, repeat, sample, (delay), gain, button, axes, two directions
bool PidModel::setEffect(std::span<const std::uint8_t> d) {
  const std::size_t delay = variant_.start_delay ? 2 : 0;
  if (d.size() != 13 + delay || !effects_.contains(d[0])) return false;
  PlayedEffect& e = effects_[d[0]];
  e.type = d[1];
  e.duration_ms = std::llround(word(d, 2) * std::pow(10, 3 + variant_.time_exponent));
  longest_ms_ = std::max(longest_ms_, e.duration_ms);
  e.gain = d[8 + delay] / 255.0;
  e.trigger = d[9 + delay];
  e.axes = d[10 + delay] & ((1 << variant_.axes) - 1);
  e.degrees = d[11 + delay] * 360.0 / 255;
  return true;
}

bool PidModel::setCondition(std::span<const std::uint8_t> d) {
  const std::size_t bytes = 5 + (variant_.block_offset ? 1u : 0u) + (variant_.negative_coefficient ? 2u : 0u) +
                            (variant_.saturation ? 4u : 0u) + (variant_.dead_band ? 2u : 0u);
  if (d.size() != bytes || !effects_.contains(d[0])) return false;
  PlayedEffect& e = effects_[d[0]];
  std::size_t at = 1;
  std::size_t axis = (e.axes & 1) != 0 ? 0 : 1;
  if (variant_.block_offset) axis = d[at++] & 1;
  e.centre[axis] = signedWord(d, at) / 10000.0;
  e.coefficient[axis] = signedWord(d, at + 2) / 10000.0;
  at += 4;
  if (variant_.negative_coefficient) at += 2;
  e.saturation[axis] = 1;
  if (variant_.saturation) e.saturation[axis] = word(d, at) / 10000.0;
  return true;
}

void PidModel::control(int order) {
  const auto stopAll = [&] {
    for (auto& [block, e] : effects_) e.ends_ns = -1;
  };
  if (order == 1) actuators_ = true;
  if (order == 2) actuators_ = false;
  if (order == 3) stopAll();
  if (order == 4) forget();
  tellState();
}

bool PidModel::out(std::span<const std::uint8_t> report) {
  if (report.empty() || report[0] == refused) return false;
  const std::span<const std::uint8_t> d = report.subspan(1);
  switch (report[0]) {
    case 1:
      return setEffect(d);
    case 3:
      return setCondition(d);
    case 5:
      if (d.size() != 3 || !effects_.contains(d[0])) return false;
      ++constants_;
      effects_[d[0]].magnitude = signedWord(d, 1) / 10000.0;
      return true;
    case 10:
      if (d.size() != 3 || !effects_.contains(d[0])) return false;
      if (d[1] == 1) effects_[d[0]].ends_ns = now_ns_ + effects_[d[0]].duration_ms * 1'000'000;
      if (d[1] == 3) effects_[d[0]].ends_ns = -1;
      return true;
    case 11:
      return d.size() == 1 && effects_.erase(d[0]) == 1;
    case 12:
      if (d.size() != 1) return false;
      for (int order = 1; order <= 6; ++order) {
        if (variant_.control_in_bits ? (d[0] >> (order - 1) & 1) != 0 : d[0] == order) control(order);
      }
      return true;
    case 13:
      return d.size() == 1;
    default:
      return false;
  }
}

bool PidModel::setFeature(std::span<const std::uint8_t> report) {
  if (report.size() != 4 || report[0] != 5) return false;
  polls_left_ = busy_polls;
  if (static_cast<int>(effects_.size()) >= variant_.pool) {
    load_status_ = 2;
    return true;
  }
  new_block_ = 1;
  while (effects_.contains(new_block_)) ++new_block_;
  effects_[new_block_].type = report[1];
  load_status_ = 1;
  return true;
}

std::optional<HidModel::Bytes> PidModel::getFeature(std::uint8_t id) {
  if (id != 6) return std::nullopt;
  const bool yet = polls_left_-- <= 0;
  return Bytes{6, static_cast<std::uint8_t>(yet && load_status_ == 1 ? new_block_ : 0),
               static_cast<std::uint8_t>(yet ? load_status_ : 0), 0, 0};
}

std::optional<HidModel::Bytes> PidModel::in() {
  if (queue_.empty()) return std::nullopt;
  Bytes report = std::move(queue_.front());
  queue_.pop_front();
  return report;
}

void PidModel::tellState() {
  const int bits = (actuators_ ? 2 : 0) + (safety_ ? 4 : 0) + 8 + (power_ ? 16 : 0);
  queue_.push_back({2, static_cast<std::uint8_t>(bits), 0});
}

void PidModel::holdSafetySwitch(bool held) {
  safety_ = held;
  tellState();
}

void PidModel::power(bool on) {
  power_ = on;
  tellState();
}

}  // namespace haptic_emu
