#include "drivers/hidpid/pid_reports.h"

#include <algorithm>
#include <cmath>

namespace hapticd::pid {

Report::Report(const HidField& field, std::size_t bytes) noexcept : size_(std::min(bytes, kLongest)) {
  bytes_[0] = field.report_id;
}

void Report::set(const Field& field, std::int32_t value) HD_RT {
  if (field.there && size_ > 1) insert(field.field, value, std::span(bytes_).subspan(1, size_ - 1));
}

void Report::setShare(const Field& field, double share) HD_RT {
  if (!field.there || !std::isfinite(share)) return;
  const double bounded = std::clamp(share, field.field.logical_min < 0 ? -1.0 : 0.0, 1.0);
  const double whole = bounded < 0 ? -static_cast<double>(field.field.logical_min) : field.field.logical_max;
  set(field, static_cast<std::int32_t>(std::lround(bounded * whole)));
}

Result<Lengths> lengthsOf(const HidReports& reports, const Layout& l) {
  const auto length = [&](HidKind kind, const Field& field) -> std::size_t {
    if (!field.there) return 0;
    const std::size_t bytes = reports.reportBytes(kind, field.field.report_id);
    return reports.numbered() ? bytes : bytes + 1;  // Behind a 0 where reports have no ID.
  };
  Lengths n;
  n.effect = length(HidKind::kOutput, l.effect_block);
  n.constant = length(HidKind::kOutput, l.constant_block);
  n.condition = length(HidKind::kOutput, l.condition_block);
  n.operation = length(HidKind::kOutput, l.operation_block);
  for (const Choice& order : l.control) n.control = std::max(n.control, length(HidKind::kOutput, order.field));
  n.gain = length(HidKind::kOutput, l.device_gain);
  n.create = length(HidKind::kFeature, l.new_type[0].field);
  n.load = length(HidKind::kFeature, l.loaded_block);
  for (const std::size_t bytes :
       {n.effect, n.constant, n.condition, n.operation, n.control, n.gain, n.create, n.load}) {
    if (bytes > Report::kLongest) {
      return Error{ErrorCode::kUnsupported, "report descriptor", "a force-feedback report longer than 128 bytes",
                   "such a device is not supported"};
    }
  }
  return n;
}

Report Encoder::effect(const EffectSetting& setting) const HD_RT {
  Report report(l_.effect_block.field, n_.effect);
  report.set(l_.effect_block, setting.block);
  report.set(l_.effect_type[static_cast<std::size_t>(setting.effect)]);
  report.set(l_.duration, static_cast<std::int32_t>(std::lround(l_.duration_per_ms * setting.duration_ms)));
  report.setShare(l_.gain, 1);
  report.set(l_.trigger_repeat, 0);
  report.set(l_.sample_period, 0);
  report.set(l_.start_delay, 0);
  // The trigger button stays 0, below its range, which begins at 1: no button starts it. So the kernel's driver has it.
  report.set(l_.axis_enable[setting.axis], 1);
  report.set(l_.direction_enable, 1);
  // Polar, clockwise from away from the user: X is at 90 degrees, Y (toward the user) at 180.
  const double degrees = l_.quirks.fixed_direction || setting.axis == 0 ? 90 : 180;
  report.setShare(l_.direction[0], degrees / 360);
  return report;
}

Report Encoder::constant(std::int32_t block, double share) const HD_RT {
  Report report(l_.constant_block.field, n_.constant);
  report.set(l_.constant_block, block);
  report.setShare(l_.magnitude, share);
  return report;
}

Report Encoder::condition(const ConditionSetting& setting) const HD_RT {
  Report report(l_.condition_block.field, n_.condition);
  report.set(l_.condition_block, setting.block);
  report.set(l_.block_offset, static_cast<std::int32_t>(setting.axis));
  report.setShare(l_.centre, setting.centre);
  report.setShare(l_.positive_coefficient, setting.coefficient);
  report.setShare(l_.negative_coefficient, setting.coefficient);
  report.setShare(l_.positive_saturation, setting.saturation);
  report.setShare(l_.negative_saturation, setting.saturation);
  report.set(l_.dead_band, 0);
  return report;
}

Report Encoder::start(std::int32_t block) const HD_RT {
  Report report(l_.operation_block.field, n_.operation);
  report.set(l_.operation_block, block);
  report.set(l_.start);
  report.set(l_.loop_count, 1);
  return report;
}

Report Encoder::stop(std::int32_t block) const HD_RT {
  Report report(l_.operation_block.field, n_.operation);
  report.set(l_.operation_block, block);
  report.set(l_.stop);
  return report;
}

Report Encoder::control(Control what) const HD_RT {
  const Choice& choice = l_.control[static_cast<std::size_t>(what)];
  if (!choice.there()) return {};
  Report report(choice.field.field, n_.control);
  report.set(choice);
  return report;
}

Report Encoder::fullGain() const HD_RT {
  if (!l_.device_gain.there) return {};
  Report report(l_.device_gain.field, n_.gain);
  report.setShare(l_.device_gain, 1);
  return report;
}

Report Encoder::create(Effect effect) const HD_RT {
  const Choice& type = l_.new_type[static_cast<std::size_t>(effect)];
  if (!type.there()) return {};
  Report report(type.field.field, n_.create);
  report.set(type);
  return report;
}

Report Encoder::load() const HD_RT { return Report(l_.loaded_block.field, n_.load); }

}  // namespace hapticd::pid
