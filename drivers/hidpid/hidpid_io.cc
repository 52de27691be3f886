#include "drivers/hidpid/hidpid_io.h"

#include <algorithm>
#include <cmath>

namespace hapticd {

using pid::Control;
using pid::Effect;

Result<void> HidPidIo::open(const std::atomic<bool>& stop) {
  (void)speak_.takeBack();
  if (auto opened = hid_->open(); !opened) return opened;
  Result<HidReports> reports = HidReports::parse(hid_->descriptor());
  if (!reports) return reports.error();
  Result<pid::Layout> layout = pid::layoutOf(*reports);
  if (!layout) return layout.error();
  layout->quirks.fixed_direction = setup_.parameters.fixed_direction;
  const Result<pid::Lengths> lengths = pid::lengthsOf(*reports, *layout);
  if (!lengths) return lengths.error();
  layout_ = *layout;
  encoder_ = pid::Encoder(layout_, lengths.value());
  axes_ = {};
  buttons_ = 0;  // What was held before it was unplugged is told again, or held no more.
  fallbacks_ = 0;
  known_ = energised_ = told_on_ = fallen_ = saturated_ = safety_open_ = power_off_ = gone_ = false;
  refusals_ = off_tries_ = 0;
  if (auto prepared = prepare(stop); !prepared) return prepared;
  last_words_ = {encoder_.control(Control::kStopAll), encoder_.control(Control::kDisable)};
  speak_.lend(&last_words_);
  next_ns_ = hid_->now();
  return {};
}

Result<void> HidPidIo::prepare(const std::atomic<bool>& stop) {
  // As the kernel's driver begins, but for the actuators: they stay off until somebody arms.
  say(encoder_.control(Control::kReset));
  say(encoder_.control(Control::kReset));
  say(encoder_.control(Control::kStopAll));
  say(encoder_.control(Control::kDisable));
  say(encoder_.fullGain());
  if (auto still = there(); !still) return still;
  for (std::size_t i = 0; i < layout_.axes; ++i) {
    Result<std::int32_t> block = create(Effect::kConstant, stop);
    if (!block) return block.error();
    axes_[i].block = *block;
    if (!say(encoder_.effect({Effect::kConstant, i, kHold_ms, *block})) && !gone_) {
      return Error{ErrorCode::kUnsupported, setup_.info.uri, "the device does not let its effects be bounded in time",
                   "only devices whose forces end by themselves can be used"};
    }
    tell(axes_[i], 0);
  }
  const double share = setup_.parameters.fallback;
  for (const Effect effect : {Effect::kDamper, Effect::kSpring}) {
    for (std::size_t i = 0; i < layout_.axes && share > 0; ++i) {
      const bool known = layout_.condition_block.there && layout_.positive_coefficient.there &&
                         layout_.effect_type[static_cast<std::size_t>(effect)].there();
      // Without a bound on its force it must not run on its own.
      if (!known || !layout_.positive_saturation.there) continue;
      Result<std::int32_t> block = create(effect, stop);
      if (!block) break;                                                       // No room: then without.
      if (!say(encoder_.effect({effect, i, kFallback_ms, *block}))) continue;  // Nor one without an end.
      if (!say(encoder_.condition({*block, i, 0, share, share}))) continue;    // Nor one without its bound.
      fallback_[fallbacks_++] = {effect, i, *block};
    }
  }
  return there();
}

Result<void> HidPidIo::there() const {
  if (!gone_) return {};
  return Error{ErrorCode::kDeviceGone, setup_.info.uri, "it went, or hung, while it was set up", "plug it in again"};
}

Result<std::int32_t> HidPidIo::create(Effect effect, const std::atomic<bool>& stop) {
  const pid::Report asked = encoder_.create(effect);
  const std::string& where = setup_.info.uri;
  if (asked.bytes().empty() || hid_->setFeature(asked.bytes()) != HidResult::kOk) {
    return Error{ErrorCode::kUnsupported, where, "the device does not make such an effect", ""};
  }
  const std::int64_t give_up_ns = hid_->now() + kHang_ns;
  for (int i = 0; i < kMostLoadTries && hid_->now() < give_up_ns && !stop.load(std::memory_order_relaxed); ++i) {
    std::array<std::uint8_t, pid::Report::kLongest> answer{};
    const pid::Report empty = encoder_.load();
    std::copy(empty.bytes().begin(), empty.bytes().end(), answer.begin());
    std::size_t size = 0;
    if (hid_->getFeature({answer.data(), empty.bytes().size()}, size) != HidResult::kOk || size < 2) continue;
    const std::span<const std::uint8_t> data(answer.data() + 1, size - 1);
    const auto says = [&](const pid::Choice& choice) {
      return choice.there() && extract(choice.field.field, data) == choice.value;
    };
    if (says(layout_.load_full)) {
      return Error{ErrorCode::kQuotaExceeded, where, "the device has no room for another effect",
                   "unplug it and plug it in again; close other programs that use it"};
    }
    if (says(layout_.load_success)) {
      const std::int32_t block = extract(layout_.loaded_block.field, data);
      if (block > 0) return block;
    }
  }
  return Error{ErrorCode::kTimeout, where, "the device does not say where it keeps the effect", "plug it in again"};
}

void HidPidIo::close() noexcept {
  if (speak_.get() != nullptr) {
    say(encoder_.control(Control::kStopAll));
    for (const Axis& axis : axes_) {
      if (axis.block != 0) say(encoder_.stop(axis.block));
    }
    say(encoder_.control(Control::kDisable));
  }
  (void)speak_.takeBack();
  hid_->close();
}

void HidPidIo::safe() noexcept {
  speak_.use([this](const std::array<pid::Report, 2>* words) {
    for (const pid::Report& report : *words) {
      if (!report.bytes().empty()) hid_->lastWords(report.bytes());
    }
  });
}

bool HidPidIo::say(const pid::Report& report) noexcept {
  if (report.bytes().empty() || gone_) return !gone_;  // It has no such thing.
  const std::int64_t before_ns = hid_->now();
  const HidResult result = hid_->write(report.bytes());
  refusals_ = result == HidResult::kOk ? 0 : refusals_ + 1;
  const bool hangs = result == HidResult::kRefused && hid_->now() - before_ns >= kHang_ns;
  gone_ = result == HidResult::kGone || refusals_ >= kRefusalsInARow || hangs;
  return result == HidResult::kOk;
}

void HidPidIo::tell(Axis& axis, double share) noexcept {
  axis.told = say(encoder_.constant(axis.block, share)) ? share : std::nan("");
}

bool HidPidIo::exchange(DeviceLink& link, std::int64_t until_ns) noexcept {
  constexpr int kMostReports = 64;
  std::array<std::uint8_t, HidTransport::kLargestReport> buffer;
  for (int i = 0; i < kMostReports; ++i) {
    std::size_t size = 0;
    const HidResult got = hid_->read(buffer, size, std::min(until_ns, next_ns_));
    if (got == HidResult::kGone) return false;
    if (got != HidResult::kOk) break;
    LinkCounters::add(link.counters.exchanges);
    listen({buffer.data(), size});
  }
  const std::int64_t now_ns = hid_->now();
  if (now_ns < next_ns_) return true;
  next_ns_ = std::max(next_ns_ + kPeriod_ns, now_ns);

  const std::uint64_t stale = link.counters.stale_commands.load(std::memory_order_relaxed);
  link.order(now_ns, [&](const DeviceCommand& command) noexcept {
    if (link.counters.stale_commands.load(std::memory_order_relaxed) != stale) {
      fallBack();
    } else if (!command.enabled) {
      rest(true);
    } else {
      drive(command, now_ns);
    }
    return isQuiet();
  });
  if (known_) publish(now_ns, link);
  return !gone_;
}

void HidPidIo::listen(std::span<const std::uint8_t> report) noexcept {
  const std::uint8_t id = layout_.numbered && !report.empty() ? report[0] : 0;
  const std::span<const std::uint8_t> data = layout_.numbered && !report.empty() ? report.subspan(1) : report;
  const auto has = [&](const pid::Field& field) noexcept {
    return field.there && field.field.report_id == id && field.field.bit_offset + field.field.bits <= 8 * data.size();
  };
  for (std::size_t i = 0; i < layout_.axes; ++i) {
    if (!has(layout_.axis[i])) continue;
    const HidField& field = layout_.axis[i].field;
    const double middle = 0.5 * (static_cast<double>(field.logical_min) + field.logical_max);
    const double half = 0.5 * (static_cast<double>(field.logical_max) - field.logical_min);
    const double at = half > 0 ? (extract(field, data) - middle) / half : 0;
    if (std::abs(at) > 1.01) continue;  // Out of its own range: "no reading".
    axes_[i].position = at;
    known_ = true;
  }
  for (std::size_t i = 0; i < layout_.buttons; ++i) {
    if (!has(layout_.button[i])) continue;
    const bool down = extract(layout_.button[i].field, data) != 0;
    buttons_ = down ? buttons_ | (1u << i) : buttons_ & ~(1u << i);
  }
  if (has(layout_.safety_switch)) safety_open_ = extract(layout_.safety_switch.field, data) == 0;
  if (has(layout_.actuator_power)) power_off_ = extract(layout_.actuator_power.field, data) == 0;
}

void HidPidIo::drive(const DeviceCommand& command, std::int64_t now_ns) noexcept {
  endFallback();
  off_tries_ = 0;
  if (!energised_) told_on_ = say(encoder_.control(Control::kEnable));
  energised_ = true;
  const double sign = setup_.parameters.invert ? -1 : 1;
  std::array<double, pid::kMostAxes> share = {sign * command.force.y() / setup_.parameters.max_force,
                                              sign * command.force.x() / setup_.parameters.max_force};
  double most = 0;
  bool finite = true;
  for (std::size_t i = 0; i < layout_.axes; ++i) {
    most = std::max(most, std::abs(share[i]));
    finite = finite && std::isfinite(share[i]);
  }
  saturated_ = finite && most > 1;
  for (std::size_t i = 0; i < layout_.axes; ++i) {
    Axis& axis = axes_[i];
    const double wanted = !finite ? 0 : saturated_ ? share[i] / most : share[i];
    if (wanted != axis.told) tell(axis, wanted);
    if (!axis.started || now_ns - axis.started_ns >= kHold_ms * 500'000LL) {
      if (!told_on_) told_on_ = say(encoder_.control(Control::kEnable));
      say(encoder_.start(axis.block));
      axis.started = true;
      axis.started_ns = now_ns;
    }
  }
}

/** Of its constant forces it has taken that they are zero, and nothing else pushes. */
bool HidPidIo::isQuiet() const noexcept {
  return !fallen_ && std::all_of(axes_.begin(), axes_.end(), [](const Axis& axis) { return axis.told == 0; });
}

void HidPidIo::rest(bool actuators_off) noexcept {
  saturated_ = false;
  for (std::size_t i = 0; i < layout_.axes; ++i) {
    Axis& axis = axes_[i];
    if (axis.told != 0) tell(axis, 0);
    if (axis.started) say(encoder_.stop(axis.block));
    axis.started = false;
  }
  if (!actuators_off) return;
  endFallback();
  if (energised_) off_tries_ = kOffTries;
  energised_ = false;
  if (off_tries_ > 0) off_tries_ = say(encoder_.control(Control::kDisable)) ? 0 : off_tries_ - 1;
}

void HidPidIo::fallBack() noexcept {
  const bool was_pushing = energised_ && axes_[0].started;
  rest(false);
  if (fallen_ || !was_pushing) return;
  fallen_ = true;
  const double share = setup_.parameters.fallback;
  for (std::size_t i = 0; i < fallbacks_; ++i) {
    const Fallback& kept = fallback_[i];
    const double here = kept.effect == Effect::kSpring ? axes_[kept.axis].position : 0;
    // Of one that it does not take nobody knows where it would pull, nor how strongly.
    if (say(encoder_.condition({kept.block, kept.axis, here, share, share}))) say(encoder_.start(kept.block));
  }
}

void HidPidIo::endFallback() noexcept {
  if (!fallen_) return;
  fallen_ = false;
  for (std::size_t i = 0; i < fallbacks_; ++i) say(encoder_.stop(fallback_[i].block));
}

void HidPidIo::publish(std::int64_t now_ns, DeviceLink& link) noexcept {
  DeviceSample sample;
  sample.t_ns = now_ns;
  // X goes to the right, Y toward the user.
  const double travel = setup_.parameters.travel;
  sample.p = Vec3(layout_.axes > 1 ? travel * axes_[1].position : 0, travel * axes_[0].position, 0);
  sample.buttons = buttons_;
  if (saturated_) sample.status |= kDeviceSaturated;
  if (safety_open_) sample.status |= kDeviceDeadmanOpen;
  if (power_off_ && !safety_open_) sample.status |= kDeviceError;  // Where the switch cuts the power it is no fault.
  link.publish(sample);
}

}  // namespace hapticd
