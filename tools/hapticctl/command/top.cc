// hapticctl top: devices and clients live.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/counts.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct TopOptions {
  bool batch = false;
  std::uint64_t count = 0;
  double delay_s = 1;
};

/** One look at the daemon. */
struct Look {
  Owned<haptic_status> status;
  std::vector<Owned<haptic_statistics>> statistics;  ///< By device; null for one that has been closed since.
};

Look look(const Daemon& daemon) {
  auto status = daemon.ask<haptic_status>(haptic_get_status);
  auto statistics = statisticsOf(daemon, *status);
  return {std::move(status), std::move(statistics)};
}

const haptic_histogram* histogram(const haptic_statistics* statistics, std::string_view name) {
  for (std::uint32_t i = 0; statistics != nullptr && i < statistics->histogram_count; ++i) {
    if (name == statistics->histograms[i]->name) return statistics->histograms[i];
  }
  return nullptr;
}

std::string microseconds(double ns) { return fixed(ns * 1e-3, 1); }

std::string screen(const Look& now, const Baseline& base) {
  const haptic_status& status = *now.status;
  std::string out =
      fmt::format("hapticd {}  {}  devices {}, clients {}, objects {}, triangles {}\n", status.info->version,
                  status.info->realtime != 0 ? "real-time" : styled(Style::kBad, "NOT REAL-TIME"), status.device_count,
                  status.client_count, status.objects, grouped(status.triangles));

  Table devices({{"DEVICE"},
                 {"STATE"},
                 {"RATE Hz", true, 2},
                 {"WAKE p50 us", true, 1},
                 {"p99 us", true},
                 {"BUSY %", true},
                 {"CYCLE p99 us", true},
                 {"MISSES", true},
                 {"STALE", true, 3},
                 {"FORCE N", true}});
  std::string collisions;
  for (std::uint32_t i = 0; i < status.device_count; ++i) {
    const haptic_device_status& d = *status.devices[i];
    const haptic_histogram* wake = histogram(now.statistics[i].get(), "wake");
    const haptic_histogram* cycle = histogram(now.statistics[i].get(), "cycle");
    const DeviceCounts counts = base.since(d, now.statistics[i].get());
    if (counts.cut_short != 0 || counts.lost != 0) collisions += collideLine(d.name, counts);
    const double force = std::sqrt(d.force[0] * d.force[0] + d.force[1] * d.force[1] + d.force[2] * d.force[2]);
    devices.row({d.name,
                 d.fault != 0   ? "FAULT"
                 : d.armed != 0 ? "armed"
                                : "disarmed",
                 fixed(d.rate_hz, 0), wake != nullptr ? microseconds(static_cast<double>(wake->p50_ns)) : "-",
                 wake != nullptr ? microseconds(static_cast<double>(wake->p99_ns)) : "-", fixed(d.busy * 100, 1),
                 cycle != nullptr ? microseconds(static_cast<double>(cycle->p99_ns)) : "-", grouped(counts.missed),
                 grouped(counts.stale), fixed(force, 2)},
                d.fault != 0   ? Style::kBad
                : d.armed != 0 ? Style::kGood
                               : Style::kPlain);
  }
  out += devices.text() + collisions;

  Table clients({{"CLIENT"},
                 {"PID", true},
                 {"DEVICE"},
                 {"LEASE"},
                 {"RECEIVED", true},
                 {"REJECTED", true},
                 {"STALE", true, 1},
                 {"MODELS", true, 2},
                 {"FADE", true},
                 {"BEAT ms", true, 3}});
  for (std::uint32_t i = 0; i < status.client_count; ++i) {
    const haptic_client_status& c = *status.clients[i];
    const auto [received, rejected, stale] = base.since(c);
    clients.row({c.name, std::to_string(c.pid), c.device, c.lease != 0 ? "yes" : "", grouped(received),
                 grouped(rejected), grouped(stale), std::to_string(c.models), fixed(static_cast<double>(c.fade), 2),
                 fixed(static_cast<double>(c.heartbeat_age_ns) * 1e-6, 1)},
                c.fade < 1 ? Style::kWarn : Style::kPlain);
  }
  return out + clients.text();
}

Json asJson(const Look& now) {
  Json out = toJson(*now.status);
  out["statistics"] = Json::array();
  for (const auto& statistics : now.statistics) {
    if (statistics) out["statistics"].push_back(toJson(*statistics));
  }
  return out;
}

