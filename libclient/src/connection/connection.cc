#include "libclient/src/connection/connection.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>

#include <future>
#include <system_error>
#include <utility>

#include "libclient/src/connection/fork_guard.h"
#include "libclient/src/connection/loop.h"
#include "libclient/src/connection/patience.h"
#include "libclient/src/connection/socket_search.h"

namespace hapticd::client {
namespace {

constexpr std::int64_t kDefaultTimeoutNs = 5'000'000'000;
/** The daemon takes a client for lost after sessions.stale_after_ms without a heartbeat: 200 by default. */
constexpr auto kHeartbeat = 20 * kj::MILLISECONDS;
/** An answer of the daemon carries at most this many descriptors; a session's two regions are the most. */
constexpr unsigned kDescriptors = 4;

/**
 * Signals are the program's affair. A thread begun while this lives is delivered none; and KJ, which ignores SIGPIPE
 * for the whole process, leaves the program its own setting.
 */
class CallersSignals {
 public:
  CallersSignals() {
    sigset_t all;
    sigfillset(&all);
    sigaction(SIGPIPE, nullptr, &pipe_);
    pthread_sigmask(SIG_SETMASK, &all, &mask_);
  }
  ~CallersSignals() {
    sigaction(SIGPIPE, &pipe_, nullptr);
    pthread_sigmask(SIG_SETMASK, &mask_, nullptr);
  }
  CallersSignals(const CallersSignals&) = delete;
  CallersSignals& operator=(const CallersSignals&) = delete;

