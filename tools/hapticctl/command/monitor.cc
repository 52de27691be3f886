// hapticctl monitor: every servo sample, or fewer, as a table, CSV or JSON lines.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <iterator>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct MonitorOptions {
  std::string device;
  bool csv = false;
  double rate_hz = 0;  ///< 0: every sample.
  double duration_s = 0;
};

/** hapticctl(1) documents these; add at the end only. */
constexpr std::string_view kCsvHeader =
    "t_s,tick,t_ns,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,fx,fy,fz,tx,ty,tz,proxy_x,proxy_y,proxy_z,"
    "surface_x,surface_y,surface_z,effect_x,effect_y,effect_z,local_model_x,local_model_y,local_model_z,"
    "client_x,client_y,client_z,gravity_x,gravity_y,gravity_z,guard_x,guard_y,guard_z,own_x,own_y,own_z,"
    "depth,energy,gripper_rad,gripper_force,buttons,object,armed,contact,slip,limited,flags,fault,missed,"
    "wake_ns,cycle_ns,commands,texture_x,texture_y,texture_z,transient_x,transient_y,transient_z\n";

/** In the order of the columns; the others stand at the end of the line. */
constexpr int kFirstSources[] = {HAPTIC_SOURCE_SURFACE, HAPTIC_SOURCE_EFFECT,  HAPTIC_SOURCE_LOCAL_MODEL,
                                 HAPTIC_SOURCE_CLIENT,  HAPTIC_SOURCE_GRAVITY, HAPTIC_SOURCE_GUARD};

void csvLine(std::string& out, const haptic_sample& s, double t_s) {
  const auto to = std::back_inserter(out);
  const auto vector = [&](const auto& values) {
    for (const auto value : values) fmt::format_to(to, ",{}", value);
  };
  const auto bit = [&](std::uint32_t flag) { fmt::format_to(to, ",{}", (s.flags & flag) != 0 ? 1 : 0); };
  fmt::format_to(to, "{:.6f},{},{}", t_s, s.tick, s.t_ns);
  vector(s.p);
  vector(s.q);
  vector(s.v);
  vector(s.w);
  vector(s.force);
  vector(s.torque);
  vector(s.proxy);
  for (const int source : kFirstSources) vector(s.by_source[source]);
  vector(s.own);
  fmt::format_to(to, ",{},{},{},{},{},{}", s.depth_m, s.energy_j, s.gripper_rad, s.gripper_force_n, s.buttons,
                 s.contact_object);
  bit(HAPTIC_SAMPLE_ARMED);
  bit(HAPTIC_SAMPLE_CONTACT);
  bit(HAPTIC_SAMPLE_SLIP);
  bit(HAPTIC_SAMPLE_LIMITED);
  fmt::format_to(to, ",{},{},{},{},{},{}", s.flags, s.fault, s.missed, s.wake_ns, s.cycle_ns, s.applied_commands);
  vector(s.by_source[HAPTIC_SOURCE_TEXTURE]);
  vector(s.by_source[HAPTIC_SOURCE_TRANSIENT]);
  out += '\n';
}

std::string flagWords(const haptic_sample& s) {
  std::string out = (s.flags & HAPTIC_SAMPLE_ARMED) != 0 ? "armed" : "disarmed";
  const auto add = [&](std::uint32_t flag, const char* word) {
    if ((s.flags & flag) != 0) out += std::string(" ") + word;
  };
  add(HAPTIC_SAMPLE_RAMPING, (s.flags & HAPTIC_SAMPLE_WAITING) != 0 ? "waiting" : "ramping");
  if ((s.flags & HAPTIC_SAMPLE_CONTACT) != 0) out += (s.flags & HAPTIC_SAMPLE_SLIP) != 0 ? " slides" : " touches";
  add(HAPTIC_SAMPLE_LIMITED, "limited");
  add(HAPTIC_SAMPLE_PASSIVITY, "damped");
  add(HAPTIC_SAMPLE_SATURATED, "saturated");
  add(HAPTIC_SAMPLE_STALE, "stale");
  add(HAPTIC_SAMPLE_CLUTCHED, "clutched");
  if ((s.flags & HAPTIC_SAMPLE_FAULT) != 0) out += std::string(" FAULT:") + faultName(s.fault);
  return out;
}

