/** @file
 * The daemon's control thread, stepped by hand, with methods called as by a client and memory that runs out in them.
 */
#pragma once

#include <capnp/capability.h>
#include <kj/async.h>

#include <chrono>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "daemon/rpc/servers.h"
#include "tests/session/bench.h"
#include "tests/support/shortage.h"

namespace hapticd::test {

/** A capability in whose methods memory is short while there is a shortage. */
class ShortServer final : public capnp::Capability::Server {
 public:
  ShortServer(kj::Own<capnp::Capability::Server> inner, Shortage*& shortage)
      : inner_(kj::mv(inner)), shortage_(shortage) {}

  DispatchCallResult dispatchCall(std::uint64_t interface, std::uint16_t method,
                                  capnp::CallContext<capnp::AnyPointer, capnp::AnyPointer> context) override {
    if (shortage_ == nullptr) return inner_->dispatchCall(interface, method, context);
    const Shortage::Scope scope(*shortage_);
    return inner_->dispatchCall(interface, method, context);
  }

 private:
  kj::Own<capnp::Capability::Server> inner_;
  Shortage*& shortage_;
};

/** Counts the events it hears, and those of which it hears that they are lost. */
class Listener final : public proto::EventListener::Server {
 public:
  explicit Listener(std::uint64_t& heard) : heard_(heard) {}

 protected:
  kj::Promise<void> events(EventsContext context) override {
    heard_ += context.getParams().getEvents().size() + context.getParams().getLost();
    return kj::READY_NOW;
  }

 private:
  std::uint64_t& heard_;
};

/** One client after the other, with everything that a client can hold. */
class ShortDaemon {
 public:
  static constexpr std::uint32_t kUser = 1000;

  ShortDaemon() : wait_scope_(loop_) { come(); }
  ~ShortDaemon() { leave(); }
  ShortDaemon(const ShortDaemon&) = delete;
  ShortDaemon& operator=(const ShortDaemon&) = delete;

  [[nodiscard]] Core& core() { return bench.core; }

  /** Runs `work` as the event loop runs it, while memory is short. */
  template <class Work>
  [[nodiscard]] ErrorCode inLoop(Work&& work) {
    const auto run = [&]() -> Result<void> {
      work();
      return {};
    };
    if (shortage == nullptr) return codeOf(caught(run));
    const Shortage::Scope scope(*shortage);
    return codeOf(caught(run));
  }

  /** The answer's code; kInternal where an exception came to the client. None in ten seconds: kTimeout. */
  template <class Results, class Take>
  ErrorCode ask(capnp::RemotePromise<Results> asked, Take&& take) {
    std::optional<ErrorCode> code;
    auto told = asked
                    .then(
                        [&](capnp::Response<Results>&& response) {
                          code = static_cast<ErrorCode>(response.getStatus().getCode());
                          if (*code == ErrorCode::kOk) take(response);
                        },
                        [&](kj::Exception&&) { code = ErrorCode::kInternal; })
                    .eagerlyEvaluate(nullptr);
    const bool answered = until([&] { return code.has_value(); });
    return answered ? *code : ErrorCode::kTimeout;
  }
  template <class Results>
  ErrorCode ask(capnp::RemotePromise<Results> asked) {
    return ask(kj::mv(asked), [](auto&) {});
  }

  /** A period of each servo; then what the daemon's loop does. */
  void step() {
    for (const auto& link : core().devices().links()) link->group().step();
    if (bench.client) bench.client->producer->heartbeat(bench.clock.now());
    (void)inLoop([this] { core().poll(); });
    wait_scope_.poll();
    for (const auto& device : core().devices().devices()) {
      hd_sample sample{};
      const bool armed = device->link->latest(device->index, sample) && (sample.flags & HD_SAMPLE_ARMED) != 0;
      if (!armed || device->lease != 0) {
        alone_ = 0;
      } else if (++alone_ > 2) {
        ADD_FAILURE() << device->name << " is armed, and nobody holds its lease";
      }
      if (armed) {
        EXPECT_FALSE(core().allOff()) << device->name << " is armed, and not listed";
      }
    }
  }
  template <class Condition>
  bool until(Condition&& condition) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > give_up) return false;
      step();
      if (core().uploads().busy() || core().devices().opening() != 0) std::this_thread::yield();
    }
    return true;
  }

  void come() {
    connection = *core().connect(100, kUser, false);
    daemon = shortened<proto::Daemon>(kj::heap<DaemonServer>(core(), connection));
    scene = shortened<proto::Scene>(kj::heap<SceneServer>(core(), connection));
  }
  /** It has gone, and all it had. */
  void leave() {
    held.clear();
    daemon = nullptr;
    scene = nullptr;
    wait_scope_.poll();
    core().disconnect(connection);
    EXPECT_TRUE(until([this] { return nothingLeft(); })) << left();
    bench.client = nullptr;
  }

  /** A client's methods on its own session, upload, recording. */
  template <class Interface>
  [[nodiscard]] typename Interface::Client shortened(kj::Own<capnp::Capability::Server> server) {
    return capnp::Capability::Client(kj::heap<ShortServer>(kj::mv(server), shortage)).template castAs<Interface>();
  }

  /** What clients leave behind. */
  [[nodiscard]] std::string left() {
    std::string out;
    const auto say = [&](const char* what, std::uint64_t count) {
      if (count != 0) out += fmt::format("{} {}; ", count, what);
    };
    say("sessions", core().sessions().all().size());
    say("uploads", core().uploads().size());
    say("jobs", core().uploads().aside().size() + core().uploads().going().size());
    for (const auto& device : core().devices().devices()) say("sessions counted", device->sessions);
    say("recordings", core().recordings().size());
    say("objects", core().scene().list().size());
    say("textures", core().scene().textures().list().size());
    say("bytes", core().bytesOf(kUser));
    say("devices beyond one", core().devices().devices().size() - 1 + core().devices().opening());
    say("lease", core().devices().devices().front()->lease);
    say("listed as armed", core().allOff() ? 0 : 1);
    say("connections beyond two", core().clients().all().size() - 2);
    say("regions", Clients::kRegionsPerUser - free([&] { return core().clients().regionHandedOut(kUser).ok(); },
                                                   [&] { core().clients().regionDropped(kUser); }));
    const Clients::Subscriber by{kUser, false};
    say("subscriptions",
        Clients::kSubscriptionsPerUser - free([&] { return core().clients().subscriptionOpened(by).ok(); },
                                              [&] { core().clients().subscriptionDropped(by); }));
    return out;
  }
  [[nodiscard]] bool nothingLeft() { return left().empty(); }
  [[nodiscard]] static std::ptrdiff_t descriptors() {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  }

  Bench bench;
  Shortage* shortage = nullptr;
  std::uint64_t connection = 0;
  proto::Daemon::Client daemon = nullptr;
  proto::Scene::Client scene = nullptr;
  std::vector<capnp::Capability::Client> held;
  std::uint64_t heard = 0;

 private:
  static ErrorCode codeOf(const Result<void>& result) { return result ? ErrorCode::kOk : result.error().code; }
  template <class Take, class Drop>
  static std::uint64_t free(Take&& take, Drop&& drop) {
    std::uint64_t count = 0;
    while (take()) ++count;
    for (std::uint64_t i = 0; i < count; ++i) drop();
    return count;
  }

  kj::EventLoop loop_;
  kj::WaitScope wait_scope_;
  int alone_ = 0;  ///< Steps for which a device has been armed without a lease.
};

}  // namespace hapticd::test
