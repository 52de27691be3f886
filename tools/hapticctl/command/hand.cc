// hapticctl hand FILE: moves the hand of a simulated device along a recorded or drawn path.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/motion_file.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct HandOptions {
  std::string file, device;
  bool loop = false;
  double speed = 1;
};

/** Highest and sum since the last line, so that a line tells of the time between, not of one instant. */
struct Since {
  double force = 0;
  std::uint32_t wake_ns = 0, cycle_ns = 0;
  std::uint64_t samples = 0, touching = 0;

  void take(const haptic_sample& s) {
    force = std::max(force, std::sqrt(s.force[0] * s.force[0] + s.force[1] * s.force[1] + s.force[2] * s.force[2]));
    wake_ns = std::max(wake_ns, s.wake_ns);
    cycle_ns = std::max(cycle_ns, s.cycle_ns);
    ++samples;
    touching += (s.flags & HAPTIC_SAMPLE_CONTACT) != 0 ? 1 : 0;
  }
};

std::string describe(double t_s, double end_s, const haptic_sample& s, const Since& since) {
  return fmt::format(
      "{:5.1f}/{:.1f} s  at {:>6} {:>6} {:>6} mm  force {:>5} N (max {:>5})  touching {:>3.0f} %  wake max {:>8}  "
      "cycle max {:>8}",
      t_s, end_s, fixed(s.p[0] * 1e3, 1), fixed(s.p[1] * 1e3, 1), fixed(s.p[2] * 1e3, 1),
      fixed(std::sqrt(s.force[0] * s.force[0] + s.force[1] * s.force[1] + s.force[2] * s.force[2]), 2),
      fixed(since.force, 2),
      since.samples > 0 ? 100.0 * static_cast<double>(since.touching) / static_cast<double>(since.samples) : 0.0,
      duration(since.wake_ns), duration(since.cycle_ns));
}

/** A path that no hand follows would look as if one had gone it. */
void requireFollower(const haptic_device_info& device) {
  const std::string uri = device.uri;
  if (std::string_view(device.driver) != "sim") {
    throw Failure{kExitRefused, device.name, "its hand is not simulated", "name a device of sim://", "UNSUPPORTED"};
  }
  if (uri.find("?motion=") != std::string::npos || uri.find("&motion=") != std::string::npos) {
    throw Failure{kExitRefused, device.name, "its hand has a motion of its own: " + uri,
                  "open one without motion=", "UNSUPPORTED"};
  }
}

/** Where the hand shall be [m]; the simulated hand goes there. */
void lead(const Session& session, const std::array<double, 3>& p) {
  haptic_intent intent{};
  intent.device = session.info().device_index;
  std::copy(p.begin(), p.end(), intent.p);
  intent.q[0] = 1;
  haptic_push push{};
  push.flags = HAPTIC_PUSH_LATEST;
  const int code = haptic_push_intent(session.get(), &intent, &push);
  if (code != HAPTIC_OK && code != HAPTIC_WOULD_BLOCK) check(code, haptic_error HAPTIC_ERROR_INIT);
}

/** Shows what the hand feels: on one live line, or ten times as seldom on lines of their own. */
class Felt {
 public:
  Felt(const Session& session, double end_s, bool lines) : session_(session), end_s_(end_s), lines_(lines) {}

  void look(double t_s) {
    check(haptic_session_check(session_.get()), haptic_error HAPTIC_ERROR_INIT);
    std::uint32_t n = 0;
    std::uint64_t lost = 0;
    if (haptic_session_drain(session_.get(), samples_.data(), static_cast<std::uint32_t>(samples_.size()), &n, &lost) ==
        HAPTIC_OK) {
      for (std::uint32_t i = 0; i < n; ++i) {
        if (samples_[i].device == session_.info().device_index) since_.take(last_ = samples_[i]);
      }
    }
    if (t_s - shown_s_ < (lines_ ? 1.0 : 0.1)) return;
    shown_s_ = t_s;
    const std::string text = describe(t_s, end_s_, last_, since_);
    if (lines_) {
      note(text);
    } else {
      live_.show(text);
    }
    since_ = {};
  }
  void clear() { live_.clear(); }

 private:
  const Session& session_;
  const double end_s_;
  const bool lines_;
  LiveLine live_;
  std::vector<haptic_sample> samples_{1024};
  haptic_sample last_{};
  Since since_;
  double shown_s_ = 0;
};

int play(const HandOptions& options, const Globals& globals) {
  const Interrupt interrupt;
  const Motion motion = Motion::read(options.file);
  const Daemon daemon(globals);
  const Session session(daemon, options.device);
  requireFollower(*session.info().device);
  const double end_s = motion.duration() / options.speed;
  Felt felt(session, end_s, isatty(STDERR_FILENO) == 0 && !globals.json);
  const std::int64_t begin_ns = haptic_now_ns();
  for (std::int64_t tick = 1; !Interrupt::asked(); ++tick) {
    const double t_s = static_cast<double>(haptic_now_ns() - begin_ns) * 1e-9;
    if (!options.loop && t_s > end_s) break;
    lead(session, motion.at(std::fmod(t_s, end_s) * options.speed));
    if (tick % 20 == 0) felt.look(t_s);
    const std::int64_t next_ns = begin_ns + tick * 2'000'000;  // 500 Hz: the hand's spring smooths the rest.
    interrupt.wait(std::chrono::milliseconds((next_ns - haptic_now_ns() + 500'000) / 1'000'000));
  }
  felt.clear();
  haptic_acks acks{};
  if (haptic_session_acks(session.get(), &acks) == HAPTIC_OK && acks.rejected != 0) {
    throw Failure{kExitRefused, options.file,
                  fmt::format("the daemon refused {} of the hand's positions", acks.rejected),
                  haptic_error_text(static_cast<int>(acks.last_rejected_code))};
  }
  if (globals.json)
    putJson({{"device", session.info().device->name}, {"seconds", end_s}, {"rows", motion.rows().size()}});
  return kExitOk;
}

}  // namespace

void addHand(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("hand", "Move the hand of a simulated device along a path from a CSV file");
  auto options = std::make_shared<HandOptions>();
  command
      ->add_option("FILE", options->file,
                   "CSV with columns t,x,y,z (s, m) or t_ms,x_mm,y_mm,z_mm; a recording of monitor --csv will do")
      ->required();
  command->add_option("DEVICE", options->device, "URI, name or serial; without it: the open one");
  command->add_flag("--loop", options->loop, "Repeat until Ctrl-C");
  command->add_option("--speed", options->speed, "How many times as fast as recorded")
      ->capture_default_str()
      ->check(number(0.01, 100.0));
  whenNamed(command, chosen, [options](const Globals& globals) { return play(*options, globals); });
}

}  // namespace hapticctl
