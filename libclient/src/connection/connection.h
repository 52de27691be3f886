/** @file
 * A connection's own thread, and how other threads have work done on it.
 *
 * All Cap'n Proto objects live on that thread. Handles of the C interface share the Connection; what they keep on its
 * thread (capabilities) is made and destroyed there by run().
 */
#pragma once

#include <capnp/rpc-twoparty.h>
#include <hapticclient/client.h>
#include <kj/async-io.h>
#include <kj/function.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "libclient/src/connection/fork_guard.h"
#include "libclient/src/reply/failure.h"
#include "proto/control.capnp.h"

namespace hapticd::client {

/** The daemon's end, while there is one. Library's thread. */
struct Link {
  Link(kj::Own<kj::AsyncCapabilityStream> stream, OwnDescriptor socket);

  OwnDescriptor socket;  ///< Closed last.
  kj::Own<kj::AsyncCapabilityStream> stream;
  capnp::TwoPartyClient rpc;
  proto::Daemon::Client daemon;
  proto::Scene::Client scene = nullptr;
  bool lost = false;                  ///< The daemon has hung up.
  kj::Promise<void> watch = nullptr;  ///< Until it does.
};

/** Something that the library's thread serves besides calls: a session's heartbeat, a subscription. */
class Dependent {
 public:
  virtual ~Dependent() = default;
  /** The connection is gone. Library's thread. */
  virtual void lost() noexcept {}
  /** Every 20 ms. Library's thread. */
  virtual void beat(std::int64_t /*now_ns*/) noexcept {}
  /** A new connection stands. What the daemon refuses goes to `refusal`. Library's thread. */
  virtual kj::Promise<void> renew(Link& /*link*/, Failure& /*refusal*/) { return kj::READY_NOW; }
};

class Connection {
 public:
  struct Options {
    std::string socket;
    std::string name;
    bool administration = false;
    std::int64_t timeout_ns = 0;
  };
  /** What the daemon said of itself. */
  struct Info {
    std::string version, scheduling_note, socket, config_file;
    std::int32_t pid = 0;
    std::uint16_t major = 0, minor = 0;
    std::uint64_t epoch = 0;
    bool administration = false, realtime = false;
    std::int64_t started_ns = 0;
  };
  /** What the library's thread works with; never touched elsewhere. */
  struct Loop;

  explicit Connection(Options options);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /** Begins the library's thread: once, before all else. What it refuses leaves nothing behind. */
  Failure start();
  /** Searches, connects, shakes hands, renews the dependents. A standing link is left alone. */
  Failure connect();
  /** Drops the link for good. */
  void disconnect();

  /** From the end of the handshake on: before it others would find half a link. */
  [[nodiscard]] bool connected() const noexcept { return connected_.load(std::memory_order_acquire); }
  /** False in a child of the process that made it. Servo-safe. */
  [[nodiscard]] bool ownProcess() const noexcept;
  /** The refusal of that child, else nothing. */
  Failure foreign() const;
  /** Why nothing can be asked of the daemon on this thread now, if so. */
  Failure unreachable() const;
  [[nodiscard]] bool onOwnThread() const noexcept { return std::this_thread::get_id() == thread_.get_id(); }
  [[nodiscard]] const std::string& name() const noexcept { return options_.name; }
  [[nodiscard]] Info info() const;
  /** Counts the links: what was begun over another one than the last is gone. */
  [[nodiscard]] std::uint64_t linkNumber() const noexcept { return link_number_.load(std::memory_order_acquire); }
  void setTimeout(std::int64_t timeout_ns) noexcept;
  [[nodiscard]] std::int64_t timeout() const noexcept { return timeout_ns_.load(std::memory_order_relaxed); }

  /** Has work done with the daemon and waits for it, at most the timeout. An exception becomes a Failure. */
  Failure call(kj::FunctionParam<kj::Promise<void>(Link&)> work);
  /** Has work done on the library's thread whether or not there is a daemon; must be quick and not throw. */
  void run(kj::FunctionParam<void(Loop&)> work) noexcept;

  static void add(Loop& loop, Dependent& dependent);
  static void remove(Loop& loop, Dependent& dependent);

 private:
  Failure refused() const;
  Failure perform(kj::FunctionParam<kj::Promise<void>(Link&)> work);
  /** A link over that socket, which is its own from here on, in place of none. Library's thread; may throw. */
  static void makeLink(Loop& loop, OwnDescriptor socket);
  Failure attach(const std::string& path, OwnDescriptor socket);
  Failure greet(const std::string& path);

  Options options_;
  std::uint32_t process_;
  std::atomic<bool> connected_{false};
  std::atomic<std::int64_t> timeout_ns_;
  std::atomic<std::uint64_t> link_number_{0};
  std::mutex connecting_;
  mutable std::mutex info_mutex_;
  Info info_;
  Loop* loop_ = nullptr;
  kj::Own<const kj::Executor> executor_;
  std::thread thread_;
};

/** The Status of an answer. */
Failure toFailure(proto::Status::Reader status);
/** An exception of the RPC system. */
Failure toFailure(const kj::Exception& exception);

/** Of what was begun over another link: reconnecting, as the broken capability would have it, does not help. */
Failure begunBefore(const char* what, const char* remedy);

/** Of a request that is longer than any that makes sense: the daemon would hang up on it, and sessions would end. */
Failure tooLong(std::uint64_t words);

/**
 * Sends a request; when the daemon has agreed, `use` gets the results. `failure` receives its refusal. Both are kept by
 * reference until the promise is done.
 */
template <class Request, class Use>
kj::Promise<void> ask(Request&& request, Failure& failure, Use&& use) {
  failure = tooLong(request.totalSize().wordCount);
  if (failure) return kj::READY_NOW;
  return request.send().then([&failure, use = std::forward<Use>(use)](auto&& results) mutable {
    failure = toFailure(results.getStatus());
    if (!failure) use(results);
  });
}
template <class Request>
kj::Promise<void> ask(Request&& request, Failure& failure) {
  return ask(std::forward<Request>(request), failure, [](auto&&) {});
}

/** One call to the daemon: `make` gives the request, `use` takes its results. */
template <class Make, class Use>
Failure callDaemon(Connection& connection, Make&& make, Use&& use) {
  Failure refusal;
  Failure broken = connection.call([&](Link& link) { return ask(make(link), refusal, use); });
  return broken ? std::move(broken) : std::move(refusal);
}
template <class Make>
Failure callDaemon(Connection& connection, Make&& make) {
  return callDaemon(connection, std::forward<Make>(make), [](auto&&) {});
}

}  // namespace hapticd::client

/** The handle of client.h. */
struct haptic_client {
  std::shared_ptr<hapticd::client::Connection> connection;
};
