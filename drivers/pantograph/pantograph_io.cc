#include "drivers/pantograph/pantograph_io.h"

#include <algorithm>
#include <cmath>

#include "drivers/link/shortened.h"

namespace hapticd {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180;
using pantograph::Vec2;

/** Seen by the operator the device's x goes to the left, its y toward them. */
Vec3 toWorld(const Vec2& v_D) { return {v_D.y(), -v_D.x(), 0}; }
Vec2 toDevice(const Vec3& v_W) { return {-v_W.y(), v_W.x()}; }

}  // namespace

Result<void> PantographIo::open(const std::atomic<bool>& stop) {
  if (auto opened = line_->open(); !opened) {
    if (opened.error().code == ErrorCode::kNotFound) stalled_ = unanswered_ = false;
    return opened;
  }
  if (!unanswered_) there_ns_ = line_->now();
  open_ = unanswered_ = true;
  asked_ = saturated_ = false;
  check_.forget();
  parser_.reset();
  dropped_ = parser_.dropped();
  const auto counts = static_cast<float>(setup_.parameters.counts_per_turn);
  const bool clockwise = setup_.parameters.clockwise;
  const std::array<pantograph::Encoder, 2> encoders = {{{180, counts, clockwise}, {0, counts, clockwise}}};
  bool told = line_->write(pantograph::encodeReset()) && line_->write(pantograph::encodeSetup(encoders, clockwise));
  const std::int64_t give_up_ns = line_->now() + kFirstWord_ns;
  while (told && !stop.load(std::memory_order_relaxed) && line_->now() < give_up_ns) {
    told = line_->write(pantograph::encodeTorques({}));
    std::array<std::uint8_t, 64> buffer{};
    for (const std::int64_t until_ns = line_->now() + kAnswer_ns; told && line_->now() < until_ns;) {
      std::size_t size = 0;
      told = line_->read(buffer, size, until_ns);
      parser_.feed({buffer.data(), size});
      if (!parser_.next()) continue;
      heard_ns_ = next_ns_ = line_->now();
      stalled_ = stalled_ || heard_ns_ - there_ns_ > kArmsHeld_ns;
      unanswered_ = false;
      calibration_.store(stalled_ ? Calibration::kNeeded : Calibration::kDone);
      return {};
    }
  }
  return Error{ErrorCode::kTimeout, setup_.info.uri, "the board does not answer as a two-motor Haply board does",
               "is it the right tty? ls -l /dev/serial/by-id names them"};
}

void PantographIo::close() noexcept {
  for (int i = 0; i < kZeros && open_; ++i) (void)line_->write(pantograph::encodeTorques({}));
  open_ = false;
  line_->close();
  calibration_.store(Calibration::kNeeded);
}

void PantographIo::safe() noexcept {
  for (int i = 0; i < kZeros; ++i) line_->lastWords(pantograph::encodeTorques({}));
}

bool PantographIo::listen(DeviceLink& link, std::int64_t until_ns) noexcept {
  std::array<std::uint8_t, 256> buffer;
  std::size_t size = 0;
  if (!line_->read(buffer, size, until_ns)) return false;
  parser_.feed({buffer.data(), size});
  while (const auto degrees = parser_.next()) take(*degrees, link);
  LinkCounters::add(link.counters.dropped_bytes, parser_.dropped() - dropped_);
  dropped_ = parser_.dropped();
  return true;
}

bool PantographIo::exchange(DeviceLink& link, std::int64_t until_ns) noexcept {
  // However it went: if its line is there again before anybody can have pulled the plug, nobody has.
  const bool there = talk(link, until_ns);
  stalled_ = stalled_ || !there;
  return there;
}

bool PantographIo::talk(DeviceLink& link, std::int64_t until_ns) noexcept {
  while (line_->now() < until_ns) {
    const std::int64_t due_ns = asked_ ? asked_ns_ + kAnswer_ns : next_ns_;
    if (line_->now() < due_ns && !listen(link, std::min(until_ns, due_ns))) return false;
    const std::int64_t now_ns = line_->now();
    if (now_ns - heard_ns_ >= kSilent_ns) return false;
    if (asked_ && now_ns - asked_ns_ >= kAnswer_ns) {
      LinkCounters::add(link.counters.lost);
      asked_ = false;
      parser_.reset();  // Half an answer would spoil the next.
    }
    if (asked_ || now_ns < next_ns_) continue;
    next_ns_ = std::max(next_ns_ + kPeriod_ns, now_ns);
    asked_ns_ = now_ns;
    asked_ = true;
    bool taken = false;
    link.order(now_ns, [&](const DeviceCommand& command) noexcept {
      taken = line_->write(pantograph::encodeTorques(torquesFor(command, now_ns)));
    });
    if (!taken) return false;
  }
  return true;
}

void PantographIo::take(const std::array<float, pantograph::kJoints>& degrees, DeviceLink& link) noexcept {
  const std::int64_t now_ns = line_->now();
  heard_ns_ = now_ns;
  LinkCounters::add(link.counters.exchanges);
  if (asked_) link.round_trip.record(now_ns - asked_ns_);
  asked_ = false;
  if (calibration_.load() != Calibration::kDone) return;
  float moved_deg = 0;  // The joint that turned most.
  for (std::size_t i = 0; i < pantograph::kJoints; ++i)
    moved_deg = std::max(moved_deg, std::abs(degrees[i] - last_deg_[i]));
  const pantograph::Grip grip = pantograph::gripAt({}, kRadians * Vec2(degrees[0], degrees[1]));
  const ReadingCheck::Verdict verdict = check_.judge(grip.reachable, double{moved_deg}, now_ns);
  if (verdict != ReadingCheck::Verdict::kBelieved) {
    LinkCounters::add(link.counters.rejected);
    if (verdict == ReadingCheck::Verdict::kDropped) return;
    calibration_.store(Calibration::kNeeded);  // Counts were lost. Only setting it up again makes that good.
    link.publishStatus(kDeviceError);
    return;
  }
  grip_ = grip;
  last_deg_ = degrees;
  DeviceSample sample;
  sample.t_ns = now_ns;
  sample.p = toWorld(grip_.p - Vec2(pantograph::Bars{}.d / 2, setup_.parameters.centre));
  sample.status = saturated_ ? kDeviceSaturated : kDeviceOk;
  link.publish(sample);
}

std::array<float, pantograph::kJoints> PantographIo::torquesFor(const DeviceCommand& command,
                                                                std::int64_t now_ns) noexcept {
  saturated_ = false;
  const bool trusted = calibration_.load() == Calibration::kDone && check_.trusted(now_ns, kTrust_ns);
  if (!command.enabled || !trusted) return {};
  const Vec2 force = shortened(toDevice(command.force), setup_.parameters.max_force, saturated_);
  const Vec2 torque = setup_.parameters.torque_scale * (grip_.jacobian.transpose() * force);
  return {static_cast<float>(torque[0]), static_cast<float>(torque[1])};
}

}  // namespace hapticd
