#include "drivers/spacemouse/spacemouse_io.h"

#include <algorithm>
#include <array>

namespace hapticd {

Result<void> SpaceMouseIo::open(const std::atomic<bool>&) {
  if (auto opened = hid_->open(); !opened) return opened;
  state_ = {};
  pose_.reset();
  published_ns_ = hid_->now();
  (void)hid_->write(spacemouse::encodeLight(true));  // Some have no light.
  return {};
}

void SpaceMouseIo::close() noexcept {
  (void)hid_->write(spacemouse::encodeLight(false));
  hid_->close();
}

bool SpaceMouseIo::exchange(DeviceLink& link, std::int64_t until_ns) noexcept {
  std::array<std::uint8_t, HidTransport::kLargestReport> buffer;
  std::size_t size = 0;
  switch (hid_->read(buffer, size, std::min(until_ns, published_ns_ + kSample_ns))) {
    case HidResult::kGone:
      return false;
    case HidResult::kOk: {
      // Not only the newest: translation, rotation and buttons come in reports of their own.
      const spacemouse::Report kind = spacemouse::take({buffer.data(), size}, state_);
      if (kind == spacemouse::Report::kNone) LinkCounters::add(link.counters.dropped_bytes, size);
      if (kind != spacemouse::Report::kNone) LinkCounters::add(link.counters.exchanges);
      if (kind == spacemouse::Report::kBattery) battery_.store(state_.battery_percent, std::memory_order_relaxed);
      break;
    }
    case HidResult::kNothing:
    case HidResult::kRefused:
      break;
  }
  link.order(hid_->now(), [](const DeviceCommand&) noexcept {});
  const std::int64_t now_ns = hid_->now();
  if (now_ns - published_ns_ >= kSample_ns) publish(now_ns, link);
  return true;
}

void SpaceMouseIo::publish(std::int64_t now_ns, DeviceLink& link) noexcept {
  const SpaceMouseParameters& p = setup_.parameters;
  // After a pause of the machine the tool has not run away meanwhile.
  const double dt = std::min(static_cast<double>(now_ns - published_ns_) * 1e-9, 0.05);
  published_ns_ = now_ns;
  pose_.step(capDeflection(state_, p.dead_zone), dt);
  DeviceSample sample;
  sample.t_ns = now_ns;
  sample.p = pose_.pose().p;
  sample.q = pose_.pose().q;
  sample.buttons = state_.buttons;
  const bool held = p.deadman == 0 || (state_.buttons >> (p.deadman - 1) & 1u) != 0;
  sample.status = held ? kDeviceOk : kGroupDeadmanOpen;
  link.publish(sample);
}

}  // namespace hapticd
