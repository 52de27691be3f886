// hapticctl doctor: what keeps this machine, this user and this daemon from a steady servo, and the line that fixes it.
#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/command/host_checks.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"

namespace hapticctl {
namespace {

/** What systemd says of the service, where both are there. */
HostCheck service() {
  HostCheck out{
      "service", CheckState::kNotApplicable, "hapticd.service is not installed, or systemd does not run here", {}};
  std::error_code error;
  const bool installed = std::filesystem::exists("/usr/lib/systemd/system/hapticd.service", error) ||
                         std::filesystem::exists("/lib/systemd/system/hapticd.service", error) ||
                         std::filesystem::exists("/etc/systemd/system/hapticd.service", error);
  if (!installed || !std::filesystem::exists("/run/systemd/system", error)) return out;
  const bool active = std::system("systemctl is-active --quiet hapticd.service hapticd.socket") == 0;
  out.state = active ? CheckState::kGreen : CheckState::kRed;
  out.detail = active ? "active" : "hapticd.service and hapticd.socket are not active";
  out.remedy = "systemctl enable --now hapticd.socket hapticd.service";
  return out;
}

/** What a daemon that answers says of itself is not asked of this user too: a missing right is named once. */
void leaveToDaemon(std::vector<HostCheck>& checks) {
  for (HostCheck& check : checks) {
    for (const char* name : {"real-time priority", "locked memory", "CPU sleep states"}) {
      if (check.name == name)
        check = {name, CheckState::kNotApplicable, "the daemon that answers says its own below", {}};
    }
  }
}

/** Asks the daemon; adds how reachable it is, and its own checks. */
void askDaemon(const Globals& globals, std::vector<HostCheck>& checks) {
  try {
    const Daemon daemon(globals);
    const auto info = daemon.ask<haptic_daemon_info>(haptic_get_daemon_info);
    checks.push_back({"daemon",
                      CheckState::kGreen,
                      fmt::format("hapticd {} (pid {}) answers on {}", info->version, info->pid, info->socket),
                      {}});
    checks.push_back(configurationCheck(info->config_file, startOf(static_cast<int>(info->pid))));
    const auto list = daemon.ask<haptic_check_list>(haptic_run_doctor);
    leaveToDaemon(checks);
    for (std::uint32_t i = 0; i < list->count; ++i) {
      const haptic_check& c = *list->items[i];
      const CheckState state = c.state == HAPTIC_CHECK_GREEN ? CheckState::kGreen
                               : c.state == HAPTIC_CHECK_RED ? CheckState::kRed
                                                             : CheckState::kNotApplicable;
      checks.push_back({fmt::format("daemon: {}", c.name), state, c.detail, c.remedy});
    }
  } catch (const Failure& failure) {
    checks.push_back({"daemon", CheckState::kRed,
                      failure.where.empty() ? failure.what : failure.where + ": " + failure.what, failure.remedy});
  }
}

}  // namespace

void addDoctor(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("doctor", "Check kernel, rights, devices and daemon; name the line that fixes each fault");
  whenNamed(command, chosen, [](const Globals& globals) {
    std::vector<HostCheck> checks = hostChecks();
    checks.push_back(service());
    askDaemon(globals, checks);
    std::size_t red = 0, width = 0;
    for (const HostCheck& c : checks) {
      red += c.state == CheckState::kRed ? 1 : 0;
      width = std::max(width, c.name.size());
    }
    if (globals.json) {
      putJson({{"red", red}, {"checks", toJson(checks)}});
      return red == 0 ? kExitOk : kExitRefused;
    }
    for (const HostCheck& c : checks) {
      const Style style = c.state == CheckState::kGreen ? Style::kGood
                          : c.state == CheckState::kRed ? Style::kBad
                                                        : Style::kDim;
      const char* word = c.state == CheckState::kGreen ? "green" : c.state == CheckState::kRed ? "RED  " : "n/a  ";
      print("{}  {:<{}}  {}\n", styled(style, word), c.name, width, c.detail);
      if (c.state == CheckState::kRed && !c.remedy.empty()) print("       {}\n", styled(Style::kBold, c.remedy));
    }
    print("{}\n", red == 0 ? "all is well" : fmt::format("{} to mend", red));
    return red == 0 ? kExitOk : kExitRefused;
  });
}

}  // namespace hapticctl