/** Starts the counts anew; the daemon's histograms too where this connection may reset them. Returns what to tell. */
std::string clear(const Daemon& daemon, const Look& now, Baseline& base) {
  for (std::uint32_t i = 0; i < now.status->device_count; ++i)
    base.take(*now.status->devices[i], now.statistics[i].get());
  for (std::uint32_t i = 0; i < now.status->client_count; ++i) base.take(*now.status->clients[i]);
  if (now.status->info->administration == 0) return "counts cleared; histograms need --admin";
  (void)statisticsOf(daemon, *now.status, true);
  return "counts and histograms cleared";
}

/** The other screen of the terminal, so that what stood there comes back. */
class FullScreen {
 public:
  FullScreen() { put("\x1b[?1049h\x1b[?25l\x1b[?7l"); }  // Without wrapping: what is too long is cut.
  ~FullScreen() {
    try {
      put("\x1b[?7h\x1b[?25h\x1b[?1049l");
      flush();
    } catch (...) {  // The terminal has gone.
    }
  }
  FullScreen(const FullScreen&) = delete;
  FullScreen& operator=(const FullScreen&) = delete;
};

/** At most so many lines of it, the last of which tells of the others: else the screen would roll. */
std::string fitted(const std::string& text, std::size_t rows) {
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  if (lines <= rows) return text;
  std::size_t end = 0;
  for (std::size_t i = 1; i < rows; ++i) end = text.find('\n', end) + 1;
  return text.substr(0, end) + styled(Style::kDim, fmt::format("{} lines more: hapticctl status", lines - rows + 1)) +
         "\n";
}

int live(const Daemon& daemon, const TopOptions& options, std::chrono::milliseconds delay) {
  const Interrupt interrupt;
  const RawKeys keys;
  const FullScreen full;
  Baseline base;
  std::string message;
  for (std::uint64_t n = 0; !Interrupt::asked() && (options.count == 0 || n < options.count); ++n) {
    const Look now = look(daemon);
    const auto rows = static_cast<std::size_t>(std::max(terminalSize().rows - 2, 3));
    std::string text = fitted(screen(now, base) + "\n", rows) +
                       styled(Style::kDim, message.empty() ? "q quit  c clear counts" : message) + "\n";
    message.clear();
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 4) text.replace(at, 1, "\x1b[K\n");
    put("\x1b[H" + text + "\x1b[J");
    flush();
    const char key = interrupt.wait(delay, keys.active());
    if (key == 'q' || key == 'Q') break;
    if (key == 'c' || key == 'C') message = clear(daemon, now, base);
  }
  return kExitOk;
}

int batch(const Daemon& daemon, const TopOptions& options, std::chrono::milliseconds delay, bool json) {
  const Interrupt interrupt;
  const Baseline none;
  for (std::uint64_t n = 0; !Interrupt::asked(); ++n) {
    const Look now = look(daemon);
    if (json) {
      putJson(asJson(now), true);
    } else {
      put((n == 0 ? "" : "\n") + screen(now, none));
    }
    flush();
    if (options.count != 0 && n + 1 >= options.count) break;
    interrupt.wait(delay);
  }
  return kExitOk;
}

}  // namespace

void addTop(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("top", "Watch devices and clients live: q quits, c clears the counts");
  auto options = std::make_shared<TopOptions>();
  command->add_flag("-b,--batch", options->batch, "Print screen after screen, for scripts and files");
  command->add_option("-n,--count", options->count, "Stop after so many screens")
      ->type_name("COUNT")
      ->check(number(1, 1e9))
      ->transform(decimal);
  command->add_option("-d,--delay", options->delay_s, "Time between screens")
      ->type_name("SECONDS")
      ->capture_default_str()
      ->check(number(0.02, 3600.0));
  whenNamed(command, chosen, [options](const Globals& globals) {
    const Daemon daemon(globals);
    const auto delay = std::chrono::milliseconds(static_cast<std::int64_t>(options->delay_s * 1e3));
    if (options->batch || globals.json) return batch(daemon, *options, delay, globals.json);
    if (!stdoutIsTerminal()) {
      failUsage("top", "standard output is no terminal", "hapticctl top -b -n 1 prints one screen");
    }
    return live(daemon, *options, delay);
  });
}

}  // namespace hapticctl
