// hapticctl events: what happens, as it happens.
#include <CLI/CLI.hpp>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/external.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct EventsOptions {
  std::vector<std::string> kinds;
  std::uint64_t count = 0;
  double duration_s = 0;
};

std::uint32_t kindBits(const std::vector<std::string>& words) {
  std::vector<std::string> known;
  for (std::uint32_t k = 0; k < HAPTIC_EVENT_KINDS; ++k) known.emplace_back(haptic_event_name(k));
  std::uint32_t bits = 0;
  for (const std::string& word : words) {
    const auto at = std::find(known.begin(), known.end(), word);
    if (at == known.end()) {
      std::string all;
      for (const std::string& kind : known) all += (all.empty() ? "" : ", ") + kind;
      const auto near = suggestions(word, known);
      failUsage("--kinds", fmt::format("'{}' is no kind of event", word),
                (near.empty() ? "" : "did you mean " + near.front() + "? ") + "there is: " + all);
    }
    bits |= 1u << (at - known.begin());
  }
  return bits;
}

void line(const haptic_event& e, std::int64_t start_ns) {
  std::string text =
      fmt::format("{:10.3f}  {:<14}", static_cast<double>(e.t_ns - start_ns) * 1e-9, haptic_event_name(e.kind));
  const auto add = [&](std::string_view word) {
    if (!word.empty()) text += "  " + std::string(word);
  };
  add(e.device);
  add(e.object);
  switch (e.kind) {
    case HAPTIC_EVENT_TOUCH:
    case HAPTIC_EVENT_UNTOUCH:
      add(fmt::format("at {}, {}, {} mm  {} N", fixed(e.point[0] * 1e3, 1), fixed(e.point[1] * 1e3, 1),
                      fixed(e.point[2] * 1e3, 1), fixed(e.force, 2)));
      break;
    case HAPTIC_EVENT_BUTTON:
      add(fmt::format("buttons {:#x}", e.value));
      break;
    case HAPTIC_EVENT_FAULT:
      if (e.text[0] == '\0') add(faultName(e.value));  // Else its text says it in words.
      break;
    case HAPTIC_EVENT_OVERRUN:
      add(fmt::format("{} period{} missed", e.value, e.value == 1 ? "" : "s"));
      break;
    case HAPTIC_EVENT_MODEL_EXPIRED:
      add(fmt::format("slot {}", e.value));
      break;
    default:
      break;
  }
  add(e.text);
  const bool bad = e.kind == HAPTIC_EVENT_FAULT || e.kind == HAPTIC_EVENT_OVERRUN || e.kind == HAPTIC_EVENT_LEASE_LOST;
  for (char& c : text) c = static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  put(styled(bad ? Style::kBad : Style::kPlain, text) + "\n");
}

int follow(const EventsOptions& options, const Globals& globals) {
  const Interrupt interrupt;
  const Daemon daemon(globals);
  haptic_events_options asked = HAPTIC_EVENTS_OPTIONS_INIT;
  asked.kinds = kindBits(options.kinds);
  haptic_error error = HAPTIC_ERROR_INIT;
  haptic_events* opened = nullptr;
  check(haptic_events_open(daemon.client(), &asked, &opened, &error), error);
  const std::unique_ptr<haptic_events, decltype(&haptic_events_close)> events(opened, haptic_events_close);
  const std::int64_t start_ns = haptic_now_ns();
  const auto end_ns = start_ns + static_cast<std::int64_t>(options.duration_s * 1e9);
  std::uint64_t lost = 0;
  for (std::uint64_t n = 0; !Interrupt::asked() && (options.count == 0 || n < options.count);) {
    if (options.duration_s > 0 && haptic_now_ns() >= end_ns) break;
    haptic_event event{};
    event.size = sizeof event;
    const int code = haptic_events_next(events.get(), &event, 50'000'000);
    if (code == HAPTIC_TIMEOUT) {
      flush();
      expectReader();
      continue;
    }
    check(code, error);
    if (globals.json) {
      putJson(toJson(event), true);
    } else {
      line(event, start_ns);
    }
    flush();
    lost = event.lost;
    ++n;
  }
  if (lost != 0) note(fmt::format("hapticctl: {} events lost; follow fewer kinds", lost));
  return kExitOk;
}

}  // namespace

void addEvents(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("events", "Follow touches, buttons, faults, leases, devices, clients");
  auto options = std::make_shared<EventsOptions>();
  command->add_option("--kinds", options->kinds, "Only these, between commas")->delimiter(',')->type_name("KIND,...");
  command->add_option("-n,--count", options->count, "Stop after so many")
      ->type_name("COUNT")
      ->check(number(1, 1e9))
      ->transform(decimal);
  command->add_option("--for,--duration", options->duration_s, "Stop after so long")
      ->type_name("SECONDS")
      ->check(number(0.001, 1e7));
  whenNamed(command, chosen, [options](const Globals& globals) { return follow(*options, globals); });
}

}  // namespace hapticctl
