#include "tests/integration/running_daemon.h"

#include <kj/async-io.h>
#include <unistd.h>

#include "daemon/control/core.h"
#include "daemon/leash/find_builder.h"
#include "daemon/rpc/listen_socket.h"
#include "daemon/rpc/server.h"

namespace hapticd::test {

Config RunningDaemon::simulated() {
  Config config;
  config.servo.allow_no_rt = true;
  config.servo.lock_memory = false;
  config.servo.missed_limit = 100'000;  // a busy test machine is no fault
  config.guard.device_stale_ms = 1000;
  config.guard.arm_ramp_ms = 100;
  GroupConfig group;
  group.name = "default";
  group.devices = {"sim://default"};
  group.rate_hz = 1000;
  config.groups = {group};
  return config;
}

RunningDaemon::RunningDaemon(Config config) {
  log::setLevel(log::Level::kError);
  if (pipe(stop_) != 0) std::abort();
  std::promise<void> ready;
  auto up = ready.get_future();
  thread_ = std::thread([this, config = std::move(config), &ready] { run(config, ready); });
  up.get();
}

RunningDaemon::~RunningDaemon() {
  close(stop_[1]);
  thread_.join();
  close(stop_[0]);
}

void RunningDaemon::run(const Config& config, std::promise<void>& ready) {
  MonotonicClock clock;
  CoreOptions options;
  options.config = config;
  options.epoch = 0x1234;
  Core core(options, clock);
  auto io = kj::setupAsyncIo();  // Ends before the Core: what was under way lives in it, and asks the Core as it goes.
  auto control_socket = ListenSocket::bind(control(), 0600, {});
  auto admin_socket = ListenSocket::bind(admin(), 0600, {});
  if (!control_socket || !admin_socket) std::abort();
  core.facts().control_socket = control();
  core.facts().admin_socket = admin();
  if (auto program = findBuilder(HAPTICD_BUILDER_PROGRAM)) {
    BuilderOptions builder;
    builder.program = *program;
    if (auto leash = BuilderLeash::start(builder)) core.uploads().setBuilder(std::move(*leash));
  }
  if (auto opened = core.openConfigured(); !opened) {
    log::error("{}", toString(opened.error()));
    std::abort();
  }
  {
    ControlServer server(core, *io.lowLevelProvider, io.provider->getTimer());
    server.serve(std::move(*control_socket->share()), false);
    server.serve(std::move(*admin_socket->share()), true);
    ready.set_value();
    auto end = io.lowLevelProvider->wrapInputFd(stop_[0]);
    char byte = 0;
    end->tryRead(&byte, 1, 1).wait(io.waitScope);
  }
}

}  // namespace hapticd::test
