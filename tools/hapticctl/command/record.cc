// hapticctl record: keeps the daemon's recording of a device in a file.
#include <CLI/CLI.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/carrier.h"
#include "tools/hapticctl/file/new_file.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"

namespace hapticctl {
namespace {

constexpr std::chrono::seconds kPatience{4};  // For what comes of a daemon that has not said that it stops.

struct RecordOptions {
  std::string file, device;
  bool replace = false;
  double seconds = 0;
};

struct CloseRecording {
  void operator()(haptic_recording* recording) const { haptic_recording_close(recording); }
};

int record(const RecordOptions& options, const Globals& globals) {
  const Interrupt interrupt;
  const Daemon daemon(globals);
  const std::string uri = deviceUri(daemon, options.device);
  NewFile file(options.file, options.replace);
  haptic_error error = HAPTIC_ERROR_INIT;
  haptic_recording* raw = nullptr;
  check(haptic_recording_start(daemon.client(), uri.c_str(), &raw, &error), error);
  const std::unique_ptr<haptic_recording, CloseRecording> recording(raw);
  const std::int64_t begin_ns = haptic_now_ns();
  if (!globals.json) note(fmt::format("recording to {}; Ctrl-C ends it", options.file));

  Carrier carrier(haptic_recording_fd(raw), {[&](const char* data, std::size_t size) { return file.write(data, size); },
                                             [&] { return file.sync(); }});
  while (!Interrupt::asked() && !carrier.over()) {
    if (options.seconds > 0 && static_cast<double>(haptic_now_ns() - begin_ns) * 1e-9 >= options.seconds) break;
    interrupt.wait(std::chrono::milliseconds(20));
  }
  haptic_recording_end* end = nullptr;
  const int code = haptic_recording_stop(raw, &end, &error);
  const Owned<haptic_recording_end> ended(end);
  if (code == HAPTIC_OK || !haptic_connected(daemon.client())) {
    carrier.join();
  } else {
    carrier.end(kPatience);
  }
  try {
    if (carrier.problem() != 0) failWriting(options.file, carrier.problem());
    check(code, error);
  } catch (Failure& failure) {
    if (file.bytes() > 0) {
      const std::string kept = fmt::format("{} holds what came until then", options.file);
      if (globals.json) {  // Its failure is one line.
        failure.remedy += (failure.remedy.empty() ? "" : "; ") + kept;
      } else {
        note(kept);
      }
    }
    throw;
  }
  if (globals.json) {
    putJson({{"file", options.file},
             {"bytes", file.bytes()},
             {"cycles", end->cycles},
             {"lost", end->lost},
             {"reason", end->reason}});
  } else {
    print("{}: {} cycles, {}: {}\n", printable(options.file), grouped(end->cycles), bytes(file.bytes()), end->reason);
  }
  // Not by whether the end was here in time: much may still wait for a slow disk.
  if (std::string_view(end->reason) == "stopped" && end->lost == 0) return kExitOk;
  throw Failure{kExitRefused, options.file, fmt::format("the recording ended by itself: {}", end->reason),
                "the file holds what came until then"};
}

}  // namespace

void addRecord(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("record", "Record all that enters a device's servo and what comes out, until Ctrl-C or --for");
  auto options = std::make_shared<RecordOptions>();
  command->add_option("FILE", options->file, "File to make; haptic-bench replay reads it")->required();
  command->add_option("DEVICE", options->device, "URI, name or serial; without it: the open one");
  command->add_flag("--replace", options->replace, "Replace a file that is there");
  command->add_option("--for", options->seconds, "Stop after so long")->type_name("SECONDS")->check(number(0.001, 1e7));
  whenNamed(command, chosen, [options](const Globals& globals) { return record(*options, globals); });
}

}  // namespace hapticctl
