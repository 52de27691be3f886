// hapticctl info [DEVICE]: the data sheet of a device.
#include <CLI/CLI.hpp>
#include <cmath>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

using Lines = std::vector<std::pair<std::string, std::string>>;

/** A value with its unit, where the device knows it. */
void add(Lines& lines, const char* name, double value, const char* unit) {
  if (std::isfinite(value) && value != 0) lines.emplace_back(name, fmt::format("{:.6g} {}", value, unit));
}
void add(Lines& lines, const char* name, const char* text) {
  if (text[0] != '\0') lines.emplace_back(name, text);
}
void addLength(Lines& lines, const char* name, double metres) {
  if (metres > 0) lines.emplace_back(name, length(metres));
}
void addBox(Lines& lines, const char* name, const double (&lower)[3], const double (&upper)[3]) {
  if (!(upper[0] > lower[0])) return;
  const auto span = [&](int i) { return fmt::format("{:.4g} to {:.4g}", lower[i] * 1e3 + 0.0, upper[i] * 1e3 + 0.0); };
  lines.emplace_back(name, fmt::format("x {}, y {}, z {} mm", span(0), span(1), span(2)));
}

std::string listed(const Json& words) {
  std::string out;
  for (const auto& word : words) {
    std::string text = word.get<std::string>();
    std::replace(text.begin(), text.end(), '_', ' ');
    out += (out.empty() ? "" : ", ") + text;
  }
  return out;
}

std::string sheet(const haptic_device_info& d) {
  const Json json = toJson(d);
  Lines lines;
  lines.emplace_back(d.model[0] != '\0' ? d.model : d.uri, "");
  add(lines, "uri", d.uri);
  add(lines, "name", d.name);
  if (d.problem[0] != '\0') {  // Configured, but not there: no more is known of it, and why is what matters.
    lines.emplace_back("state", "missing");
    lines.emplace_back("why", d.problem);
    return fields(lines);
  }
  lines.emplace_back("state", d.open != 0 ? "open" : "found, not open");
  add(lines, "manufacturer", d.manufacturer);
  add(lines, "serial", d.serial);
  add(lines, "firmware", d.firmware);
  lines.emplace_back("driver", fmt::format("{} {}", d.driver, d.driver_version));
  lines.emplace_back("abilities", listed(json["abilities"]));
  lines.emplace_back("buttons", std::to_string(d.buttons));
  lines.emplace_back("calibration",
                     fmt::format("{} (style: {})", json["calibration"].get<std::string>(), d.calibration_style));
  lines.emplace_back("Workspace", "");
  addBox(lines, "usable", d.workspace_lower, d.workspace_upper);
  addBox(lines, "reachable", d.max_workspace_lower, d.max_workspace_upper);
  addLength(lines, "radius", d.workspace_radius);
  add(lines, "gripper angle", d.gripper_max_angle, "rad");
  lines.emplace_back("Force", "");
  add(lines, "peak force", d.max_force, "N");
  add(lines, "continuous force", d.continuous_force, "N");
  add(lines, "peak torque", d.max_torque, "N m");
  add(lines, "gripper force", d.max_gripper_force, "N");
  add(lines, "stiffness at 1 kHz", d.max_stiffness, "N/m");
  add(lines, "angular stiffness", d.max_angular_stiffness, "N m/rad");
  add(lines, "gripper stiffness", d.max_gripper_stiffness, "N/m");
  add(lines, "damping", d.max_damping, "N s/m");
  add(lines, "angular damping", d.max_angular_damping, "N m s/rad");
  lines.emplace_back("Mechanics", "");
  addLength(lines, "position resolution", d.position_resolution);
  add(lines, "rotation resolution", d.rotation_resolution, "rad");
  add(lines, "force resolution", d.force_resolution, "N");
  add(lines, "native rate", d.native_rate_hz, "Hz");
  add(lines, "apparent mass", d.apparent_mass, "kg");
  add(lines, "viscous friction", d.viscous_friction, "N s/m");
  add(lines, "coulomb friction", d.coulomb_friction, "N");
  add(lines, "highest velocity", d.max_velocity, "m/s");
  add(lines, "hottest motor", d.temperature_c, "deg C");
  return fields(lines);
}

/** A device that no list has may still be one that can be opened: a simulated one, for instance. */
const haptic_device_info& openOrFound(const haptic_device_list& devices, const std::string& wanted) try {
  return findDevice(devices, wanted);
} catch (Failure& failure) {
  if (wanted.find("://") == std::string::npos) throw;
  failure.what = "is neither open nor found";
  failure.remedy += fmt::format("; hapticctl monitor '{}' opens it while it runs, if it can be", wanted);
  throw;
}

}  // namespace

void addInfo(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("info", "Show what a device is and can do");
  auto device = std::make_shared<std::string>();
  command->add_option("DEVICE", *device, "URI, name or serial; without it: the first of list");
  whenNamed(command, chosen, [device](const Globals& globals) {
    const Daemon daemon(globals);
    const auto devices = daemon.ask<haptic_device_list>(haptic_device_list_all);
    const haptic_device_info& found = openOrFound(*devices, *device);
    if (globals.json) {
      putJson(toJson(found));
    } else {
      put(sheet(found));
    }
    return kExitOk;
  });
}

}  // namespace hapticctl
