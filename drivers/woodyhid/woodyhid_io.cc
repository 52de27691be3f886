#include "drivers/woodyhid/woodyhid_io.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "drivers/hid/report_descriptor.h"
#include "drivers/link/shortened.h"

namespace hapticd {

Result<void> WoodyIo::open(const std::atomic<bool>& stop) {
  if (auto opened = hid_->open(); !opened) return opened;
  // 14 bytes of the first boards, 64 of a Teensy: what the device says it takes.
  const Result<HidReports> reports = HidReports::parse(hid_->descriptor());
  const std::size_t declared = reports ? reports->reportBytes(HidKind::kOutput, 0) : 0;
  report_bytes_.store(1 + std::clamp(declared, woodyhid::kReportBytes, woodyhid::kTeensyReportBytes));
  plugged_ = setup_.counters->of(hid_->plugged());
  const bool counts = setup_.parameters.calibrated && !plugged_->lost.load();
  calibration_.store(counts ? Calibration::kDone : Calibration::kNeeded);
  may_press_ = calibrating_ = saturated_ = asked_ = false;
  check_.forget();
  still_ = 0;

  const std::int64_t give_up_ns = hid_->now() + kFirstWord_ns;
  taken_ns_ = hid_->now();
  while (!stop.load(std::memory_order_relaxed) && hid_->now() < give_up_ns) {
    if (send(woodyhid::encodeCurrents({})) == HidResult::kGone) break;
    std::array<std::uint8_t, HidTransport::kLargestReport> buffer{};
    std::size_t size = 0;
    const HidResult got = readNewest(*hid_, buffer, size, sent_ns_ + kKick_ns);
    if (got == HidResult::kGone) break;
    if (got != HidResult::kOk || !woodyhid::decode({buffer.data(), size})) continue;
    return {};
  }
  return Error{ErrorCode::kTimeout, setup_.info.uri, "the device does not answer as WoodenHaptics or Polhem do",
               "is it one? Other things made of such a board have the same USB IDs; name yours by serial= or path="};
}

void WoodyIo::close() noexcept {
  const std::int64_t give_up_ns = hid_->now() + kKick_ns;  // One that hangs refuses after seconds.
  for (int i = 0; i < kZeros && hid_->now() < give_up_ns; ++i) {
    if (send(woodyhid::encodeCurrents({})) != HidResult::kRefused) break;
  }
  hid_->close();
  calibration_.store(Calibration::kNeeded);
}

void WoodyIo::safe() noexcept {
  const woodyhid::Report zero = woodyhid::encodeCurrents({});
  hid_->lastWords({zero.data(), report_bytes_.load()});
}

HidResult WoodyIo::send(const woodyhid::Report& report) noexcept {
  sent_ns_ = hid_->now();
  asked_ = true;
  const HidResult result = hid_->write({report.data(), report_bytes_.load()});
  if (result == HidResult::kOk) taken_ns_ = sent_ns_;
  return result;
}

void WoodyIo::countsLost() noexcept {
  calibration_.store(Calibration::kNeeded);
  plugged_->lost.store(true);
}

bool WoodyIo::exchange(DeviceLink& link, std::int64_t until_ns) noexcept {
  const bool there = talk(link, until_ns);
  if (!there) countsLost();  // For whoever opens it next, too.
  return there;
}

bool WoodyIo::talk(DeviceLink& link, std::int64_t until_ns) noexcept {
  std::array<std::uint8_t, HidTransport::kLargestReport> buffer;
  std::size_t size = 0;
  const HidResult got = readNewest(*hid_, buffer, size, std::min(until_ns, sent_ns_ + kKick_ns));
  if (got == HidResult::kGone) return false;
  const std::int64_t now_ns = hid_->now();
  if (got != HidResult::kOk) {
    if (now_ns - sent_ns_ < kKick_ns) return true;  // The time is up, not the patience.
    LinkCounters::add(link.counters.lost);
    return reply(nullptr, now_ns, link);
  }
  const auto reading = woodyhid::decode({buffer.data(), size});
  if (!reading) {
    LinkCounters::add(link.counters.dropped_bytes, size);
  } else {
    LinkCounters::add(link.counters.exchanges);
    if (asked_) link.round_trip.record(now_ns - sent_ns_);
    asked_ = false;
    still_ = reading->encoder == heard_ ? still_ + 1 : 0;
    heard_ = reading->encoder;
    take(*reading, now_ns, link);
  }
  return reply(reading ? &*reading : nullptr, now_ns, link);
}

/** Of the motor that turned most, in counts. */
double WoodyIo::movedTo(const woodyhid::Reading& reading) const noexcept {
  int most = 0;
  for (std::size_t i = 0; i < 3; ++i) most = std::max(most, std::abs(reading.encoder[i] - last_.encoder[i]));
  return most;
}

void WoodyIo::take(const woodyhid::Reading& reading, std::int64_t now_ns, DeviceLink& link) noexcept {
  if (calibrating_ && !reading.calibrate) {
    calibrating_ = false;
    check_.forget();
    plugged_->lost.store(false);
    calibration_.store(Calibration::kDone);
  }
  if (calibration_.load() != Calibration::kDone) return;
  const Vec3 angles = woodyAngles(*setup_.model, reading.encoder);
  const WoodyArm arm = solveWoodyArm(*setup_.model, angles);
  const ReadingCheck::Verdict verdict = check_.judge(arm.reachable, movedTo(reading), now_ns);
  if (verdict != ReadingCheck::Verdict::kBelieved) {
    LinkCounters::add(link.counters.rejected);
    if (verdict == ReadingCheck::Verdict::kDropped) return;
    // Counts were lost, or it was not calibrated where it should have been.
    countsLost();
    link.publishStatus(kDeviceError);
    return;
  }
  arm_ = arm;
  last_ = reading;
  publish(reading, now_ns, link);
}

void WoodyIo::publish(const woodyhid::Reading& reading, std::int64_t now_ns, DeviceLink& link) noexcept {
  DeviceSample sample;
  sample.t_ns = now_ns;
  sample.p = arm_.p;
  sample.q = woodyOrientation(*setup_.model, woodyAngles(*setup_.model, reading.encoder), arm_.pitch, reading.encoder);
  double weight = 0;
  for (const LinkMass& link_mass : setup_.model->masses) weight += 9.81 * link_mass.mass;
  sample.gravity = setup_.parameters.gravity * forceForTorque(arm_, arm_.gravity_torque, weight);
  sample.buttons = reading.button ? 1 : 0;
  sample.status = saturated_ ? kDeviceSaturated : kDeviceOk;
  link.publish(sample);
}

bool WoodyIo::reply(const woodyhid::Reading* reading, std::int64_t now_ns, DeviceLink& link) noexcept {
  HidResult sent = HidResult::kGone;
  link.order(now_ns, [&](const DeviceCommand& command) noexcept {
    sent = send(answer(reading, command, now_ns));
    return sent == HidResult::kOk;
  });
  if (sent == HidResult::kRefused) LinkCounters::add(link.counters.lost);  // Told again when it has been silent.
  return sent == HidResult::kOk || (sent == HidResult::kRefused && hid_->now() - taken_ns_ < kRefusing_ns);
}

woodyhid::Report WoodyIo::answer(const woodyhid::Reading* reading, const DeviceCommand& command,
                                 std::int64_t now_ns) noexcept {
  if (reading != nullptr && !reading->calibrate && !command.enabled) may_press_ = true;
  if (command.enabled) {
    may_press_ = false;
    // The arm may have left its pose before the counters were heard.
    if (calibrating_) countsLost();
    calibrating_ = false;
  }
  if (reading != nullptr && reading->calibrate && !command.enabled) {
    if (calibrating_ && ++deaf_ < kDeaf) return woodyhid::encodeCurrents({});
    std::array<std::int16_t, 6> counts = setup_.model->calibration;
    if (may_press_ || calibrating_) {
      calibrating_ = true;
      deaf_ = 0;
      plugged_->lost.store(true);  // Until they are heard.
      calibration_.store(Calibration::kRunning);
    } else if (calibration_.load() == Calibration::kDone && still_ < kStill) {
      return woodyhid::encodeCurrents({});  // Of a moving arm these counts are old when they are heard.
    } else {
      for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = static_cast<std::int16_t>(reading->encoder[i]);
    }
    may_press_ = false;
    return woodyhid::encodeCounters(counts);
  }
  const bool trusted = calibration_.load() == Calibration::kDone && check_.trusted(now_ns, kTrust_ns);
  saturated_ = false;
  if (!command.enabled || !trusted) return woodyhid::encodeCurrents({});
  const Vec3 force = shortened(command.force, setup_.info.max_force, saturated_);
  const WoodyCurrents currents = woodyCurrents(*setup_.model, arm_, force, setup_.parameters.max_current);
  saturated_ = saturated_ || currents.saturated;
  return woodyhid::encodeCurrents(currents.mA);
}

}  // namespace hapticd
