#include "drivers/pantograph/pantograph_driver.h"

#include "drivers/link/io_device.h"
#include "drivers/pantograph/pantograph_io.h"
#include "drivers/serial/tty_transport.h"

namespace hapticd {
namespace {

Result<std::unique_ptr<Device>> make(const DeviceUri& uri) {
  return makeIoDevice<PantographIo>(resolvePantograph(uri));
}

/** A serial line does not say what hangs on it, and asking would disturb whatever does. */
void find(std::vector<DeviceFound>&) {}

Result<void> zero(const DeviceUri& uri) {
  Result<PantographSetup> setup = resolvePantograph(uri);
  if (!setup) return setup.error();
  const std::unique_ptr<SerialTransport> line = setup->line();
  if (auto opened = line->open(); !opened) return opened;
  for (int i = 0; i < PantographIo::kZeros; ++i) {
    if (line->write(pantograph::encodeTorques({}))) continue;
    return Error{ErrorCode::kDeviceGone, setup->info.uri, "the line takes nothing", "cut the board's power"};
  }
  return {};
}

}  // namespace

const std::vector<Parameter<PantographParameters>>& pantographParameterTable() {
  using S = PantographParameters;
  static const std::vector<Parameter<S>> kTable = {
      {{"torque_scale", "", 0.001, 10,
        "What the board is told for a newton metre at a motor; hang a weight to calibrate."},
       &S::torque_scale},
      {{"max_force", "N", 0.1, 20, "Largest force; a larger one is shortened in its direction."}, &S::max_force},
      {{"counts_per_turn", "", 100, 1e6, "Of the encoders."}, &S::counts_per_turn},
      {{"centre", "m", 0.04, 0.11, "Distance from the line of the motors that is x = 0."}, &S::centre},
      {{"clockwise", "", 0, 1, "Motors and encoders turn the other way round."}, &S::clockwise},
  };
  return kTable;
}

Result<PantographSetup> resolvePantograph(const DeviceUri& uri) {
  PantographSetup setup;
  if (uri.authority.empty() || uri.authority[0] != '/') {
    return Error{ErrorCode::kInvalidArgument, "device URI", "pantograph:// names no tty",
                 "write pantograph:///dev/ttyACM0, or better the name under /dev/serial/by-id that stays"};
  }
  const PantographParameters& p = setup.parameters;
  if (auto applied = applyQuery(pantographParameterTable(), uri.query, setup.parameters); !applied)
    return applied.error();
  DeviceInfo& info = setup.info;
  info.uri = formatDeviceUri({"pantograph", uri.authority, difference(pantographParameterTable(), p, {})});
  info.model = "2DIY pantograph";
  info.manufacturer = "Haply";
  info.driver = "pantograph";
  info.driver_version = "1";
  info.max_force = p.max_force;
  info.max_stiffness = 500;
  info.max_damping = 2;
  info.workspace_radius = 0.03;
  // The bars stay where they are, wherever x = 0 is.
  info.workspace_lower = Vec3(0.045 - p.centre, -0.03, 0);
  info.workspace_upper = Vec3(0.095 - p.centre, 0.03, 0);
  info.max_workspace_lower = Vec3(0.02 - p.centre, -0.06, 0);
  info.max_workspace_upper = Vec3(0.115 - p.centre, 0.06, 0);
  info.position_resolution = 6.283185307179586 / p.counts_per_turn * 0.07;
  info.force_resolution = 1e-3;
  info.native_rate_hz = 1000;
  info.latency_s = 0.002;
  info.calibration_style = "hold both arms straight out while the device is opened, or plugged in again";
  setup.line = [path = uri.authority] { return std::make_unique<TtyTransport>(path); };
  return setup;
}

const Driver kPantographDriver = {"pantograph", "pantograph:///dev/ttyACM0", true, &find, &make, &zero};

}  // namespace hapticd
