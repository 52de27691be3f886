#include "drivers/sample/sample_io.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

constexpr double kReach = 0.12;  // [m] each way; a reading beyond it cannot be.

/** The device's axes (right, up, toward the operator) and ours (toward the operator, right, up). */
Vec3 toWorld(const Vec3& v_D) { return {v_D.z(), v_D.x(), v_D.y()}; }
Vec3 toDevice(const Vec3& v_W) { return {v_W.y(), v_W.z(), v_W.x()}; }

}  // namespace

DeviceInfo sampleInfo() {
  DeviceInfo info;
  info.uri = "sample://default";
  info.model = "sample";
  info.manufacturer = "hapticd";
  info.serial = "sample";
  info.driver = "sample";
  info.driver_version = "1";
  info.max_force = 10;
  info.max_stiffness = 2000;
  info.max_damping = 10;
  info.workspace_radius = 0.1;
  info.workspace_lower = Vec3::Constant(-0.1);
  info.workspace_upper = Vec3::Constant(0.1);
  info.max_workspace_lower = Vec3::Constant(-kReach);
  info.max_workspace_upper = Vec3::Constant(kReach);
  info.position_resolution = sample::kMetresPerCount;
  info.force_resolution = 1e-3;
  info.native_rate_hz = 1000;
  info.latency_s = 0.001;
  info.buttons = 2;
  info.has_watchdog = true;
  return info;
}

Result<void> SampleIo::open(const std::atomic<bool>&) {
  auto usb = open_usb_();
  if (!usb) return usb.error();
  usb_ = std::move(*usb);
  live_.lend(usb_.get());
  gone_ = answered_ = saturated_ = not_taken_ = false;
  unasked_ = 0;
  under_way_ = 0;
  heard_ns_ = sent_ns_ = clock_.now();
  // Two requests wait for a reading at any time, so that none is missed between two calls.
  for (int i = 0; i < 2; ++i) (void)usb_->postIn();
  return {};
}

void SampleIo::close() noexcept {
  (void)live_.takeBack();
  if (!usb_) return;
  if (!gone_) usb_->sendNow(sample::encode({}));
  usb_.reset();
}

void SampleIo::safe() noexcept {
  live_.use([](UsbTransport* usb) { usb->sendNow(sample::encode({})); });
}

bool SampleIo::exchange(DeviceLink& link, std::int64_t until_ns) noexcept {
  link_ = &link;
  while (!gone_ && clock_.now() < until_ns) {
    if (clock_.now() - heard_ns_ >= kSilent_ns) gone_ = true;
    // An order for each reading; and one without, should it be silent, so that what it holds is zero.
    if (answered_ || clock_.now() - sent_ns_ >= kTrust_ns) {
      if (!answered_) LinkCounters::add(link.counters.lost);
      answered_ = false;
      sent_ns_ = clock_.now();
      for (; unasked_ > 0; --unasked_) {
        if (usb_->postIn() == UsbStatus::kGone) gone_ = true;
      }
      // What is under way, or has failed, the device has not got: only zeros that it has are off.
      if (under_way_ > 0 || not_taken_) link.notTaken();
      not_taken_ = false;
      link.order(sent_ns_, [this](const DeviceCommand& command) noexcept {
        const UsbStatus posted = usb_->postOut(sample::encode(orderFor(command)));
        if (posted == UsbStatus::kGone) gone_ = true;
        if (posted == UsbStatus::kOk) ++under_way_;
        return posted == UsbStatus::kOk;
      });
    }
    usb_->poll(std::min(until_ns, sent_ns_ + kTrust_ns), *this);
  }
  link_ = nullptr;
  return !gone_;
}

void SampleIo::onIn(UsbStatus status, std::span<const std::uint8_t> bytes) noexcept {
  if (status == UsbStatus::kError || status == UsbStatus::kStall) {
    ++unasked_;
    return;
  }
  if (status == UsbStatus::kGone || usb_->postIn() == UsbStatus::kGone) {
    gone_ = true;
    return;
  }
  const auto reading = sample::decode(bytes);
  if (!reading) {
    LinkCounters::add(link_->counters.dropped_bytes, bytes.size());
    return;
  }
  const Vec3 p_D = sample::kMetresPerCount * Vec3(reading->position[0], reading->position[1], reading->position[2]);
  if (p_D.cwiseAbs().maxCoeff() > kReach) {
    LinkCounters::add(link_->counters.rejected);
    return;
  }
  heard_ns_ = clock_.now();
  if (!answered_) link_->round_trip.record(heard_ns_ - sent_ns_);
  answered_ = true;
  LinkCounters::add(link_->counters.exchanges);
  DeviceSample sample;
  sample.t_ns = heard_ns_;
  sample.p = toWorld(p_D);
  sample.buttons = reading->buttons;
  sample.status = saturated_ ? kDeviceSaturated : kDeviceOk;
  link_->publish(sample);
}

void SampleIo::onOut(UsbStatus status) noexcept {
  if (status == UsbStatus::kGone) gone_ = true;
  --under_way_;
  not_taken_ = not_taken_ || status != UsbStatus::kOk;
}

sample::Order SampleIo::orderFor(const DeviceCommand& command) noexcept {
  sample::Order order;
  order.number = ++number_;
  saturated_ = false;
  if (!command.enabled || !command.force.allFinite() || clock_.now() - heard_ns_ > kTrust_ns) return order;
  // All three together, so that the direction stays.
  const double largest_mN = 1000 * command.force.cwiseAbs().maxCoeff();
  saturated_ = largest_mN > sample::kMost_mN;
  const Vec3 force_mN = toDevice(command.force) * (saturated_ ? 1000 * (sample::kMost_mN / largest_mN) : 1000);
  for (int i = 0; i < 3; ++i) {
    order.force_mN[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(std::lround(force_mN[i]));
  }
  order.lights = sample::kEnable;
  return order;
}

}  // namespace hapticd