 private:
  sigset_t mask_{};
  struct sigaction pipe_ {};
};

Failure notConnected() { return {HAPTIC_DISCONNECTED, "daemon", "not connected", "call haptic_reconnect()"}; }

/** Whether the daemon has closed its end, known to the library's thread or not yet. */
bool hungUp(int fd) {
  pollfd end{fd, POLLRDHUP, 0};
  return poll(&end, 1, 0) > 0 && (end.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

}  // namespace

Failure toFailure(proto::Status::Reader status) {
  if (status.getCode() == HAPTIC_OK) return {};
  return {status.getCode(), status.getWhere().cStr(), status.getWhat().cStr(), status.getRemedy().cStr()};
}

Failure toFailure(const kj::Exception& exception) {
  const char* what = exception.getDescription().cStr();
  switch (exception.getType()) {
    case kj::Exception::Type::DISCONNECTED:
      return {HAPTIC_DISCONNECTED, "daemon", "the connection is gone", "call haptic_reconnect()"};
    case kj::Exception::Type::UNIMPLEMENTED:
      return {HAPTIC_UNSUPPORTED, "daemon", "an older daemon does not know this call", "update hapticd"};
    case kj::Exception::Type::OVERLOADED:
      return {HAPTIC_QUOTA_EXCEEDED, "daemon", what, {}};
    case kj::Exception::Type::FAILED:
      break;
  }
  return {HAPTIC_INTERNAL, "daemon", what, {}};
}

Failure begunBefore(const char* what, const char* remedy) {
  return {HAPTIC_DISCONNECTED, what, "was begun before the daemon was lost", remedy};
}

Failure tooLong(std::uint64_t words) {
  constexpr std::uint64_t kMost_bytes = 128 * 1024;  // The daemon reads 1 MiB; its longest text has 4 KiB.
  if (8 * words <= kMost_bytes) return {};
  return badArgument("request", "is " + std::to_string(8 * words) + " bytes long",
                     "shorten its texts: " + std::to_string(kMost_bytes) + " bytes are the most");
}

Link::Link(kj::Own<kj::AsyncCapabilityStream> over, OwnDescriptor descriptor)
    : socket(std::move(descriptor)),
      stream(kj::mv(over)),
      rpc(*stream, kDescriptors),
      daemon(rpc.bootstrap().castAs<proto::Daemon>()) {}

Connection::Loop::Loop(Connection& owner)
    : connection(owner), io(kj::setupAsyncIo()), stop(kj::newPromiseAndFulfiller<void>()) {}

void Connection::Loop::lose() noexcept {
  connection.connected_.store(false, std::memory_order_release);
  for (Dependent* dependent : dependents) dependent->lost();
}

kj::Promise<void> Connection::Loop::beat() {
  return io.provider->getTimer().afterDelay(kHeartbeat).then([this]() -> kj::Promise<void> {
    const std::int64_t now = haptic_now_ns();
    for (Dependent* dependent : dependents) dependent->beat(now);
    if (dependents.empty()) return kj::READY_NOW;
    return beat();
  });
}

void Connection::add(Loop& loop, Dependent& dependent) {
  loop.dependents.push_back(&dependent);
  if (loop.dependents.size() == 1) loop.heart = loop.beat().eagerlyEvaluate(nullptr);
}

void Connection::remove(Loop& loop, Dependent& dependent) { std::erase(loop.dependents, &dependent); }

Connection::Connection(Options options)
    : options_(std::move(options)),
      process_(forkGeneration()),
      timeout_ns_(patience_ns(options_.timeout_ns, kDefaultTimeoutNs)) {}

Failure Connection::start() {
  const CallersSignals kept;
  const auto begun = std::make_shared<std::promise<Failure>>();  // the thread may still be at it when we have heard
  try {
    thread_ = std::thread([this, begun] {
      pthread_setname_np(pthread_self(), "hapticclient");
      std::unique_ptr<Loop> loop;
      try {
        loop = std::make_unique<Loop>(*this);
        executor_ = kj::getCurrentThreadExecutor().addRef();
      } catch (const kj::Exception& e) {
        return begun->set_value({HAPTIC_SYSTEM, "the library's thread", e.getDescription().cStr(), kFewerDescriptors});
      } catch (...) {
        return begun->set_value(fromException());
      }
      loop_ = loop.get();
      begun->set_value({});
      try {
        loop->stop.promise.wait(loop->io.waitScope);
      } catch (...) {  // whoever calls from now on is told
      }
    });
  } catch (const std::system_error& e) {
    return {HAPTIC_SYSTEM, "the library's thread", std::string("cannot be started: ") + e.what(),
            "raise the user's limit of processes (ulimit -u), or TasksMax= of the service"};
  }
  return begun->get_future().get();
}

Connection::~Connection() {
  if (!thread_.joinable()) return;
  if (loop_ != nullptr) {
    run([](Loop& loop) {
      loop.lose();
      loop.link = nullptr;
      loop.stop.fulfiller->fulfill();
    });
  }
  thread_.join();
}

bool Connection::ownProcess() const noexcept { return process_ == forkGeneration(); }

void Connection::setTimeout(std::int64_t timeout_ns) noexcept {
  timeout_ns_.store(patience_ns(timeout_ns, kDefaultTimeoutNs), std::memory_order_relaxed);
}

Connection::Info Connection::info() const {
  const std::lock_guard lock(info_mutex_);
  return info_;
}

Failure Connection::foreign() const {
  if (ownProcess()) return {};
  return {HAPTIC_DISCONNECTED, "process", "the connection was made before fork()", "connect anew in the child"};
}

Failure Connection::refused() const {
  if (Failure failure = foreign()) return failure;
  if (onOwnThread()) return badArgument("thread", "a callback may not wait for the daemon", "call from another thread");
  return {};
}

Failure Connection::unreachable() const {
  if (Failure failure = refused()) return failure;
  return connected() ? Failure{} : notConnected();
}

void Connection::run(kj::FunctionParam<void(Loop&)> work) noexcept {
  if (!ownProcess()) return;
  if (onOwnThread()) return work(*loop_);
  executor_->executeSync([&] { work(*loop_); });
}

Failure Connection::call(kj::FunctionParam<kj::Promise<void>(Link&)> work) {
  if (Failure failure = unreachable()) return failure;
  bool whole = true;
  Failure failure = perform([&](Link& link) -> kj::Promise<void> {
    whole = connected();  // On this thread it is true of this link: meanwhile one may have gone and another begun.
    if (!whole) return kj::READY_NOW;
    return work(link);
  });
  return whole ? std::move(failure) : notConnected();
}

/** The same on a link whose handshake may be under way. */
Failure Connection::perform(kj::FunctionParam<kj::Promise<void>(Link&)> work) {
  const std::int64_t patience = timeout();
  try {
    const bool answered = executor_->executeSync([&]() -> kj::Promise<bool> {
      if (loop_->link == nullptr) return KJ_EXCEPTION(DISCONNECTED, "no link");
      auto late = loop_->io.provider->getTimer().afterDelay(patience * kj::NANOSECONDS).then([] { return false; });
      return work(*loop_->link).then([] { return true; }).exclusiveJoin(kj::mv(late));
    });
    if (answered) return {};
    return {HAPTIC_TIMEOUT, "daemon", "no answer within " + std::to_string(patience / 1'000'000) + " ms",
            "see whether hapticd runs: hapticctl doctor"};
  } catch (const kj::Exception& exception) {
    return toFailure(exception);
  }
}

void Connection::disconnect() {
  run([](Loop& loop) {
    loop.lose();
    loop.link = nullptr;
  });
}

Failure Connection::connect() {
  if (Failure failure = refused()) return failure;
  const std::lock_guard lock(connecting_);
  if (connected()) {
    run([](Loop& loop) {
      if (loop.link != nullptr && hungUp(loop.link->socket.get())) loop.lose();
    });
  }
  if (connected()) return {};
  const auto paths = candidates(searchHere(options_.socket, options_.administration));
  std::vector<Failure> why;
  for (const std::string& path : paths) {
    OwnDescriptor socket;
    Failure failure = connectTo(path, timeout(), socket);
    if (!failure) {
      failure = attach(path, std::move(socket));
      if (!failure) return {};
      const bool absent = failure.code == HAPTIC_DISCONNECTED || failure.code == HAPTIC_PERMISSION_DENIED;
      if (!absent) return failure;  // Whoever answers there is the one, and refuses.
    } else if (failure.code == HAPTIC_TIMEOUT) {
      return failure;  // One that was stopped is the one, too: another would stop or arm other devices.
    }
    why.push_back(std::move(failure));
  }
  return nobodyAnswers(paths, why);
}

void Connection::makeLink(Loop& loop, OwnDescriptor socket) {
  auto stream = loop.io.lowLevelProvider->wrapUnixSocketFd(
      socket.get(), kj::LowLevelAsyncIoProvider::ALREADY_CLOEXEC | kj::LowLevelAsyncIoProvider::ALREADY_NONBLOCK);
  loop.link = std::make_unique<Link>(kj::mv(stream), std::move(socket));
  loop.connection.link_number_.fetch_add(1, std::memory_order_release);
  Link& link = *loop.link;
  link.watch = link.rpc.onDisconnect()
                   .then([&loop, &link] {
                     link.lost = true;
                     loop.lose();
                   })
                   .eagerlyEvaluate(nullptr);
}

Failure Connection::attach(const std::string& path, OwnDescriptor socket) {
  Failure failure;
  run([&](Loop& loop) {
    try {
      loop.link = nullptr;
      makeLink(loop, std::move(socket));
    } catch (const kj::Exception& e) {  // The kernel may watch no more descriptors for this user.
      failure = {HAPTIC_SYSTEM, path, e.getDescription().cStr(), kFewerDescriptors};
    } catch (...) {
      failure = fromException();
    }
  });
  if (!failure) failure = greet(path);
  if (failure) {
    disconnect();
    if (failure.code == HAPTIC_DISCONNECTED) {
      failure = {HAPTIC_DISCONNECTED, path, "the daemon hung up",
                 "it ends, or has too many clients: try again, or end some; hapticd's log says why"};
    }
  }
  return failure;
}

Failure Connection::greet(const std::string& path) {
  Info info;
  Failure refusal;
  Failure broken = perform([&](Link& link) {
    auto request = link.daemon.helloRequest();
    request.setClientName(options_.name.c_str());
    request.setProtocolMajor(proto::PROTOCOL_MAJOR);
    request.setProtocolMinor(proto::PROTOCOL_MINOR);
    return ask(kj::mv(request), refusal, [&](auto& results) {
      const proto::DaemonInfo::Reader from = results.getInfo();
      info = {from.getVersion().cStr(),
              from.getSchedulingNote().cStr(),
              path,
              from.getConfigFile().cStr(),
              from.getPid(),
              from.getProtocolMajor(),
              from.getProtocolMinor(),
              from.getEpoch(),
              from.getAdministration(),
              from.getRealtime(),
              from.getStartedNs()};
    });
  });
  if (broken) return broken;
  if (refusal) return refusal;
  if (info.major != proto::PROTOCOL_MAJOR) {
    return {HAPTIC_VERSION_MISMATCH, path,
            "the daemon speaks protocol " + std::to_string(info.major) + ", this library " +
                std::to_string(proto::PROTOCOL_MAJOR),
            "install hapticd and libhapticclient of the same release"};
  }
  if (options_.administration && !info.administration) {
    return {HAPTIC_PERMISSION_DENIED, path, "is not the administration socket", "give the path of admin.sock"};
  }
  {
    const std::lock_guard lock(info_mutex_);
    info_ = std::move(info);
  }
  broken = perform([&](Link& link) {
    return ask(link.daemon.sceneRequest(), refusal, [&link](auto& results) { link.scene = results.getScene(); })
        .then([this, &link, &refusal] {
          auto renewals = kj::heapArrayBuilder<kj::Promise<void>>(loop_->dependents.size());
          for (Dependent* dependent : loop_->dependents) renewals.add(dependent->renew(link, refusal));
          return kj::joinPromises(renewals.finish());
        })
        .then([this, &link, &refusal] {
          if (!refusal && link.lost) refusal = {HAPTIC_DISCONNECTED, {}, {}, {}};
          if (!refusal) connected_.store(true, std::memory_order_release);
        });
  });
  return broken ? std::move(broken) : std::move(refusal);
}

}  // namespace hapticd::client
