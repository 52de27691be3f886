#include "drivers/replay/replay_driver.h"

#include "drivers/hash.h"
#include "drivers/replay/replay_device.h"

namespace hapticd {
namespace {

DeviceInfo infoOf(const ReplayParameters& p, std::string uri) {
  DeviceInfo info;
  info.serial = p.serial.empty() ? "replay-" + hashText(uri) : p.serial;
  info.uri = std::move(uri);
  info.model = "replay";
  info.manufacturer = "hapticd";
  info.firmware = "none";
  info.driver = "replay";
  info.driver_version = "1";
  info.max_force = p.max_force;
  info.position_resolution = p.resolution;
  return info;
}

Result<std::unique_ptr<Device>> make(const DeviceUri& uri) {
  Result<ReplaySetup> setup = resolveReplay(uri);
  if (!setup) return setup.error();
  return std::unique_ptr<Device>(std::make_unique<ReplayDevice>(std::move(*setup)));
}

void find(std::vector<DeviceFound>&) {}

}  // namespace

const std::vector<Parameter<ReplayParameters>>& replayParameterTable() {
  using S = ReplayParameters;
  static const std::vector<Parameter<S>> kTable = {
      {{"speed", "", 0.01, 100, "Speed of the playback; 1 is as recorded."}, &S::speed},
      {{"wait", "s", 0, 3600, "Holds the first pose this long before it starts."}, &S::wait},
      {{"loop", "", 0, 1, "Starts again at the end, with a jump unless the ends meet; else holds the last pose."},
       &S::loop},
      {{"max_force", "N", 0, 200, "Largest force of the device that the limits are to think of."}, &S::max_force},
      {{"max_torque", "N m", 0, 20, "The same for the torque, where the recording has an orientation."},
       &S::max_torque},
      {{"resolution", "m", 0, 0.001, "Reported resolution of the positions; the velocity estimate goes by it."},
       &S::resolution},
      {{"serial", "", 0, 0, "Serial number, to tell replays apart; else derived from the URI."}, &S::serial},
  };
  return kTable;
}

Result<ReplaySetup> resolveReplay(const DeviceUri& uri) {
  if (uri.authority.empty()) {
    return Error{ErrorCode::kInvalidArgument, "device URI", "replay:// names no file",
                 "write replay:///path/to/recording.csv"};
  }
  ReplaySetup setup;
  Result<void> applied = applyQuery(replayParameterTable(), uri.query, setup.parameters);
  if (!applied) return applied.error();
  Result<PoseFile> file = PoseFile::open(uri.authority, uri.within);
  if (!file) return file.error();
  setup.file = std::move(*file);
  setup.info =
      infoOf(setup.parameters,
             formatDeviceUri({"replay", uri.authority, difference(replayParameterTable(), setup.parameters, {})}));
  return setup;
}

const Driver kReplayDriver = {
    "replay", "replay:///path/to/recording.csv?key=value", false, &find, &make, &noForceOutlivesTheProcess};

}  // namespace hapticd
