/** @file
 * The two sockets: accepts connections, knows who is there, gives each its Daemon, and steps the Core.
 */
#pragma once

#include <kj/async-io.h>
#include <kj/async-unix.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>

#include "daemon/control/core.h"
#include "daemon/log.h"
#include "daemon/unique_fd.h"

namespace hapticd {

/** Control thread only, inside its event loop. */
class ControlServer final : private kj::TaskSet::ErrorHandler {
 public:
  ControlServer(Core& core, kj::LowLevelAsyncIoProvider& io, kj::Timer& timer);
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  /** Serves a listening Unix socket. */
  void serve(UniqueFd socket, bool administration);
  /** Called after every step of the Core. */
  void onStep(std::function<void()> f) { after_step_ = std::move(f); }
  /** Ends every connection; for a clean stop. */
  void closeAll();

 private:
  struct Connection;
  struct Listener;
  kj::Promise<void> acceptLoop(Listener& listener);
  void notAccepted(const Listener& listener, const kj::Exception& why);
  kj::Promise<void> stepLoop();
  void accept(kj::AuthenticatedStream stream, bool administration);
  void taskFailed(kj::Exception&& exception) override;

  Core& core_;
  kj::LowLevelAsyncIoProvider& io_;
  kj::Timer& timer_;
  std::function<void()> after_step_;
  std::map<std::uint64_t, std::unique_ptr<Connection>> connections_;
  log::RateLimit refused_log_{10'000'000'000, 3};
  UniqueFd spare_;  ///< Given up for a moment where there is no other descriptor.
  kj::TaskSet tasks_;
};

}  // namespace hapticd
