/** @file
 * haptic-emu: plays a haptic device to the kernel of this machine, with a hand that homes it and presses.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>

#include "rt/base/clock.h"
#include "rt/base/standard_streams.h"
#include "tools/haptic-emu/falcon/falcon_user.h"
#include "tools/haptic-emu/option.h"
#include "tools/haptic-emu/play_hid.h"
#include "tools/haptic-emu/vhci.h"

namespace {

std::atomic<bool> stop{false};
void onSignal(int) { stop.store(true); }

constexpr int kExitFailed = 1, kExitUsage = 2;
constexpr double kLongest_s = 86400;  ///< Between two lines.

struct Options {
  haptic_emu::FalconHabits habits;
  haptic_emu::VhciOptions vhci;
  std::vector<std::string> faults;
  double every_s = 1;
};

int play(const Options& options) {
  haptic_emu::FalconModel model;
  haptic_emu::FalconUser user(model, options.habits);
  hapticd::MonotonicClock clock;
  const std::int64_t start_ns = clock.now();
  for (const std::string& text : options.faults) {
    auto fault = haptic_emu::parseFault(text);
    if (!fault) {
      hapticd::tellError(fmt::format("haptic-emu: {}\n", toString(fault.error())));
      return kExitUsage;
    }
    fault->from_ns += start_ns;
    fault->to_ns = fault->to_ns > INT64_MAX - start_ns ? INT64_MAX : fault->to_ns + start_ns;
    model.faults.add(*fault);
  }
  std::int64_t told = 0;
  const auto played = haptic_emu::playToKernel(model, options.vhci, stop, [&](std::int64_t now_ns) {
    user.act(now_ns);
    if (options.every_s <= 0 || now_ns < told) return;
    told = now_ns + static_cast<std::int64_t>(options.every_s * 1e9);
    const auto& p = model.hand.position();
    const hapticd::Vec3 f = model.force();
    fmt::print(
        "{{\"t_s\": {:.3f}, \"running\": {}, \"homed\": {}, \"lights\": {}, \"orders\": {}, "
        "\"position_m\": [{:.5f}, {:.5f}, {:.5f}], \"force_n\": [{:.4f}, {:.4f}, {:.4f}], \"most_n\": {:.4f}}}\n",
        static_cast<double>(now_ns) * 1e-9, model.running(), model.homed(), model.lights(), model.orders(), p.x(),
        p.y(), p.z(), f.x(), f.y(), f.z(), user.takeMost());
    std::fflush(stdout);
  });
  if (played) return 0;
  hapticd::tellError(fmt::format("haptic-emu: {}\n", toString(played.error())));
  return kExitFailed;
}

void addFaults(CLI::App& one, std::vector<std::string>& faults) {
  one.add_option("--fault", faults, "What goes wrong: KIND@FROM+LENGTH in seconds, several times")
      ->expected(1, 100)
      ->check(haptic_emu::isFault());
}

void addNumber(CLI::App& one, const char* name, double& value, const char* what, std::pair<double, double> range) {
  one.add_option(name, value, what)->capture_default_str()->check(haptic_emu::within(range.first, range.second));
}

void addFalcon(CLI::App& app, Options& o) {
  CLI::App& one = *app.add_subcommand("falcon", "A Novint Falcon; any file will do as its firmware");
  addFaults(one, o.faults);
  addNumber(one, "--press", o.habits.press, "How far the hand goes toward the base and back [m]", {0, 0.03});
  addNumber(one, "--period", o.habits.period_s, "Time of one press, there and back [s]", {0.1, 60});
  one.add_flag("!--no-homing", o.habits.homes, "The hand does not home it when it is asked to");
  one.add_option("--port", o.vhci.port, "Port of vhci_hcd that it is plugged into")
      ->capture_default_str()
      ->check(CLI::Range(0, 7))
      ->transform(hapticd_options::decimal);
  addNumber(one, "--every", o.every_s, "Seconds between two lines; 0 for none", {0, kLongest_s});
}

void addHid(CLI::App& app, haptic_emu::HidPlay& hid, const char* name, const char* what,
            const std::vector<std::string>& kinds) {
  CLI::App& one = *app.add_subcommand(name, what);
  one.add_option("kind", hid.kind, "Which of them; the first unless said")->check(CLI::IsMember(kinds));
  one.add_option("--serial", hid.serial, "Its serial number")->capture_default_str();
  addFaults(one, hid.faults);
  addNumber(one, "--press", hid.press, "How far the hand goes and back [m]", {0, 0.04});
  addNumber(one, "--period", hid.period_s, "Time of one way there and back [s]", {0.1, 60});
  addNumber(one, "--every", hid.every_s, "Seconds between two lines; 0 for none", {0, kLongest_s});
  one.callback([&hid, name] { hid.device = name; });
}

}  // namespace

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): ends the program, as it should
  hapticd::holdStandardStreams();
  CLI::App app{
      "Plays a haptic device to this machine's kernel, packet by packet, with a simulated hand that homes it and\n"
      "presses to and fro. Needs root and the module vhci_hcd or uhid. One JSON line a second tells what the hand\n"
      "feels, in the device's frame (a Falcon's: x right, y up, z toward the operator).",
      "haptic-emu"};
  Options options;
  app.require_subcommand(1);
  addFalcon(app, options);
  haptic_emu::HidPlay hid;
  addHid(app, hid, "woodyhid", "A WoodenHaptics or Polhem arm, by /dev/uhid", {"wooden2015", "polhem3"});
  addHid(app, hid, "spacemouse", "A SpaceMouse whose button 1 is let go every fifth second, by /dev/uhid",
         {"old", "new"});
  addHid(app, hid, "hidpid", "A joystick or wheel with force feedback, by /dev/uhid", {"joystick", "wheel"});
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : kExitUsage;
  }
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
  if (hid.device.empty()) return play(options);
  const auto played = haptic_emu::playHid(hid, stop);
  if (played) return 0;
  hapticd::tellError(fmt::format("haptic-emu: {}\n", toString(played.error())));
  return kExitFailed;
}
