#include "drivers/hidpid/hidpid_driver.h"

#include <optional>

#include "drivers/hid/hidraw_transport.h"
#include "drivers/hidpid/hidpid_io.h"
#include "drivers/link/io_device.h"

namespace hapticd {
namespace {

/** By what the device says of itself; its IDs do not matter. Nothing if it is none. */
std::optional<pid::Layout> layoutOf(const HidFound& found) {
  const Result<HidReports> reports = HidReports::parse(found.descriptor);
  if (!reports || !pid::hasForceFeedback(*reports)) return {};
  const Result<pid::Layout> layout = pid::layoutOf(*reports);
  return layout ? std::optional(layout.value()) : std::nullopt;
}

bool isForceFeedback(const HidFound& found) { return layoutOf(found).has_value(); }

std::vector<HidFound> plugged() {
  std::vector<HidFound> all = findHid();
  std::erase_if(all, [](const HidFound& one) { return !isForceFeedback(one); });
  return all;
}

Result<std::unique_ptr<Device>> make(const DeviceUri& uri) {
  return makeIoDevice<HidPidIo>(resolveHidPid(uri, plugged()));
}

void find(std::vector<DeviceFound>& found) {
  const std::vector<HidFound> all = plugged();
  for (const HidFound& one : all) {
    DeviceUri uri{"hidpid", authorityOf(one.serial), {}};
    if (one.serial.empty() && one.path != all.front().path) uri.query.emplace_back("path", one.path);
    Result<HidPidSetup> setup = resolveHidPid(uri, all);
    // Never taken unasked: a wheel is no haptic device by itself, and some push with 20 N m.
    if (setup) found.push_back({std::move(setup->info), false});
  }
}

Result<void> zero(const DeviceUri& uri) {
  const std::vector<HidFound> all = plugged();
  Result<HidPidSetup> setup = resolveHidPid(uri, all);
  if (!setup) return setup.error();
  const std::unique_ptr<HidTransport> hid = setup->hid();
  if (auto opened = hid->open(); !opened) return opened;
  Result<HidReports> reports = HidReports::parse(hid->descriptor());
  if (!reports) return reports.error();
  const Result<pid::Layout> layout = pid::layoutOf(*reports);
  if (!layout) return layout.error();
  const Result<pid::Lengths> lengths = pid::lengthsOf(*reports, layout.value());
  if (!lengths) return lengths.error();
  const pid::Encoder encoder(layout.value(), lengths.value());
  int taken = 0;
  for (const pid::Control what : {pid::Control::kStopAll, pid::Control::kDisable}) {
    const pid::Report report = encoder.control(what);
    if (!report.bytes().empty() && hid->write(report.bytes()) == HidResult::kOk) ++taken;
  }
  if (taken == 0) {
    return Error{ErrorCode::kDeviceGone, setup->info.uri, "it does not take the order to stop",
                 "its constant forces end by themselves within 0.1 s"};
  }
  return {};
}

}  // namespace

const std::vector<Parameter<HidPidParameters>>& hidPidParameterTable() {
  using S = HidPidParameters;
  static const std::vector<Parameter<S>> kTable = {
      {{"max_force", "N", 0.1, 100, "Its force at the grip at full magnitude; weigh it."}, &S::max_force},
      {{"travel", "m", 0.001, 2, "Way of the grip from the middle to the end of an axis."}, &S::travel},
      {{"invert", "", 0, 1, "It pushes the other way round."}, &S::invert},
      {{"fallback", "", 0, 0.5,
        "Share of its force for the damper and spring in the device when the servo is late; 0: none."},
       &S::fallback},
      {{"fixed_direction", "", 0, 1, "Quirk of some wheels: the direction is always told as 90 degrees."},
       &S::fixed_direction},
      {{"path", "", 0, 0, "Its node, /dev/hidrawN, if there are several without serial numbers."}, &S::path},
  };
  return kTable;
}

Result<HidPidSetup> resolveHidPid(const DeviceUri& uri, const std::vector<HidFound>& plugged) {
  HidPidSetup setup;
  HidPidParameters& p = setup.parameters;
  if (auto applied = applyQuery(hidPidParameterTable(), uri.query, p); !applied) return applied.error();
  DeviceInfo& info = setup.info;
  info.model = "force-feedback device";
  std::size_t axes = pid::kMostAxes;
  HidWanted wanted{{}, p.path, serialNamed(uri.authority), "a device with force feedback by USB PID"};
  // It may be plugged in later; then all that is known is that it is one.
  if (const auto found = choose(plugged, wanted)) {
    if (!found.value().name.empty()) info.model = found.value().name;
    info.manufacturer = found.value().manufacturer;
    wanted.serial = info.serial = found.value().serial;
    wanted.same = found.value();
    if (const auto layout = layoutOf(found.value())) {
      info.buttons = static_cast<std::uint32_t>(layout->buttons);
      axes = layout->axes;
    }
  }
  info.uri = formatDeviceUri({"hidpid", authorityOf(wanted.serial), difference(hidPidParameterTable(), p, {})});
  info.driver = "hidpid";
  info.driver_version = "1";
  info.max_force = p.max_force;
  // What one step of an axis of 10 bits may push with; nothing is published of any of them.
  info.max_stiffness = 0.5 * p.max_force / p.travel;
  info.max_damping = 1;
  info.workspace_radius = p.travel;
  const double along_x = axes > 1 ? p.travel : 0;
  info.workspace_lower = info.max_workspace_lower = Vec3(0 - along_x, -p.travel, 0);
  info.workspace_upper = info.max_workspace_upper = Vec3(along_x, p.travel, 0);
  info.position_resolution = p.travel / 512;
  info.force_resolution = p.max_force / 255;
  info.native_rate_hz = 1000;
  info.latency_s = 0.003;
  info.has_watchdog = true;
  info.has_deadman = true;
  wanted.fits = &isForceFeedback;
  setup.hid = [wanted] { return std::make_unique<HidrawTransport>(wanted); };
  return setup;
}

const Driver kHidPidDriver = {"hidpid", "hidpid://default?max_force=5", true, &find, &make, &zero};

}  // namespace hapticd
