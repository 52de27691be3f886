/** @file
 * The two sockets: accepts connections, knows who is there, gives each its Daemon, and steps the Core.
 */
#pragma once

#include <kj/async-io.h>
#include <kj/async-unix.h>

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>

#include "daemon/control/core.h"
#include "daemon/ipc/unique_fd.h"
#include "daemon/log/log.h"

namespace hapticd {

/** Control thread only, inside its event loop. */
class ControlServer final : private kj::TaskSet::ErrorHandler {
 public:
  ControlServer(Core& core, kj::LowLevelAsyncIoProvider& io, kj::Timer& timer);
  ~ControlServer();
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  /**
   * Serves a listening Unix socket, in place of the former of its kind: who is connected stays, and who waits there to
   * be accepted is.
   */
  void serve(UniqueFd socket, bool administration);
  /** Called after every step of the Core. */
  void onStep(std::function<void()> f) { after_step_ = std::move(f); }
  /** Ends every connection; for a clean stop. */
  void closeAll();

 private:
  struct Connection;
  struct Listener {
    kj::Own<kj::ConnectionReceiver> receiver;
    int fd;  ///< Of the receiver.
    bool administration;
    bool former = false;                      ///< Nobody finds it any more: it goes when nobody waits in it.
    int idle_steps = 0;                       ///< In a row in which nobody waited in a former one.
    bool accepting = false;                   ///< Its loop goes on,
    kj::Own<kj::PromiseFulfiller<void>> end;  ///< until this is fulfilled.
  };
  void listen(const std::shared_ptr<Listener>& listener);
  template <class Is>
  void endListeners(Is&& is);
  void startSteps();
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
  log::RateLimit refused_log_{10'000'000'000, 3}, failed_log_{10'000'000'000, 3};
  std::list<std::shared_ptr<Listener>> listeners_;  ///< The loop of each has it too.
  std::unique_ptr<std::byte[]> reserve_;            ///< Memory given up so that a loop can begin again.
  bool stepping_ = false;                           ///< Its loop goes on; for want of memory it may not.
  UniqueFd spare_;  ///< Given up for an administrator, or for a moment to turn others away.
  kj::TaskSet tasks_;
};

}  // namespace hapticd
