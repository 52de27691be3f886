#include "drivers/hidpid/pid_layout.h"

#include <fmt/format.h>

#include <cmath>

namespace hapticd::pid {
namespace {

constexpr std::uint16_t kPid = 0x0f, kDesktop = 0x01, kButtons = 0x09, kOrdinals = 0x0a;

constexpr HidUsage pidUsage(std::uint16_t usage) { return hidUsage(kPid, usage); }
constexpr HidUsage kSetEffect = pidUsage(0x21), kCondition = pidUsage(0x5f), kConstant = pidUsage(0x73),
                   kOperation = pidUsage(0x77), kBlockLoad = pidUsage(0x89), kState = pidUsage(0x92),
                   kCreateNew = pidUsage(0xab), kBlockIndex = pidUsage(0x22);

Field copyOf(const HidField* found) {
  if (found == nullptr) return {};
  Field out{*found, true};
  out.field.choices.clear();
  return out;
}

class Finder {
 public:
  explicit Finder(const HidReports& reports) : reports_(reports) {}

  [[nodiscard]] Field out(std::uint16_t usage, HidUsage within) const {
    return copyOf(reports_.find(HidKind::kOutput, pidUsage(usage), within));
  }
  [[nodiscard]] Field in(HidUsage usage, HidUsage within = 0) const {
    return copyOf(reports_.find(HidKind::kInput, usage, within));
  }
  [[nodiscard]] Field feature(HidUsage usage, HidUsage within) const {
    return copyOf(reports_.find(HidKind::kFeature, usage, within));
  }
  [[nodiscard]] Choice choice(HidKind kind, std::uint16_t usage, HidUsage within) const {
    if (const HidField* array = reports_.findChoice(kind, pidUsage(usage), within)) {
      return {copyOf(array), valueOfChoice(*array, pidUsage(usage))};
    }
    if (const HidField* bit = reports_.find(kind, pidUsage(usage), within)) return {copyOf(bit), 1};
    return {};
  }

