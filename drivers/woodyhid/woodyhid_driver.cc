#include "drivers/woodyhid/woodyhid_driver.h"

#include <fmt/format.h>

#include "drivers/did_you_mean.h"
#include "drivers/hid/hidraw_transport.h"
#include "drivers/link/io_device.h"
#include "drivers/woodyhid/woodyhid_io.h"
#include "drivers/woodyhid/woodyhid_parameters.h"

namespace hapticd {
namespace {

/** Angles in which the tip is at the workspace's origin, by Newton from the middle of the joints. */
WoodyArm middleOf(const WoodyModel& model) {
  Vec3 angles = model.linkage == WoodyLinkage::kSerial ? Vec3(0, 0.6, 1.3) : Vec3(0, 1.0, 2.7);
  WoodyArm arm = solveWoodyArm(model, angles);
  for (int i = 0; i < 20 && arm.reachable; ++i) {
    angles -= clampNorm(arm.jacobian.fullPivLu().solve(arm.p), 0.2);
    arm = solveWoodyArm(model, angles);
  }
  return arm;
}

double reachOf(const WoodyModel& m) {
  return m.linkage == WoodyLinkage::kSerial ? m.Lb + m.Lc : m.bars.L0 / 2 + m.bars.L1 + m.bars.L5;
}

/** Half of a box that is used well: as much of what most have as lies well within the joints' reach, every corner. */
Vec3 halfBoxOf(const WoodyModel& m, const Vec3& shoulder) {
  if (m.linkage == WoodyLinkage::kFiveBar) return {0.05, 0.08, 0.05};
  const Vec3 most(0.06, 0.08, 0.06);
  double share = 1;
  // The corner farthest from the shoulder.
  while ((share * most + shoulder.cwiseAbs()).norm() > 0.95 * reachOf(m)) share -= 0.05;
  return share * most;
}

DeviceInfo infoOf(const WoodyModel& model) {
  DeviceInfo info;
  info.model = model.title;
  info.manufacturer = "Haptikfabriken";
  info.driver = "woodyhid";
  info.driver_version = "1";
  info.max_force = model.max_force;
  info.max_stiffness = model.max_stiffness;
  info.max_damping = model.max_damping;
  // The figures that are published give a radius only.
  info.workspace_radius = 0.08;
  const double reach = reachOf(model);
  const Vec3 shoulder = Vec3(0, 0, model.La) - model.origin;
  const Vec3 half = halfBoxOf(model, shoulder);
  info.workspace_lower = -half;
  info.workspace_upper = half;
  info.max_workspace_lower = shoulder - Vec3::Constant(reach);
  info.max_workspace_upper = shoulder + Vec3::Constant(reach);

  const WoodyArm middle = middleOf(model);
  double force_step = 0;
  for (int i = 0; i < 3; ++i) {
    const double step = 6.283185307179586 / model.counts_per_turn * model.capstan[i] / model.body[i];
    info.position_resolution = std::max(info.position_resolution, step * middle.jacobian.col(i).norm());
    const double lever = middle.jacobian.col(i).norm();
    force_step = std::max(force_step, 1e-3 * model.torque_constant[i] * model.body[i] / model.capstan[i] / lever);
  }
  info.force_resolution = force_step;
  info.sensed_rotation = model.gimbal_counts_per_turn > 0;
  if (info.sensed_rotation) info.rotation_resolution = 6.283185307179586 / model.gimbal_counts_per_turn;
  info.native_rate_hz = 1000;
  info.latency_s = 0.002;
  info.buttons = 1;
  info.has_watchdog = true;
  info.calibration_style = "put the arm into its pose of calibration and press the button on the electronics";
  return info;
}

HidWanted wantedBy(const WoodyParameters& parameters) {
  return {&mayBeWoody, parameters.path, parameters.serial, "a WoodenHaptics or Polhem board"};
}

Result<std::unique_ptr<Device>> make(const DeviceUri& uri) { return makeIoDevice<WoodyIo>(resolveWoody(uri)); }

void find(std::vector<DeviceFound>& found) {
  for (const HidFound& hid : findHid()) {
    if (!mayBeWoody(hid)) continue;
    DeviceUri uri{"woodyhid", std::string(kUsualWoodyModel), {}};
    uri.query.emplace_back(hid.serial.empty() ? "path" : "serial", hid.serial.empty() ? hid.path : hid.serial);
    Result<WoodySetup> setup = resolveWoody(uri);
    if (!setup) continue;
    setup->info.model = fmt::format("{} or another of the family, or any such board ({})", setup->info.model, hid.name);
    // Never taken unasked: its USB IDs are those of anything made of the same board.
    found.push_back({std::move(setup->info), false});
  }
}

Result<void> zero(const DeviceUri& uri) {
  Result<WoodySetup> setup = resolveWoody(uri);
  if (!setup) return setup.error();
  HidrawTransport hid(wantedBy(setup->parameters));
  if (auto opened = hid.open(); !opened) return opened;
  const woodyhid::Report report = woodyhid::encodeCurrents({});
  // A board that takes 14 bytes takes the first of them.
  const bool sent =
      hid.write(report) == HidResult::kOk || hid.write({report.data(), 1 + woodyhid::kReportBytes}) == HidResult::kOk;
  if (!sent) {
    return Error{ErrorCode::kDeviceGone, setup->info.uri, "it takes no report",
                 "it cuts its motors itself after half a second"};
  }
  return {};
}

}  // namespace

bool mayBeWoody(const HidFound& found) {
  constexpr std::uint16_t kTeensy = 0x16c0, kRawHid = 0x0486, kMbed = 0x1234, kLpc1768 = 0x0006;
  constexpr std::uint16_t kTeensyConsole = 0xffc9;  // A Teensy's second interface prints texts.
  if (found.vendor == kMbed && found.product == kLpc1768) return true;
  return found.vendor == kTeensy && found.product == kRawHid && found.usage_page != kTeensyConsole;
}

const std::vector<Parameter<WoodyParameters>>& woodyParameterTable() {
  using S = WoodyParameters;
  static const std::vector<Parameter<S>> kTable = {
      {{"gravity", "", 0, 1, "Share of the links' weight that the motors carry, where their masses are known."},
       &S::gravity},
      {{"max_current", "A", 0.05, 6, "Largest current of a motor; beyond it the force shrinks in its direction."},
       &S::max_current},
      {{"calibrated", "", 0, 1, "Its counters were set since it got its power, by an earlier session."},
       &S::calibrated},
      {{"path", "", 0, 0, "Its node, /dev/hidrawN, if there are several without serial numbers."}, &S::path},
      {{"serial", "", 0, 0, "Its serial number, if there are several."}, &S::serial},
  };
  return kTable;
}

Result<WoodySetup> resolveWoody(const DeviceUri& uri) {
  WoodySetup setup;
  const std::string name =
      uri.authority.empty() || uri.authority == "default" ? std::string(kUsualWoodyModel) : uri.authority;
  setup.model = findWoodyModel(name);
  if (setup.model == nullptr) {
    std::vector<std::string> names;
    for (const WoodyModel& model : woodyModels()) names.emplace_back(model.name);
    return Error{ErrorCode::kInvalidArgument, "device URI", fmt::format("there is no model \"{}\"", name.substr(0, 80)),
                 "one of " + nearestNames(name, names, names.size())};
  }
  if (auto applied = applyQuery(woodyParameterTable(), uri.query, setup.parameters); !applied) return applied.error();
  setup.info = infoOf(*setup.model);
  setup.info.serial = setup.parameters.serial;
  setup.info.uri = formatDeviceUri({"woodyhid", name, difference(woodyParameterTable(), setup.parameters, {})});
  static const auto counters = std::make_shared<WoodyCounters>();
  setup.counters = counters;
  setup.hid = [parameters = setup.parameters] { return std::make_unique<HidrawTransport>(wantedBy(parameters)); };
  return setup;
}

const Driver kWoodyDriver = {"woodyhid", "woodyhid://woodenhaptics_v2015?serial=...", true, &find, &make, &zero};

}  // namespace hapticd