/** On a terminal too narrow for all: without tick, sum and latency a line is no longer than 80 columns. */
void narrowLine(const haptic_sample& s, double t_s) {
  print("{:7.2f} {:>7} {:>7} {:>7} {:>6} {:>6} {:>6} {:>7}  {}\n", t_s, fixed(s.p[0] * 1e3, 2), fixed(s.p[1] * 1e3, 2),
        fixed(s.p[2] * 1e3, 2), fixed(s.force[0], 2), fixed(s.force[1], 2), fixed(s.force[2], 2),
        fixed(static_cast<double>(s.depth_m) * 1e3, 3), flagWords(s));
}

void tableLine(const haptic_sample& s, double t_s) {
  const double force = std::sqrt(s.force[0] * s.force[0] + s.force[1] * s.force[1] + s.force[2] * s.force[2]);
  print("{:9.3f} {:9} {:>8} {:>8} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}  {}\n", t_s, s.tick, fixed(s.p[0] * 1e3, 2),
        fixed(s.p[1] * 1e3, 2), fixed(s.p[2] * 1e3, 2), fixed(s.force[0], 3), fixed(s.force[1], 3),
        fixed(s.force[2], 3), fixed(force, 3), fixed(static_cast<double>(s.depth_m) * 1e3, 3),
        fixed(s.wake_ns * 1e-3, 1), flagWords(s));
}

void narrowHeader() {
  put(styled(Style::kBold, fmt::format("{:>7} {:>7} {:>7} {:>7} {:>6} {:>6} {:>6} {:>7}  {}", "t s", "x mm", "y mm",
                                       "z mm", "fx N", "fy N", "fz N", "deep mm", "state")) +
      "\n");
}

void tableHeader() {
  put(styled(Style::kBold,
             fmt::format("{:>9} {:>9} {:>8} {:>8} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}  {}", "t s", "tick", "x mm",
                         "y mm", "z mm", "fx N", "fy N", "fz N", "|f| N", "deep mm", "wake us", "state")) +
      "\n");
}

/** Lets one sample through per 1/rate, by the samples' own times, without drifting. */
class Decimator {
 public:
  explicit Decimator(double rate_hz) : period_ns_(rate_hz > 0 ? static_cast<std::int64_t>(1e9 / rate_hz) : 0) {}
  bool takes(std::int64_t t_ns) {
    if (period_ns_ == 0) return true;
    if (t_ns < due_ns_) return false;
    due_ns_ = due_ns_ == 0 || t_ns - due_ns_ > 4 * period_ns_ ? t_ns + period_ns_ : due_ns_ + period_ns_;
    return true;
  }

 private:
  std::int64_t period_ns_, due_ns_ = 0;
};

enum class Form { kTable, kNarrow, kCsv, kJson };
constexpr int kTableColumns = 110;  ///< With its usual states.

void printHeader(Form form) {
  if (form == Form::kCsv) put(kCsvHeader);
  if (form == Form::kTable) tableHeader();
  if (form == Form::kNarrow) narrowHeader();
}

void printLine(Form form, const haptic_sample& s, double t_s) {
  switch (form) {
    case Form::kTable:
      return tableLine(s, t_s);
    case Form::kNarrow:
      return narrowLine(s, t_s);
    case Form::kCsv: {
      std::string line;
      csvLine(line, s, t_s);
      return put(line);
    }
    case Form::kJson: {
      Json json = toJson(s);
      json["t_s"] = t_s;
      return putJson(json, true);
    }
  }
}

/** A device's samples from now on, as lines. */
class Monitor {
 public:
  Monitor(const Session& session, Form form, double rate_hz, double duration_s)
      : session_(session), form_(form), decimator_(rate_hz), duration_s_(duration_s) {
    // What the history already held before we came is not asked for.
    while (drain() == HAPTIC_OK && fresh_ == samples_.size()) continue;
    lost_ = 0;
  }

