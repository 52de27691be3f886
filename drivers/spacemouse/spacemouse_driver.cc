#include "drivers/spacemouse/spacemouse_driver.h"

#include "drivers/hid/hidraw_transport.h"
#include "drivers/hid/report_descriptor.h"
#include "drivers/link/io_device.h"
#include "drivers/spacemouse/spacemouse_io.h"

namespace hapticd {
namespace {

/** Receivers have interfaces for keys and pointers beside. One that does not tell, or not so that we read it, may be.
 */
bool mayBeCap(const std::vector<std::uint8_t>& descriptor) {
  constexpr HidUsage kMultiAxisController = hidUsage(0x01, 0x08);
  const Result<HidReports> reports = HidReports::parse(descriptor);
  return descriptor.empty() || !reports || reports->hasCollection(kMultiAxisController);
}

std::vector<HidFound> plugged() {
  std::vector<HidFound> all = findHid();
  std::erase_if(all, [](const HidFound& one) { return !isSpaceMouse(one); });
  return all;
}

Result<std::unique_ptr<Device>> make(const DeviceUri& uri) {
  return makeIoDevice<SpaceMouseIo>(resolveSpaceMouse(uri, plugged()));
}

void find(std::vector<DeviceFound>& found) {
  const std::vector<HidFound> all = plugged();
  for (const HidFound& one : all) {
    DeviceUri uri{"spacemouse", authorityOf(one.serial), {}};
    if (one.serial.empty() && one.path != all.front().path) uri.query.emplace_back("path", one.path);
    // It gives no force: nobody who asks for "a device" means it.
    Result<SpaceMouseSetup> setup = resolveSpaceMouse(uri, all);
    if (setup) found.push_back({std::move(setup->info), false});
  }
}

}  // namespace

bool isSpaceMouse(const HidFound& found) {
  return spacemouse::findProduct(found.vendor, found.product) != nullptr && mayBeCap(found.descriptor);
}

const std::vector<Parameter<SpaceMouseParameters>>& spaceMouseParameterTable() {
  using S = SpaceMouseParameters;
  static const std::vector<Parameter<S>> kTable = {
      {{"mode", "", 0, 0, "The tool is where the cap is pushed to, or goes on as fast as it is pushed.",
        "displacement|rate"},
       &S::mode},
      {{"travel", "m", 0.001, 1, "displacement: how far the tool goes at full deflection."}, &S::travel},
      {{"turn", "rad", 0.01, 3, "displacement: how far it turns."}, &S::turn},
      {{"speed", "m/s", 0.001, 2, "rate: how fast the tool goes at full deflection."}, &S::speed},
      {{"turn_speed", "rad/s", 0.01, 10, "rate: how fast it turns."}, &S::turn_speed},
      {{"dead_zone", "", 0, 0.5, "Share of the full deflection that is taken for none."}, &S::dead_zone},
      {{"box", "m", 0.001, 2, "rate: the tool stays so near to the middle on each axis."}, &S::box},
      {{"deadman", "", 0, 32,
        "Button, counted from 1, that must be held for any device of the group to be armed; 0: none."},
       &S::deadman},
      {{"path", "", 0, 0, "Its node, /dev/hidrawN, if there are several without serial numbers."}, &S::path},
  };
  return kTable;
}

Result<SpaceMouseSetup> resolveSpaceMouse(const DeviceUri& uri, const std::vector<HidFound>& plugged) {
  SpaceMouseSetup setup;
  SpaceMouseParameters& p = setup.parameters;
  if (auto applied = applyQuery(spaceMouseParameterTable(), uri.query, p); !applied) return applied.error();
  HidWanted wanted{&isSpaceMouse, p.path, serialNamed(uri.authority), "a SpaceMouse"};

  DeviceInfo& info = setup.info;
  info.model = "SpaceMouse";
  info.buttons = 2;
  // It may be plugged in later; then all that is known is that it is one.
  if (const auto found = choose(plugged, wanted)) {
    if (const auto* product = spacemouse::findProduct(found.value().vendor, found.value().product)) {
      info.model = product->name;
      info.buttons = product->buttons;
    }
    wanted.serial = info.serial = found.value().serial;
    wanted.same = found.value();
  }
  info.uri = formatDeviceUri({"spacemouse", authorityOf(wanted.serial), difference(spaceMouseParameterTable(), p, {})});
  info.manufacturer = "3Dconnexion";
  info.driver = "spacemouse";
  info.driver_version = "1";
  const double reach = p.mode == "rate" ? p.box : p.travel;
  info.workspace_radius = reach;
  info.workspace_lower = info.max_workspace_lower = Vec3::Constant(-reach);
  info.workspace_upper = info.max_workspace_upper = Vec3::Constant(reach);
  info.position_resolution = (p.mode == "rate" ? p.speed * 0.004 : p.travel) / spacemouse::kFull;
  info.rotation_resolution = (p.mode == "rate" ? p.turn_speed * 0.004 : p.turn) / spacemouse::kFull;
  info.native_rate_hz = 1e9 / SpaceMouseIo::kSample_ns;
  info.latency_s = 0.016;  // Translation and rotation take turns every 8 ms.
  info.sensed_rotation = true;
  info.actuated_position = false;
  info.has_deadman = p.deadman != 0;
  setup.hid = [wanted] { return std::make_unique<HidrawTransport>(wanted); };
  return setup;
}

const Driver kSpaceMouseDriver = {"spacemouse", "spacemouse://default?deadman=1", true, &find,
                                  &make,        &noForceOutlivesTheProcess};

}  // namespace hapticd
