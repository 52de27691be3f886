#include "drivers/falcon/falcon_io.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "drivers/falcon/falcon_boot.h"

namespace hapticd {
namespace {

/** The device's axes (right, up, toward the operator) and ours (toward the operator, right, up). */
Vec3 toWorld(const Vec3& v_F) { return {v_F.z(), v_F.x(), v_F.y()}; }
Vec3 toFalcon(const Vec3& v_W) { return {v_W.y(), v_W.z(), v_W.x()}; }

}  // namespace

Result<void> FalconIo::open(const std::atomic<bool>& stop) {
  auto usb = setup_.open_usb();
  if (!usb) return usb.error();
  usb_ = std::move(*usb);
  Result<std::vector<std::uint8_t>> firmware = std::vector<std::uint8_t>{};
  if (setup_.read_firmware) firmware = setup_.read_firmware();
  const std::vector<std::uint8_t> bytes = firmware ? *firmware : std::vector<std::uint8_t>{};
  if (auto booted = falcon::boot(*usb_, clock_, bytes, stop); !booted) {
    // Why it cannot be had matters only where the device asks for it.
    if (!firmware && booted.error().code == ErrorCode::kNotFound) return firmware.error();
    return booted;
  }
  live_.lend(usb_.get());
  gone_ = asked_ = homed_ = not_taken_ = false;
  unasked_ = 0;
  under_way_ = 0;
  parser_ = {};
  dropped_ = 0;
  forget();
  calibration_.store(Calibration::kNeeded);
  heard_ns_ = clock_.now();
  // Those that boot() still has under way go on; these come on top, and each that ends is posted again.
  for (int i = 0; i < 2; ++i) (void)usb_->postIn();
  return {};
}

void FalconIo::close() noexcept {
  (void)live_.takeBack();
  if (!usb_) return;
  for (int i = 0; i < kZeros && !gone_; ++i) usb_->sendNow(falcon::encode({}));
  usb_.reset();
  calibration_.store(Calibration::kNeeded);
}

void FalconIo::safe() noexcept {
  live_.use([](UsbTransport* usb) {
    for (int i = 0; i < kZeros; ++i) usb->sendNow(falcon::encode({}));
  });
}

void FalconIo::forget() noexcept {
  check_.forget();
  saturated_ = false;
  grip_.p = falcon::kMiddle;
}

bool FalconIo::exchange(DeviceLink& link, std::int64_t until_ns) noexcept {
  while (!gone_) {
    const std::int64_t now_ns = clock_.now();
    if (now_ns >= until_ns) return true;
    if (asked_ && now_ns - asked_ns_ >= kAnswer_ns) {
      LinkCounters::add(link.counters.lost);
      asked_ = false;
    }
    if (now_ns - heard_ns_ >= kSilent_ns) return false;
    if (!asked_) sendOrder(link);
    usb_->poll(std::min(until_ns, asked_ns_ + kAnswer_ns), *this);
    falcon::Reading reading;
    while (parser_.next(reading)) take(reading, link);
    LinkCounters::add(link.counters.dropped_bytes, parser_.dropped() - dropped_);
    dropped_ = parser_.dropped();
  }
  return false;
}

void FalconIo::onIn(UsbStatus status, std::span<const std::uint8_t> bytes) noexcept {
  if (status == UsbStatus::kGone) gone_ = true;
  if (gone_) return;
  parser_.feed(falcon::payload(bytes));
  if (status == UsbStatus::kError || status == UsbStatus::kStall) {
    ++unasked_;
  } else if (usb_->postIn() == UsbStatus::kGone) {
    gone_ = true;
  }
}

void FalconIo::onOut(UsbStatus status) noexcept {
  if (status == UsbStatus::kGone) gone_ = true;
  if (under_way_ > 0) --under_way_;  // The first may be boot()'s.
  not_taken_ = not_taken_ || status != UsbStatus::kOk;
}

void FalconIo::sendOrder(DeviceLink& link) noexcept {
  asked_ns_ = clock_.now();
  asked_ = true;
  for (; unasked_ > 0; --unasked_) {
    if (usb_->postIn() == UsbStatus::kGone) gone_ = true;
  }
  if (under_way_ > 0 || not_taken_) link.notTaken();
  not_taken_ = false;
  link.order(asked_ns_, [this](const DeviceCommand& command) noexcept {
    const UsbStatus posted = usb_->postOut(falcon::encode(orderFor(command)));
    if (posted == UsbStatus::kGone) gone_ = true;
    if (posted == UsbStatus::kOk) ++under_way_;
    return posted == UsbStatus::kOk;
  });
}

falcon::Order FalconIo::orderFor(const DeviceCommand& command) noexcept {
  falcon::Order order;
  saturated_ = false;
  order.lights = homed_ ? falcon::kBlue : falcon::kRed | falcon::kHome;
  const bool trusted = homed_ && check_.bad() < kFewBad && check_.trusted(clock_.now(), kTrust_ns);
  if (!command.enabled || !trusted) return order;
  auto torques = falcon::torquesFor(grip_.dt1_dp, toFalcon(command.force));
  if (!torques) return order;
  order.lights = falcon::kGreen;
  *torques *= -setup_.parameters.counts_per_nm;
  saturated_ = falcon::limitTogether(*torques, falcon::kMostCounts);
  for (int i = 0; i < 3; ++i) {
    order.motor[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(std::lround((*torques)[i]));
  }
  return order;
}

/** Of the arm that moved most, in counts. */
double FalconIo::movedTo(const falcon::Reading& reading) const noexcept {
  int most = 0;
  for (std::size_t i = 0; i < 3; ++i) most = std::max(most, std::abs(reading.encoder[i] - last_.encoder[i]));
  return most;
}

void FalconIo::take(const falcon::Reading& reading, DeviceLink& link) noexcept {
  const std::int64_t now_ns = clock_.now();
  heard_ns_ = now_ns;
  LinkCounters::add(link.counters.exchanges);
  if (asked_) link.round_trip.record(now_ns - asked_ns_);
  asked_ = false;
  if (reading.allHomed() != homed_) {
    // Homed now: the origin has jumped. Not homed any more: the device has restarted under our hands.
    if (homed_) link.publishStatus(kDeviceError);
    homed_ = reading.allHomed();
    forget();
  }
  calibration_.store(homed_ ? Calibration::kDone : Calibration::kNeeded);
  if (!homed_) return;

  const Vec3 counts(reading.encoder[0], reading.encoder[1], reading.encoder[2]);
  const Vec3 t1 = counts.unaryExpr([](double c) { return falcon::armAngle(c); });
  const auto grip = falcon::gripAt(t1, grip_.p);
  const ReadingCheck::Verdict verdict = check_.judge(grip.has_value(), movedTo(reading), now_ns);
  if (verdict != ReadingCheck::Verdict::kBelieved) {
    LinkCounters::add(link.counters.rejected);
    if (verdict == ReadingCheck::Verdict::kDropped) return;
    link.publishStatus(kDeviceError);
    forget();
    return;
  }
  grip_ = *grip;
  last_ = reading;
  DeviceSample sample;
  sample.t_ns = now_ns;
  sample.p = toWorld(grip_.p - Vec3(0, 0, setup_.parameters.centre_z));
  sample.buttons = reading.buttons;
  sample.status = saturated_ ? kDeviceSaturated : kDeviceOk;
  link.publish(sample);
}

}  // namespace hapticd