  /** Prints what has come since the last look. Throws Failure when the session is dead. */
  void look() {
    const int code = drain();
    if (code != HAPTIC_OK && code != HAPTIC_WOULD_BLOCK) {
      flush();
      check(code, haptic_error HAPTIC_ERROR_INIT);
    }
    for (std::uint32_t i = 0; i < fresh_ && !over_; ++i) take(samples_[i]);
    flush();
    if (!over_ && fresh_ == 0) checkSilence();
  }
  [[nodiscard]] bool over() const { return over_; }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  [[nodiscard]] std::uint64_t written() const { return written_; }

 private:
  int drain() {
    fresh_ = 0;
    return haptic_session_drain(session_.get(), samples_.data(), static_cast<std::uint32_t>(samples_.size()), &fresh_,
                                &lost_);
  }
  void take(const haptic_sample& s) {
    if (s.device != session_.info().device_index) return;
    if (start_ns_ == 0) start_ns_ = s.t_ns;
    t_s_ = static_cast<double>(s.t_ns - start_ns_) * 1e-9;
    over_ = duration_s_ > 0 && t_s_ >= duration_s_;
    if (over_ || !decimator_.takes(s.t_ns)) return;
    printLine(form_, s, t_s_);
    ++written_;
  }
  /** The duration is by the samples' own times; where none come any more, by the clock. */
  void checkSilence() {
    constexpr double kPatience_s = 0.5;
    check(haptic_session_check(session_.get()), haptic_error HAPTIC_ERROR_INIT);
    const double waited_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
    if (duration_s_ <= 0 || waited_s <= duration_s_ + kPatience_s) return;
    note(fmt::format("hapticctl: samples ended after {:.3f} s: does the servo stand?", t_s_));
    over_ = true;
  }

  const Session& session_;
  const Form form_;
  Decimator decimator_;
  const double duration_s_;  ///< 0: without end.
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::vector<haptic_sample> samples_{1024};
  std::uint32_t fresh_ = 0;  ///< Of samples_, by the last drain().
  std::uint64_t lost_ = 0, written_ = 0;
  std::int64_t start_ns_ = 0;
  double t_s_ = 0;  ///< Of the newest sample.
  bool over_ = false;
};

int run(const MonitorOptions& options, const Globals& globals) {
  const Interrupt interrupt;
  const Daemon daemon(globals);
  const Session session(daemon, options.device);
  const bool narrow = stdoutIsTerminal() && terminalSize().columns < kTableColumns;
  const Form form = options.csv ? Form::kCsv : globals.json ? Form::kJson : narrow ? Form::kNarrow : Form::kTable;
  const bool every = form == Form::kCsv || form == Form::kJson;
  printHeader(form);
  Monitor monitor(session, form, options.rate_hz > 0 ? options.rate_hz : every ? 0 : 10, options.duration_s);
  while (!Interrupt::asked()) {
    monitor.look();
    if (monitor.over()) break;
    interrupt.wait(std::chrono::milliseconds(20));
  }
  if (monitor.lost() != 0) {
    note(fmt::format("hapticctl: {} sample{} lost (the history holds 1024; write to a file or take a lower --rate)",
                     monitor.lost(), monitor.lost() == 1 ? "" : "s"));
  }
  if (form == Form::kCsv && stdoutIsTerminal()) note(fmt::format("{} samples", monitor.written()));
  return kExitOk;
}

}  // namespace

void addMonitor(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("monitor", "Print position, force and timing as they happen");
  auto options = std::make_shared<MonitorOptions>();
  command->add_option("DEVICE", options->device, "URI, name or serial; without it: the open one");
  command->add_flag("--csv", options->csv, "Comma-separated, every servo sample; columns in hapticctl(1)");
  command->add_option("--rate", options->rate_hz, "Lines per second at most (table: 10; --csv, --json: every sample)")
      ->type_name("HZ")
      ->check(number(0.001, 100000.0));
  command->add_option("--for,--duration", options->duration_s, "Stop after so long")
      ->type_name("SECONDS")
      ->check(number(0.001, 1e7));
  whenNamed(command, chosen, [options](const Globals& globals) {
    if (options->csv && globals.json) failUsage("--csv", "cannot go together with --json");
    return run(*options, globals);
  });
}

}  // namespace hapticctl
