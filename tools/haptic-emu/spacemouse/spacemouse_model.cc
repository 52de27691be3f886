#include "tools/haptic-emu/spacemouse/spacemouse_model.h"

#include <algorithm>

namespace haptic_emu {
namespace {

void append(HidModel::Bytes& to, int value) {
  const unsigned word = static_cast<unsigned>(value) % 0x10000u;
  to.push_back(static_cast<std::uint8_t>(word % 0x100u));
  to.push_back(static_cast<std::uint8_t>(word / 0x100u));
}

}  // namespace

SpaceMouseModel::SpaceMouseModel(bool new_layout) : new_layout_(new_layout) {
  descriptor_ = {0x05, 0x01, 0x09, 0x08, 0xa1, 0x01,                          // Multi-axis controller
                 0xa1, 0x00, 0x85, 0x01, 0x16, 0xa2, 0xfe, 0x26, 0x5e, 0x01,  // report 1, -350 to 350
                 0x75, 0x10};
  const auto more = [&](std::initializer_list<std::uint8_t> bytes) { descriptor_.insert(descriptor_.end(), bytes); };
  if (new_layout) {
    more({0x95, 0x06, 0x19, 0x30, 0x29, 0x35, 0x81, 0x02, 0xc0});
  } else {
    more({0x95, 0x03, 0x19, 0x30, 0x29, 0x32, 0x81, 0x06, 0xc0});
    more({0xa1, 0x00, 0x85, 0x02, 0x95, 0x03, 0x19, 0x33, 0x29, 0x35, 0x81, 0x06, 0xc0});
  }
  more({0x05, 0x09, 0x85, 0x03, 0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x20, 0x19, 0x01, 0x29, 0x20, 0x81, 0x02});
  more({0x05, 0x08, 0x85, 0x04, 0x09, 0x4b, 0x75, 0x01, 0x95, 0x01, 0x91, 0x02, 0x75, 0x07, 0x91, 0x03, 0xc0});
}

void SpaceMouseModel::advance(std::int64_t t_ns) {
  now_ns_ = std::max(now_ns_, t_ns);
  if (!plugged()) {
    queue_.clear();
    light_ = false;
    next_ns_ = now_ns_;
    return;
  }
  for (; next_ns_ <= now_ns_; next_ns_ += kPeriod_ns) say();
}

void SpaceMouseModel::say() {
  const bool pushed = std::any_of(axes_.begin(), axes_.end(), [](int a) { return a != 0; });
  if (pushed) zeros_left_ = new_layout_ ? 3 : 6;
  if (!pushed && zeros_left_ == 0) return;
  if (!pushed) --zeros_left_;
  if (faults.active(FaultKind::kSilence, now_ns_)) return;
  Bytes report;
  const std::size_t first = new_layout_ || !rotation_next_ ? 0 : 3;
  report.push_back(first == 0 ? 1 : 2);
  for (std::size_t i = first; i < (new_layout_ ? 6u : first + 3u); ++i) append(report, axes_[i]);
  rotation_next_ = !rotation_next_;
  if (faults.active(FaultKind::kTruncation, now_ns_)) report.resize(4);
  queue_.push_back(std::move(report));
  if (queue_.size() > 64) queue_.pop_front();
}

void SpaceMouseModel::press(std::uint32_t buttons) {
  Bytes report = {3};
  for (int i = 0; i < 4; ++i, buttons /= 256) report.push_back(static_cast<std::uint8_t>(buttons % 256));
  queue_.push_back(std::move(report));
}

bool SpaceMouseModel::out(std::span<const std::uint8_t> report) {
  if (report.size() != 2 || report[0] != 4) return false;
  light_ = report[1] == 1;
  return true;
}

std::optional<HidModel::Bytes> SpaceMouseModel::in() {
  if (queue_.empty()) return std::nullopt;
  Bytes report = std::move(queue_.front());
  queue_.pop_front();
  return report;
}

}  // namespace haptic_emu
