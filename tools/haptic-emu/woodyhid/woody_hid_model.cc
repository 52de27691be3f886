#include "tools/haptic-emu/woodyhid/woody_hid_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptic_emu {
namespace {

void put(HidModel::Bytes& report, std::size_t field, int value) {
  const unsigned word = static_cast<unsigned>(value) % 0x10000u;
  report[2 * field] = static_cast<std::uint8_t>(word % 0x100u);
  report[2 * field + 1] = static_cast<std::uint8_t>(word / 0x100u);
}

std::int16_t get(std::span<const std::uint8_t> report, std::size_t field) {
  const int word = report[2 * field] + 0x100 * report[2 * field + 1];
  return static_cast<std::int16_t>(word >= 0x8000 ? word - 0x10000 : word);
}

}  // namespace

WoodyHidModel::WoodyHidModel(WoodyKind kind, std::uint8_t report_bytes)
    : hand({}), kind_(kind), report_bytes_(report_bytes) {
  // A vendor's page, one application, bytes in and bytes out.
  descriptor_ = {0x06, 0xab, 0xff,         0x0a, 0x00, 0x02, 0xa1, 0x01, 0x75,         0x08, 0x15, 0x00, 0x26, 0xff,
                 0x00, 0x95, report_bytes, 0x09, 0x01, 0x81, 0x02, 0x95, report_bytes, 0x09, 0x02, 0x91, 0x02, 0xc0};
}

void WoodyHidModel::advance(std::int64_t t_ns) {
  now_ns_ = std::max(now_ns_, t_ns);
  if (!plugged()) {
    powered_ = false;
    amplifiers_ = pressed_ = false;
    waiting_ = true;
    queue_.clear();
    waits_.clear();
    stepped_ns_ = now_ns_;
    return;
  }
  if (!powered_) {
    powered_ = true;
    ++pluggings_;
    const Vec3 counts = woodyCounts(kind_, woodyJoints(kind_, hand.position()));
    for (int i = 0; i < 3; ++i) zero_[static_cast<std::size_t>(i)] = counts[i];
    heard_ns_ = next_ns_ = stepped_ns_ = now_ns_;
  }
  for (; stepped_ns_ + Hand::kStep_ns <= now_ns_; stepped_ns_ += Hand::kStep_ns) hand.step(force());
  if (now_ns_ - heard_ns_ >= kWatchdog_ns) amplifiers_ = false;
  if (!waiting_ && now_ns_ >= next_ns_) say();
}

Vec3 WoodyHidModel::force() const {
  if (!amplifiers_) return Vec3::Zero();
  return woodyForce(kind_, hand.position(), 1e-3 * Vec3(current_mA_[0], current_mA_[1], current_mA_[2]));
}

std::array<std::int16_t, 6> WoodyHidModel::counters() const {
  std::array<std::int16_t, 6> out{};
  const Vec3 counts = woodyCounts(kind_, woodyJoints(kind_, hand.position()));
  for (std::size_t i = 0; i < 6; ++i) {
    const double exact = i < 3 ? counts[static_cast<int>(i)] : gimbal[i - 3];
    out[i] = static_cast<std::int16_t>(std::lround(exact - zero_[i]));
  }
  if (faults.active(FaultKind::kEncoderJump, now_ns_)) out[1] = static_cast<std::int16_t>(out[1] + 5000);
  return out;
}

void WoodyHidModel::say() {
  waiting_ = true;
  next_ns_ = now_ns_ + kPeriod_ns;
  if (faults.active(FaultKind::kSilence, now_ns_)) return;
  Bytes report(report_bytes_);
  const auto counts = counters();
  for (std::size_t i = 0; i < 6; ++i) put(report, i, counts[i] + (i == 3 && button ? 10'000 : 0));
  put(report, 6, pressed_ ? 1 : 0);
  if (faults.active(FaultKind::kGarbage, now_ns_) && noise_.byte() < 64) {
    for (std::uint8_t& byte : report) byte = noise_.byte();
  }
  if (faults.active(FaultKind::kTruncation, now_ns_) && noise_.byte() < 64) report.resize(1 + noise_.byte() % 13);
  queue_.push_back(std::move(report));
  longest_ = std::max(longest_, queue_.size());
  ++said_;
  if (!waits_.empty()) obey(std::exchange(waits_, {}));
}

std::optional<HidModel::Bytes> WoodyHidModel::in() {
  if (queue_.empty()) return std::nullopt;
  Bytes report = std::move(queue_.front());
  queue_.pop_front();
  return report;
}

bool WoodyHidModel::out(std::span<const std::uint8_t> report) {
  if (report.size() < 14 || report.size() > report_bytes_) return false;
  if (refuses > 0) {
    --refuses;
    return false;
  }
  ++heard_;
  heard_ns_ = now_ns_;
  waiting_ = false;
  if (behind) {
    waits_.assign(report.begin(), report.end());
  } else {
    obey(report);
  }
  return true;
}

void WoodyHidModel::obey(std::span<const std::uint8_t> report) {
  if (get(report, 3) == 1) {
    if (deaf_to_counters > 0) {
      --deaf_to_counters;
      return;
    }
    const Vec3 counts = woodyCounts(kind_, woodyJoints(kind_, hand.position()));
    for (std::size_t i = 0; i < 3; ++i) zero_[i] = counts[static_cast<int>(i)] - get(report, 4 + i);
    for (std::size_t i = 0; i < 3; ++i) zero_[3 + i] = gimbal[i] - get(report, i);
    current_mA_ = {};
    pressed_ = false;
    return;
  }
  amplifiers_ = true;
  for (std::size_t i = 0; i < 3; ++i) current_mA_[i] = get(report, i);
}

}  // namespace haptic_emu
