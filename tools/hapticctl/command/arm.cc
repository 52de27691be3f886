// hapticctl arm: energises a device for as long as it runs. disarm: takes the energy away in good order. stop: at once.
#include <CLI/CLI.hpp>
#include <chrono>
#include <thread>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct ArmOptions {
  std::string device;
  double seconds = 0;
};

const char* stateOf(const haptic_sample& s) {
  if ((s.flags & HAPTIC_SAMPLE_FAULT) != 0) return "fault";
  if ((s.flags & HAPTIC_SAMPLE_ARMED) == 0 || (s.flags & HAPTIC_SAMPLE_WAITING) != 0) return "waiting";
  return (s.flags & HAPTIC_SAMPLE_RAMPING) != 0 ? "ramping" : "armed";
}

const char* meaningOf(std::string_view state) {
  if (state == "waiting")
    return "waiting: it pushes once the force asked for is small; lift the hand off what it touches";
  if (state == "ramping") return "ramping up: the device pushes";
  return "armed: full force within its limits";
}

void tell(const Globals& globals, const std::string& device, std::string_view state, std::string_view text) {
  if (globals.json) {
    putJson({{"device", device}, {"state", state}, {"text", text}}, true);
  } else {
    const Style style = state == "fault" ? Style::kBad : state == "disarmed" ? Style::kPlain : Style::kGood;
    print("{}: {}\n", device, styled(style, text));
  }
  flush();
}

/** Watches until it is time, the user ends it, the device faults or the daemon goes. */
void hold(const Session& session, const ArmOptions& options, const Globals& globals, const Interrupt& interrupt,
          const std::string& name) {
  constexpr std::int64_t kUsualWait_ns = 100'000'000;  // Of which nothing need be said: it takes four ticks.
  const std::int64_t begin_ns = haptic_now_ns();
  std::string state;
  while (!Interrupt::asked()) {
    check(haptic_session_check(session.get()), haptic_error HAPTIC_ERROR_INIT);
    haptic_sample sample;
    if (haptic_session_latest(session.get(), &sample) == HAPTIC_OK) {
      const std::string_view now = stateOf(sample);
      if (state != now && (now != "waiting" || haptic_now_ns() - begin_ns >= kUsualWait_ns)) {
        state = now;
        if (state == "fault") {
          throw Failure{kExitRefused, name, std::string("fault latched: ") + faultName(sample.fault),
                        "remove its cause, then arm again", "FAULT_LATCHED"};
        }
        tell(globals, name, state, meaningOf(state));
      }
    }
    std::int64_t left_ms = 50;
    if (options.seconds > 0) {
      left_ms = std::min(left_ms,
                         static_cast<std::int64_t>(options.seconds * 1e3) - (haptic_now_ns() - begin_ns) / 1'000'000);
      if (left_ms <= 0) return;
    }
    interrupt.wait(std::chrono::milliseconds(left_ms));
  }
}

/** The order is taken at once, but the force is lowered, and a driver's thread may not come back from its device. */
void awaitOff(const Daemon& daemon, const std::string& name) {
  constexpr std::int64_t kMost_ns = 3'000'000'000;
  for (const std::int64_t begin_ns = haptic_now_ns(); haptic_now_ns() - begin_ns < kMost_ns;
       std::this_thread::sleep_for(std::chrono::milliseconds(10))) {
    const auto status = daemon.ask<haptic_status>(haptic_get_status);
    bool armed = false;
    for (std::uint32_t i = 0; i < status->device_count; ++i)
      armed = armed || (name == status->devices[i]->name && status->devices[i]->armed != 0);
    if (!armed) return;
  }
  throw Failure{kExitRefused, name, "it was told to come to zero, but its driver has not said that it has",
                "let go of the handle and switch the device off; see hapticctl status", "TIMEOUT"};
}

int arm(const ArmOptions& options, const Globals& globals) {
  const Interrupt interrupt;  // Before anything is armed: no signal may fall between.
  const Daemon daemon(globals);
  const Session session(daemon, options.device);
  const std::string name = session.info().device->name;
  session.tell([](haptic_session* s, haptic_error* e) { return haptic_session_arm(s, e); });
  // Should anything below throw, closing the session disarms.
  hold(session, options, globals, interrupt, name);
  session.tell([](haptic_session* s, haptic_error* e) { return haptic_session_disarm(s, e); });
  awaitOff(daemon, name);
  tell(globals, name, "disarmed", "disarmed");
  return kExitOk;
}

int disarm(const std::string& device, const Globals& globals) {
  const Daemon daemon(globals);
  const Session session(daemon, device);
  haptic_sample sample;
  if (haptic_session_latest(session.get(), &sample) == HAPTIC_OK &&
      (sample.flags & (HAPTIC_SAMPLE_ARMED | HAPTIC_SAMPLE_RAMPING)) == 0) {
    awaitOff(daemon, session.info().device->name);
    tell(globals, session.info().device->name, "disarmed", "is not armed");
    return kExitOk;
  }
  haptic_error error = HAPTIC_ERROR_INIT;
  const int code = haptic_session_disarm(session.get(), &error);
  if (code == HAPTIC_LEASE_REQUIRED || code == HAPTIC_LEASE_HELD) {
    throw Failure{kExitRefused, error.where, error.what[0] != '\0' ? error.what : haptic_error_text(code),
                  "the holder disarms it by ending; hapticctl stop takes the force away at once, whoever holds it",
                  "LEASE_REQUIRED"};
  }
  check(code, error);
  awaitOff(daemon, session.info().device->name);
  tell(globals, session.info().device->name, "disarmed", "disarmed");
  return kExitOk;
}

}  // namespace

void addArm(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("arm", "Energise a device until Ctrl-C, SIGTERM or --for; then disarm it");
  auto options = std::make_shared<ArmOptions>();
  command->add_option("DEVICE", options->device, "URI, name or serial; without it: the open one");
  command->add_option("--for", options->seconds, "Disarm after so long")
      ->type_name("SECONDS")
      ->check(number(0.001, 1e7));
  whenNamed(command, chosen, [options](const Globals& globals) { return arm(*options, globals); });
}

void addDisarm(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("disarm", "Disarm a device that nobody else holds");
  auto device = std::make_shared<std::string>();
  command->add_option("DEVICE", *device, "URI, name or serial; without it: the open one");
  whenNamed(command, chosen, [device](const Globals& globals) { return disarm(*device, globals); });
}

void addStop(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("stop", "Zero force at once, latched until armed again. Anybody may");
  auto device = std::make_shared<std::string>();
  command->add_option("DEVICE", *device, "URI, name or serial; without it: every device");
  whenNamed(command, chosen, [device](const Globals& globals) {
    const Daemon daemon(globals);
    // No look-up for "every device": nothing may stand between the word and the stop.
    daemon.tell(haptic_stop, device->empty() ? "" : deviceUri(daemon, *device).c_str());
    tell(globals, device->empty() ? "every device" : *device, "stopped", "stopped; arm again to go on");
    return kExitOk;
  });
}

}  // namespace hapticctl
