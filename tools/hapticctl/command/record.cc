// hapticctl record: keeps the daemon's recording of a device in a file.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/new_file.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"

namespace hapticctl {
namespace {

struct RecordOptions {
  std::string file, device;
  bool replace = false;
  double seconds = 0;
};

struct CloseRecording {
  void operator()(haptic_recording* recording) const { haptic_recording_close(recording); }
};

/** Carries the stream into the file on a thread of its own, on the disk within a second. */
class Carrier {
 public:
  Carrier(int stream, NewFile& file) : stream_(stream), file_(file), thread_([this] { run(); }) {}
  ~Carrier() { join(); }
  Carrier(const Carrier&) = delete;
  Carrier& operator=(const Carrier&) = delete;

  void join() {
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] bool over() const { return over_.load(); }
  [[nodiscard]] int problem() const { return problem_.load(); }  ///< errno of the file, or 0.

 private:
  void run() {
    using Clock = std::chrono::steady_clock;
    std::vector<char> piece(1u << 18);
    auto synced = Clock::now();
    while (problem_ == 0) {
      const ssize_t n = ::read(stream_, piece.data(), piece.size());
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;
      problem_ = file_.write(piece.data(), static_cast<std::size_t>(n));
      // Blocks come four times a second: this is at most 0.75 s after the last.
      if (problem_ == 0 && Clock::now() - synced >= std::chrono::milliseconds(500)) {
        problem_ = file_.sync();
        synced = Clock::now();
      }
    }
    if (problem_ == 0) problem_ = file_.sync();
    over_ = true;
  }

  int stream_;
  NewFile& file_;
  std::atomic<bool> over_{false};
  std::atomic<int> problem_{0};
  std::thread thread_;
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

  Carrier carrier(haptic_recording_fd(raw), file);
  while (!Interrupt::asked() && !carrier.over()) {
    if (options.seconds > 0 && static_cast<double>(haptic_now_ns() - begin_ns) * 1e-9 >= options.seconds) break;
    interrupt.wait(std::chrono::milliseconds(20));
  }
  haptic_recording_end* end = nullptr;
  const bool asked = !carrier.over();
  const int code = haptic_recording_stop(raw, &end, &error);
  const Owned<haptic_recording_end> ended(end);
  if (code == HAPTIC_OK || !haptic_connected(daemon.client())) carrier.join();
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
  if (asked && end->lost == 0) return kExitOk;
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
