#include "tools/haptic-emu/in_process_hid.h"

#include <algorithm>

namespace haptic_emu {

using hapticd::ErrorCode;
using hapticd::HidResult;

namespace {

/** The world goes on in such steps while a driver waits. */
constexpr std::int64_t kHidStep_ns = 125'000;

/** hidraw takes a leading 0 off: such a device numbers no reports. */
std::span<const std::uint8_t> onTheWire(std::span<const std::uint8_t> report) {
  return !report.empty() && report[0] == 0 ? report.subspan(1) : report;
}

}  // namespace

bool InProcessHid::there() noexcept {
  model_.advance(clock_.now());
  return open_ && model_.plugged();
}

hapticd::Result<void> InProcessHid::open() {
  model_.advance(clock_.now());
  if (!model_.plugged()) return hapticd::Error{ErrorCode::kNotFound, "played device", "it is unplugged", "plug it in"};
  open_ = true;
  return {};
}

HidResult InProcessHid::read(std::span<std::uint8_t> buffer, std::size_t& size, std::int64_t until_ns) noexcept {
  while (there()) {
    if (const auto report = model_.in()) {
      size = std::min(report->size(), buffer.size());
      std::copy_n(report->begin(), size, buffer.begin());
      return size != 0 ? HidResult::kOk : HidResult::kNothing;
    }
    if (clock_.now() >= until_ns) return HidResult::kNothing;
    clock_.sleepUntil(std::min(until_ns, clock_.now() + kHidStep_ns));
  }
  return HidResult::kGone;
}

HidResult InProcessHid::write(std::span<const std::uint8_t> report) noexcept {
  if (!there()) return HidResult::kGone;
  return model_.out(onTheWire(report)) ? HidResult::kOk : HidResult::kRefused;
}

HidResult InProcessHid::setFeature(std::span<const std::uint8_t> report) noexcept {
  if (!there()) return HidResult::kGone;
  return model_.setFeature(onTheWire(report)) ? HidResult::kOk : HidResult::kRefused;
}

HidResult InProcessHid::getFeature(std::span<std::uint8_t> buffer, std::size_t& size) noexcept {
  if (!there() || buffer.empty()) return HidResult::kGone;
  const auto report = model_.getFeature(buffer[0]);
  if (!report) return HidResult::kRefused;
  size = std::min(report->size(), buffer.size());
  std::copy_n(report->begin(), size, buffer.begin());
  return HidResult::kOk;
}

}  // namespace haptic_emu
