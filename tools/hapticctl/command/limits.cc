// hapticctl limits: what binds the sum of all clients on a device.
#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct Limit {
  const char* option;
  const char* unit;
  const char* text;
  double haptic_device_limits::*value;
};
constexpr Limit kLimits[] = {
    {"--force", "N", "Force", &haptic_device_limits::force},
    {"--torque", "N m", "Torque", &haptic_device_limits::torque},
    {"--force-slew", "N/s", "Rise of the force", &haptic_device_limits::force_slew},
    {"--torque-slew", "N m/s", "Rise of the torque", &haptic_device_limits::torque_slew},
    {"--velocity", "m/s", "Velocity beyond which the guard latches", &haptic_device_limits::velocity},
    {"--power", "W", "Power delivered to the hand", &haptic_device_limits::power},
    {"--active-power", "W", "Power of sources declared active", &haptic_device_limits::active_power},
    {"--gripper-force", "N", "Force of a gripper", &haptic_device_limits::gripper_force}};

struct LimitsOptions {
  std::string device;
  haptic_device_limits wanted{};
};

void show(const std::string& name, const haptic_device_limits& limits, bool json) {
  if (json) {
    Json out = toJson(limits);
    out["device"] = name;
    putJson(out);
    return;
  }
  std::vector<std::pair<std::string, std::string>> lines{{name, ""}};
  for (const Limit& limit : kLimits)
    lines.emplace_back(limit.option + 2, fmt::format("{:.6g} {}", limits.*limit.value, limit.unit));
  put(fields(lines));
}

}  // namespace

void addLimits(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand(
      "limits",
      "Show or change a device's limits; to raise them takes --admin, to lower them that or its lease holder's user");
  auto o = std::make_shared<LimitsOptions>();
  o->wanted.size = sizeof o->wanted;
  command->add_option("DEVICE", o->device, "URI, name or serial; without it: the first open one");
  for (const Limit& limit : kLimits) {
    o->wanted.*limit.value = std::numeric_limits<double>::quiet_NaN();
    command->add_option(limit.option, o->wanted.*limit.value, limit.text)->type_name(limit.unit)->check(number(0));
  }
  whenNamed(command, chosen, [o](const Globals& globals) {
    const Daemon daemon(globals);
    const auto status = daemon.ask<haptic_status>(haptic_get_status);
    std::string uri = deviceUri(daemon, o->device);
    const haptic_device_status* found = nullptr;
    for (std::uint32_t i = 0; i < status->device_count && found == nullptr; ++i) {
      if (uri.empty() || uri == status->devices[i]->uri) found = status->devices[i];
    }
    if (found == nullptr)
      throw Failure{kExitRefused, o->device, "no such device is open", "hapticctl list shows them", "NOT_FOUND"};
    bool change = false;
    for (const Limit& limit : kLimits) change = change || !std::isnan(o->wanted.*limit.value);
    haptic_device_limits in_force = *found->limits;
    if (change) {
      in_force.size = sizeof in_force;
      try {
        daemon.tell(haptic_device_set_limits, found->uri, &o->wanted, &in_force);
      } catch (Failure& failure) {
        if (failure.code == "LEASE_REQUIRED" || failure.code == "PERMISSION_DENIED") {
          failure.remedy = "use the administration socket: hapticctl --admin limits ...";
        }
        throw;
      }
    }
    show(found->name, in_force, globals.json);
    return kExitOk;
  });
}

}  // namespace hapticctl
