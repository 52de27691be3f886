// hapticd: options, rights, sockets and the order in which they come; the work is in the library.
#include <fmt/format.h>
#include <kj/async-io.h>
#include <sys/random.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/armed/armed_list.h"
#include "daemon/armed/last_resort.h"
#include "daemon/armed/make_safe.h"
#include "daemon/control/core.h"
#include "daemon/leash/find_builder.h"
#include "daemon/main/options.h"
#include "daemon/main/sleep_watch.h"
#include "daemon/main/supervisor.h"
#include "daemon/panel/panel.h"
#include "daemon/rpc/listen_socket.h"
#include "daemon/rpc/server.h"
#include "daemon/version.h"
#include "drivers/registry.h"
#include "rt/base/standard_streams.h"
#include "rt/cycle/realtime.h"

namespace hapticd {
namespace {

int fail(const Error& error, int code) {
  log::error("{}", log::printable(toString(error)));
  return code;
}

/** No start for want of a right, or of what `other_code` says. */
int failStart(Error error, int other_code) {
  if (error.code != ErrorCode::kNoRealtime) return fail(error, other_code);
  error.remedy +=
      "; or pass --allow-no-rt";  // Said here alone: where the note of a start with it goes, it helps nobody.
  return fail(error, kExitNoRealtime);
}

/** As those read it who were not started where we were. */
std::string fromAnywhere(const std::string& file) {
  std::error_code unknown;  // Where we were started may be there no more.
  const auto whole = file.empty() ? std::filesystem::path() : std::filesystem::canonical(file, unknown);
  return unknown ? file : whole.string();
}

std::uint64_t drawEpoch() {
  std::uint64_t epoch = 0;
  while (epoch == 0) {
    if (getrandom(&epoch, sizeof epoch, 0) != sizeof epoch) epoch = static_cast<std::uint64_t>(MonotonicClock().now());
  }
  return epoch;
}

struct Sockets {
  ListenSocket control, admin;
};

/** Those of systemd, else our own. Done first: a second daemon ends here, before it touches a device. */
Result<Sockets> openSockets(const LoadedConfig& loaded) {
  const Config& config = loaded.config;
  Sockets sockets;
  auto activated = activatedSockets();
  if (!activated) return activated.error();
  sockets.control = std::move(activated->control);
  sockets.admin = std::move(activated->admin);
  if (sockets.control.valid()) return sockets;  // systemd's choice of sockets is complete
  if (auto r = checkGroup(loaded); !r) return r.error();
  auto paths = defaultSocketPaths(config.sockets.control, config.sockets.admin);
  if (!paths) return paths.error();
  auto control = ListenSocket::bind(paths->control, config.sockets.mode, config.sockets.group);
  if (!control) return control.error();
  auto admin = ListenSocket::bind(paths->admin, config.sockets.admin_mode, {});
  if (!admin) return admin.error();
  sockets.control = std::move(*control);
  sockets.admin = std::move(*admin);
  return sockets;
}

/**
 * The list of armed devices lies beside the control socket. What a dead daemon has left there is brought to zero first:
 * under systemd hapticd-safe has done it already.
 */
Result<ArmedList> openArmedList(const std::string& control_socket) {
  const std::string path = control_socket.substr(0, control_socket.rfind('/') + 1) + "armed";
  auto list = ArmedList::open(path);
  if (!list && list.error().code == ErrorCode::kDeviceBusy) {
    Error error = list.error();
    error.remedy = "another hapticd has its sockets in this folder: give this one --socket in one of its own";
    return error;
  }
  if (!list) return list;
  for (const MadeSafe& device : makeSafe(list->left(), zeroDevice)) {
    if (device.ok) {
      list->settle(device.uri);
      log::warn("was armed when hapticd died, and is made safe: {}", log::printable(device.uri));
    } else {
      log::error(
          "was armed when hapticd died, and could not be made safe: {}: {} (each start tries again; if it is gone for "
          "good: stop hapticd and delete its line from {})",
          log::printable(device.uri), log::printable(device.text), log::printable(path));
    }
  }
  return list;  // What is not settled stays listed, for hapticd-safe when this daemon ends.
}

/** Before memory is locked, so that the builder starts from a small process. Without it meshes are refused. */
void startBuilder(Core& core) {
  const Config& config = core.config();
  auto program = findBuilder(config.builder.program);
  Result<std::unique_ptr<BuilderLeash>> builder = program ? [&] {
    BuilderOptions options;
    options.program = *program;
    options.memory_bytes = static_cast<std::uint64_t>(config.builder.memory_mb * 1e6);
    options.job_timeout_ns = static_cast<std::int64_t>(config.builder.timeout_s * 1e9);
    return BuilderLeash::start(options);
  }() : Result<std::unique_ptr<BuilderLeash>>(program.error());
  if (builder) return core.uploads().setBuilder(std::move(*builder));
  log::warn("meshes cannot be loaded: {}", toString(builder.error()));
  core.uploads().setBuilder(nullptr, toString(builder.error()));
}

/** How OpenVDB files are made of built volumes, if they are wanted and the program for it is installed. */
std::optional<VdbOptions> openVdbOptions(const Config::Builder& config) {
  const auto builder = findBuilder(config.program);
  if (!config.vdb || !builder) return {};
  VdbOptions options;
  options.program = *builder + "-vdb";
  options.memory_bytes = static_cast<std::uint64_t>(config.memory_mb * 1e6);
  options.timeout_ns = static_cast<std::int64_t>(config.timeout_s * 1e9);
  if (::access(options.program.c_str(), X_OK) == 0) return options;
  log::info("volumes are kept without OpenVDB files: {} is not installed", options.program);
  return {};
}

/** Built volumes are kept where the configuration says, else where systemd says, else nowhere. */
void openVolumeCache(Core& core) {
  const auto& options = core.config().builder;
  std::string directory = options.cache;
  if (const std::string state = serviceFolder("STATE_DIRECTORY"); directory.empty() && !state.empty())
    directory = state + "/volumes";
  if (directory.empty() || options.cache_mb <= 0) return;
  core.uploads().setCache(std::make_unique<VolumeCache>(directory, static_cast<std::uint64_t>(options.cache_mb * 1e6),
                                                        openVdbOptions(options)));
}

/** Memory of the real-time threads. */
Result<void> lockPages(Core& core) {
  if (!core.config().servo.lock_memory) {
    core.facts().memory_note = "servo.lock_memory is off";
    return {};
  }
  if (auto r = lockMemory(); !r) {
    core.facts().memory_note = toString(r.error());
    if (!core.config().servo.allow_no_rt) return r;
    log::warn("memory is not locked: {}", core.facts().memory_note);
    return {};
  }
  core.facts().memory_locked = true;
  return {};
}

/** The configured lines, before any servo: each then starts with what they say. */
Result<std::unique_ptr<Panel>> startPanel(Core& core, Clock& clock) {
  const Config& config = core.config();
  if (config.lines.empty()) return std::unique_ptr<Panel>();
  auto lines = openLines(lineRequests(config.lines));
  if (!lines) return lines.error();
  auto panel = std::make_unique<Panel>(config.lines, std::move(*lines), core.lines(), clock.now());
  if (auto r = panel->start(static_cast<int>(config.servo.gpio_priority), config.servo.allow_no_rt, clock); !r)
    return r.error();
  log::info("{} GPIO lines", config.lines.size());
  return panel;
}

/**
 * The signals that end the daemon in good order. Not SIGHUP where nohup has it ignored: who closes the terminal then
 * wants it to go on. Before any thread: they inherit the mask.
 */
std::vector<int> captureEndings() {
  std::vector<int> endings{SIGTERM, SIGINT};
  struct sigaction hang_up {};
  if (sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN) endings.push_back(SIGHUP);
  for (const int each : endings) kj::UnixEventPort::captureSignal(each);
  return endings;
}

Error fromLoop(const std::string& where, const kj::Exception& thrown) {
  const bool run_out = thrown.getType() == kj::Exception::Type::OVERLOADED;
  return {run_out ? ErrorCode::kSystem : ErrorCode::kInternal, where, thrown.getDescription().cStr(),
          run_out ? "end programs, or raise LimitNOFILE= or ulimit -n, or MemoryMax=" : ""};
}

/** Where it fails nobody is to connect and wait: whoever calls closes the socket, or ends. */
Result<void> serve(const ListenSocket& socket, ControlServer& server, bool administration) {
  if (!socket.valid()) return {};
  auto fd = socket.share();
  if (!fd) {
    Error error = fd.error();
    error.where = socket.path();
    return error;
  }
  Result<void> served;
  KJ_IF_MAYBE (thrown, kj::runCatchingExceptions([&] { server.serve(std::move(*fd), administration); })) {
    served = fromLoop(socket.path(), *thrown);
  }
  return served;
}

/** In place of one that somebody has removed. Where it fails it stays lost. */
Result<void> makeAnew(ListenSocket& socket, ControlServer& server, bool administration) {
  if (auto r = socket.renew(); !r) return r;
  auto served = serve(socket, server, administration);
  if (!served) socket.close();
  return served;
}

/** Makes anew what somebody has removed: else nobody could reach the daemon any more, not even to stop a device. */
void keepReachable(Sockets& sockets, ControlServer& server, log::RateLimit& failures, std::int64_t now_ns) {
  for (const auto& [socket, administration] : {std::pair{&sockets.control, false}, {&sockets.admin, true}}) {
    if (!socket->lost()) continue;
    const auto made = makeAnew(*socket, server, administration);
    std::uint64_t suppressed = 0;
    if (made) {
      log::warn("{} was removed: it is made anew", log::printable(socket->path()));
    } else if (failures.allow(now_ns, suppressed)) {
      log::error("{} was removed and cannot be made anew: {}{}", log::printable(socket->path()),
                 log::printable(toString(made.error())), log::suppressedNote(suppressed));
    }
  }
}

/** The list of armed devices too: without it nobody would make them safe if the daemon died. */
void keepListed(Core& core, log::RateLimit& failures, std::int64_t now_ns) {
  const auto kept = core.armedList().keep();
  std::uint64_t suppressed = 0;
  if (kept && *kept) {
    log::warn("the list of armed devices was removed or edited: it is written anew");
  } else if (!kept && failures.allow(now_ns, suppressed)) {
    log::error("the list of armed devices is not found and cannot be written anew: {}{}",
               log::printable(toString(kept.error())), log::suppressedNote(suppressed));
  }
}

/** Serves until a signal ends it, then brings every force to zero. Not at all where it cannot serve. */
Result<void> run(kj::AsyncIoContext& io, kj::Promise<siginfo_t> ended, Core& core, Sockets& sockets,
                 const Panel* panel) {
  Supervisor supervisor(core, true);
  SleepWatch sleep(core);
  ControlServer server(core, *io.lowLevelProvider, io.provider->getTimer());
  bool told = false;
  constexpr std::int64_t kLook_ns = 1'000'000'000;
  std::int64_t look_ns = core.now() + kLook_ns;
  log::RateLimit failures{60'000'000'000, 2}, unlisted{60'000'000'000, 2};
  server.onStep([&] {
    if (const std::int64_t now_ns = core.now(); now_ns >= look_ns) {
      look_ns = now_ns + kLook_ns;
      keepReachable(sockets, server, failures, now_ns);
      keepListed(core, unlisted, now_ns);
    }
    supervisor.step();
    sleep.step();
    if (panel != nullptr && panel->lost() && !std::exchange(told, true))
      log::error("a GPIO line is lost: the emergency stop counts as open until hapticd is started again");
  });
  if (auto r = serve(sockets.control, server, false); !r) return r;
  if (auto r = serve(sockets.admin, server, true); !r) return r;
  const siginfo_t info = ended.wait(io.waitScope);
  log::info("SIG{}: stopping", sigabbrev_np(info.si_signo));
  supervisor.stopping();
  core.beginShutdown();
  server.closeAll();  // sessions end, leases with them
  const std::int64_t since = core.now();
  while (!core.quiet(since)) io.provider->getTimer().afterDelay(2 * kj::MILLISECONDS).wait(io.waitScope);
  return {};
}

/** `code`; but threads that are inside a driver end only with the process: then it ends here. */
int closeAll(Core& core, int code) {
  const auto left = core.closeAll();
  if (left.empty()) return code;
  for (const std::string& uri : left)
    log::error("{}: its driver does not come back; hapticd ends without it", log::printable(uri));
  std::_Exit(code);  // The list of armed devices stays for hapticd-safe.
}

/**
 * Takes what the user may have: the kernel asks for soft limits, while who grants them, and doctor, speak of the hard
 * ones. Connections, sessions, meshes and Regions of many users are more than the 1024 descriptors that select() is
 * content with.
 */
void raiseLimits() {
  constexpr rlim_t kDescriptors = 65536;
  for (const auto& [what, enough] :
       {std::pair{RLIMIT_NOFILE, kDescriptors}, {RLIMIT_RTPRIO, RLIM_INFINITY}, {RLIMIT_MEMLOCK, RLIM_INFINITY}}) {
    rlimit limit{};
    if (getrlimit(what, &limit) != 0 || limit.rlim_cur >= enough) continue;
    limit.rlim_cur = std::min(limit.rlim_max, enough);
    (void)setrlimit(what, &limit);
  }
}

int start(const Options& options) {
  const Config& config = options.loaded.config;
  log::start(config.log.level);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // A log that may not grow is no reason to let go of devices.
  // Nor does Ctrl-Z stop it: nobody would take the force off its devices then.
  for (const int stop : {SIGTSTP, SIGTTIN, SIGTTOU}) std::signal(stop, SIG_IGN);
  raiseLimits();
  installLastResort();
  const auto endings = captureEndings();
  // Never destroyed: what was under way when its client was cut off lives in the loop, and asks the Core as it goes.
  static kj::AsyncIoContext& io = *new kj::AsyncIoContext(kj::setupAsyncIo());
  log::info("hapticd {}, configuration: {}", kVersion, options.loaded.file.empty() ? "built in" : options.loaded.file);
  if (const auto folders = checkFolders(options.loaded); !folders)
    log::warn("{}", log::printable(toString(folders.error())));

  auto sockets = openSockets(options.loaded);
  if (!sockets) return fail(sockets.error(), kExitSocket);
  auto armed = openArmedList(sockets->control.path());
  if (!armed) return fail(armed.error(), kExitFailure);

  MonotonicClock clock;
  CpuLatencyHold latency;
  CoreOptions core_options;
  core_options.config = config;
  core_options.epoch = drawEpoch();
  core_options.devices_required = options.devices_named;
  Core core(core_options, clock);
  core.keepArmed(std::move(*armed));
  core.facts().config_file = fromAnywhere(options.loaded.file);
  core.facts().control_socket = sockets->control.path();
  core.facts().admin_socket = sockets->admin.path();
  startBuilder(core);
  openVolumeCache(core);
  if (config.servo.hold_cpu_latency) {
    const auto held = latency.hold();
    core.facts().cpu_latency_held = held.ok();
    if (!held) core.facts().cpu_latency_note = toString(held.error());
  }
  auto panel = startPanel(core, clock);
  if (!panel) return failStart(panel.error(), kExitDevice);
  auto ended = io.unixEventPort.onSignal(endings.front());
  for (const int other : std::span(endings).subspan(1)) ended = ended.exclusiveJoin(io.unixEventPort.onSignal(other));
  if (auto r = core.openConfigured([&] { return !ended.poll(io.waitScope); }); !r)
    return closeAll(core, failStart(r.error(), kExitDevice));
  if (auto r = lockPages(core); !r) return closeAll(core, failStart(r.error(), kExitNoRealtime));
  if (auto r = run(io, kj::mv(ended), core, *sockets, panel->get()); !r)
    return closeAll(core, fail(r.error(), kExitSocket));
  closeAll(core, kExitFailure);
  log::info("stopped");
  return kExitOk;
}

}  // namespace
}  // namespace hapticd

int main(int argc, char** argv) {
  using namespace hapticd;  // NOLINT(google-build-using-namespace)
  holdStandardStreams();
  int exit_code = kExitOk;
  const auto options = readOptions(argc, argv, exit_code);
  if (!options) return exit_code;
  if (options->print_config) return answer(toToml(options->loaded.config));
  if (options->check_config)
    return answer((options->loaded.file.empty() ? "built-in configuration" : options->loaded.file) + ": good\n");
  try {
    return start(*options);
  } catch (const kj::Exception& e) {
    return fail(fromLoop("the control loop", e), kExitFailure);
  } catch (const std::exception& e) {
    log::error("{}", log::printable(e.what()));
  }
  return kExitFailure;
}
