// hapticctl status: one screen on the daemon, its devices and its clients.
#include <CLI/CLI.hpp>
#include <cmath>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/counts.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

std::string uptime(std::int64_t ns) {
  const std::int64_t s = ns / 1'000'000'000;
  if (s < 120) return fmt::format("{} s", s);
  if (s < 7200) return fmt::format("{} min", s / 60);
  if (s < 172800) return fmt::format("{} h {} min", s / 3600, s / 60 % 60);
  return fmt::format("{} days", s / 86400);
}

std::string stateOf(const haptic_device_status& d) {
  if (d.fault != 0) return fmt::format("FAULT: {}", d.fault_text[0] != '\0' ? d.fault_text : faultName(d.fault));
  return d.armed != 0 ? "armed" : "disarmed";
}

/** A program that hangs keeps its lease and its place: told where its heartbeat has stopped and its force with it. */
std::string silenceOf(const haptic_client_status& c) {
  constexpr std::int64_t kAtLeastEvery_ns = 100'000'000;  // docs/protocol.md
  if (c.fade >= 1 || c.heartbeat_age_ns < kAtLeastEvery_ns) return {};
  return fmt::format("silent for {}", duration(static_cast<double>(c.heartbeat_age_ns)));
}

std::string screen(const haptic_status& status, const std::vector<Owned<haptic_statistics>>& statistics) {
  const haptic_daemon_info& info = *status.info;
  std::string out =
      fmt::format("{}  pid {}, up {}, {}\n", styled(Style::kBold, fmt::format("hapticd {}", info.version)), info.pid,
                  uptime(status.uptime_ns), info.config_file[0] != '\0' ? info.config_file : "built-in configuration");
  out += fmt::format("socket {}{}\n", info.socket, info.administration != 0 ? " (administration)" : "");
  if (info.realtime == 0) {
    out += styled(Style::kBad, "NOT REAL-TIME") +
           fmt::format(": {}\n", info.scheduling_note[0] != '\0' ? info.scheduling_note
                                                                 : "the servo runs as an ordinary thread") +
           "  Deadlines will be missed; hapticctl doctor names what to change.\n";
  }
  out += fmt::format("scene: {} object{}, {} triangles; {} of locked memory\n\n", status.objects,
                     status.objects == 1 ? "" : "s", grouped(status.triangles), bytes(status.locked_bytes));

  Table devices({{"DEVICE"},
                 {"STATE"},
                 {"LEASE"},
                 {"RATE Hz", true, 2},
                 {"WAKE p99", true},
                 {"BUSY %", true, 1},
                 {"MISSED", true},
                 {"FORCE N", true},
                 {"LIMIT N", true, 3},
                 {"SCHEDULING", false, 4}});
  for (std::uint32_t i = 0; i < status.device_count; ++i) {
    const haptic_device_status& d = *status.devices[i];
    const double force = std::sqrt(d.force[0] * d.force[0] + d.force[1] * d.force[1] + d.force[2] * d.force[2]);
    const std::string lease = d.lease_holder[0] != '\0' ? fmt::format("{} ({})", d.lease_holder, d.lease_pid) : "free";
    devices.row({d.name, stateOf(d), lease, fixed(d.rate_hz, 0), duration(d.wake_p99_ns), fixed(d.busy * 100, 1),
                 grouped(d.missed), fixed(force, 2), fixed(d.limits->force, 1), d.scheduling},
                d.fault != 0   ? Style::kBad
                : d.armed != 0 ? Style::kGood
                               : Style::kPlain);
  }
  out += devices.empty() ? "no device is open (hapticctl list)\n" : devices.text();
  for (std::uint32_t i = 0; i < status.device_count; ++i) {
    const DeviceCounts counts = countsOf(*status.devices[i], statistics[i].get());
    if (counts.answers != 0) out += collideLine(status.devices[i]->name, counts);
  }

  Table clients({{"CLIENT"},
                 {"PID", true},
                 {"DEVICE"},
                 {"LEASE"},
                 {"RECEIVED", true},
                 {"REJECTED", true},
                 {"MODELS", true},
                 {"STATE"}});
  for (std::uint32_t i = 0; i < status.client_count; ++i) {
    const haptic_client_status& c = *status.clients[i];
    const std::string silence = silenceOf(c);
    clients.row({c.name, std::to_string(c.pid), c.device, c.lease != 0 ? "yes" : "", grouped(c.received),
                 grouped(c.rejected), std::to_string(c.models), silence},
                silence.empty() ? Style::kPlain : Style::kWarn);
  }
  if (!clients.empty()) out += "\n" + clients.text();
  return out;
}

/** With the counts of the collide thread, as /statistics has them. */
Json asJson(const haptic_status& status, const std::vector<Owned<haptic_statistics>>& statistics) {
  Json out = toJson(status);
  for (std::uint32_t i = 0; i < status.device_count; ++i) {
    if (!statistics[i]) continue;
    const DeviceCounts counts = countsOf(*status.devices[i], statistics[i].get());
    out["devices"][i]["collide"] = {
        {"queries", counts.answers}, {"exhausted", counts.cut_short}, {"unsent", counts.lost}};
  }
  return out;
}

}  // namespace

void addStatus(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("status", "Show the daemon, its devices and clients on one screen");
  whenNamed(command, chosen, [](const Globals& globals) {
    const Daemon daemon(globals);
    const auto status = daemon.ask<haptic_status>(haptic_get_status);
    const auto statistics = statisticsOf(daemon, *status);
    if (globals.json) {
      putJson(asJson(*status, statistics));
    } else {
      put(screen(*status, statistics));
    }
    return kExitOk;
  });
}

}  // namespace hapticctl