 private:
  const HidReports& reports_;
};

/** An axis within a collection of axes (Axes Enable, Direction): by its own usage, or by its ordinal. */
Field ofAxis(const HidReports& reports, std::size_t axis, HidUsage within) {
  const auto number = static_cast<std::uint16_t>(axis);
  const HidField* found =
      reports.find(HidKind::kOutput, hidUsage(kDesktop, static_cast<std::uint16_t>(0x30 + number)), within);
  if (found == nullptr) {
    found = reports.find(HidKind::kOutput, hidUsage(kOrdinals, static_cast<std::uint16_t>(1 + number)), within);
  }
  return copyOf(found);
}

Quirks quirksOf(const Layout& l) {
  Quirks quirks;
  quirks.no_start_delay = !l.start_delay.there;
  quirks.no_block_offset = !l.block_offset.there;
  quirks.no_negative_coefficient = !l.negative_coefficient.there;
  quirks.no_saturation = !l.positive_saturation.there;
  quirks.no_dead_band = !l.dead_band.there;
  const Choice& enable = l.control[static_cast<std::size_t>(Control::kEnable)];
  quirks.control_in_bits = enable.there() && !enable.field.field.is_array;
  return quirks;
}

/** What a field of time takes for a millisecond: that is its unit unless it says how many, or how small parts of, a
 * second. */
double perMillisecond(const HidField& field) {
  constexpr std::uint32_t kSystem = 0xf, kSeconds = 0x1000;
  constexpr int kMilli = -3;
  return (field.unit & ~kSystem) == kSeconds ? std::pow(10, kMilli - field.unit_exponent) : 1;
}

/** Whether it can be told so long a time; its highest number may mean for ever. */
bool lasts(const Layout& l, std::int32_t ms) {
  const long units = std::lround(l.duration_per_ms * ms);
  return units > 0 && units < l.duration.field.logical_max;
}

/** What constant forces need and it has not; null: nothing. */
const char* lackedBy(const Layout& l) {
  if (!l.effect_block.there || !l.duration.there || !l.effect_type[0].there())
    return "Set Effect with a constant force";
  if (!lasts(l, kHold_ms) || !lasts(l, kFallback_ms)) return "Set Effect with durations of 0.1 and 0.2 s";
  if (!l.constant_block.there || !l.magnitude.there || l.magnitude.field.logical_min >= 0) return "Set Constant Force";
  if (!l.operation_block.there || !l.start.there() || !l.stop.there()) return "Effect Operation";
  if (!l.new_type[0].there()) return "Create New Effect";
  if (!l.loaded_block.there || !l.load_success.there()) return "Block Load";
  return l.axes > 0 ? nullptr : "an axis that is read and can be enabled";
}

}  // namespace

bool hasForceFeedback(const HidReports& reports) noexcept {
  return reports.hasCollection(kSetEffect) && reports.hasCollection(kConstant);
}

Result<Layout> layoutOf(const HidReports& reports) {
  const Finder find(reports);
  Layout l;
  l.numbered = reports.numbered();
  l.effect_block = find.out(0x22, kSetEffect);
  l.duration = find.out(0x50, kSetEffect);
  if (l.duration.there) l.duration_per_ms = perMillisecond(l.duration.field);
  l.sample_period = find.out(0x51, kSetEffect);
  l.gain = find.out(0x52, kSetEffect);
  l.trigger_repeat = find.out(0x54, kSetEffect);
  l.direction_enable = find.out(0x56, kSetEffect);
  l.start_delay = find.out(0xa7, kSetEffect);
  constexpr std::uint16_t kTypes[kEffects] = {0x26, 0x40, 0x41};
  for (std::size_t i = 0; i < kEffects; ++i) {
    l.effect_type[i] = find.choice(HidKind::kOutput, kTypes[i], kSetEffect);
    l.new_type[i] = find.choice(HidKind::kFeature, kTypes[i], kCreateNew);
  }
  l.constant_block = find.out(0x22, kConstant);
  l.magnitude = find.out(0x70, kConstant);
  l.condition_block = find.out(0x22, kCondition);
  l.block_offset = find.out(0x23, kCondition);
  l.centre = find.out(0x60, kCondition);
  l.positive_coefficient = find.out(0x61, kCondition);
  l.negative_coefficient = find.out(0x62, kCondition);
  l.positive_saturation = find.out(0x63, kCondition);
  l.negative_saturation = find.out(0x64, kCondition);
  l.dead_band = find.out(0x65, kCondition);
  l.operation_block = find.out(0x22, kOperation);
  l.loop_count = find.out(0x7c, kOperation);
  l.start = find.choice(HidKind::kOutput, 0x79, kOperation);
  l.stop = find.choice(HidKind::kOutput, 0x7b, kOperation);
  constexpr std::uint16_t kControlUsages[kControls] = {0x97, 0x98, 0x99, 0x9a};
  for (std::size_t i = 0; i < kControls; ++i) l.control[i] = find.choice(HidKind::kOutput, kControlUsages[i], 0);
  l.device_gain = find.out(0x7e, 0);
  l.loaded_block = find.feature(kBlockIndex, kBlockLoad);
  l.load_success = find.choice(HidKind::kFeature, 0x8c, kBlockLoad);
  l.load_full = find.choice(HidKind::kFeature, 0x8d, kBlockLoad);

  for (std::size_t i = 0; i < kMostAxes; ++i) {
    l.axis_enable[i] = ofAxis(reports, i, pidUsage(0x55));
    l.direction[i] = ofAxis(reports, i, pidUsage(0x57));
    l.axis[i] = find.in(hidUsage(kDesktop, static_cast<std::uint16_t>(0x30 + i)));
    // A wheel has an X that is read; a Y that is a pedal gets no force.
    if (l.axes == i && l.axis[i].there && l.axis_enable[i].there) l.axes = i + 1;
  }
  for (std::size_t i = 0; i < l.button.size(); ++i) {
    l.button[i] = find.in(hidUsage(kButtons, static_cast<std::uint16_t>(1 + i)));
    if (l.button[i].there) l.buttons = i + 1;
  }
  l.safety_switch = find.in(pidUsage(0xa4), kState);
  l.actuator_power = find.in(pidUsage(0xa6), kState);

  l.quirks = quirksOf(l);

  if (const char* lacked = lackedBy(l)) {
    return Error{ErrorCode::kUnsupported, "report descriptor", fmt::format("the device lacks {}", lacked),
                 "only devices with constant forces by USB PID 1.0 can be used"};
  }
  return l;
}

}  // namespace hapticd::pid
