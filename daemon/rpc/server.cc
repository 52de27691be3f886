#include "daemon/rpc/server.h"

#include <capnp/rpc-twoparty.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

#include "daemon/rpc/answered_stream.h"
#include "daemon/rpc/question_limit.h"
#include "daemon/rpc/servers.h"
#include "daemon/rpc/stop_only_server.h"

namespace hapticd {
namespace {

constexpr std::uint64_t kMessageWords = 128 * 1024;  ///< 1 MiB: the largest request; meshes go by shared memory.
constexpr int kMessageNesting = 16;
constexpr std::size_t kReserveBytes = 256 * 1024;
constexpr int kMostTurnedAway = 64;             ///< At a time: as many as the backlog holds.
constexpr int kIdleSteps = 2;                   ///< Of a former socket: in one, who is accepted may not be served yet.
constexpr std::size_t kFlowWords = 128 * 1024;  ///< Requests under way of one client before its reading pauses.

capnp::ReaderOptions readerOptions() {
  capnp::ReaderOptions options;
  options.traversalLimitInWords = kMessageWords;
  options.nestingLimit = kMessageNesting;
  return options;
}

/** Invalid if no more can be had. */
UniqueFd spareDescriptor() { return UniqueFd(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

/** In a listening socket, to be accepted. */
bool somebodyWaits(int socket) {
  pollfd look{socket, POLLIN, 0};
  return ::poll(&look, 1, 0) == 1;
}

}  // namespace

/** One client. Its capabilities go with it. */
struct ControlServer::Connection {
  // maxFdsPerMessage bounds sending as well as receiving in Cap'n Proto 0.9: Session.regions answers with two. A
  // descriptor that a client sends is closed with its message; nobody takes it.
  static constexpr unsigned kDescriptors = 2;

  Connection(kj::Own<kj::AsyncIoStream> s, Core& core, std::uint64_t connection)
      : stream(kj::heap<AnsweredStream>(kj::mv(s).downcast<kj::AsyncCapabilityStream>())),
        messages(*stream, [&core, connection] { logHolder(core.client(connection)); }),
        network(messages, kDescriptors, capnp::rpc::twoparty::Side::SERVER, readerOptions()),
        rpc(capnp::makeRpcServer(network, daemonFor(core, connection))) {
    rpc.setFlowLimit(kFlowWords);
  }

  static proto::Daemon::Client daemonFor(Core& core, std::uint64_t connection) {
    if (core.client(connection).stop_only) return kj::heap<StopOnlyServer>(core, connection);
    return kj::heap<DaemonServer>(core, connection);
  }

  static void logHolder(const Client& by) {
    log::warn("client '{}' (pid {}, uid {}) is cut off: it holds more than {} answers (Finish them)",
              log::printable(by.name), by.pid, by.uid, QuestionLimit::kMostOpen);
  }

  kj::Own<kj::AsyncCapabilityStream> stream;
  QuestionLimit messages;
  capnp::TwoPartyVatNetwork network;
  capnp::RpcSystem<capnp::rpc::twoparty::VatId> rpc;
};

ControlServer::ControlServer(Core& core, kj::LowLevelAsyncIoProvider& io, kj::Timer& timer)
    : core_(core), io_(io), timer_(timer), spare_(spareDescriptor()), tasks_(*this) {
  startSteps();
}

ControlServer::~ControlServer() { closeAll(); }

void ControlServer::serve(UniqueFd socket, bool administration) {
  const int fd = socket.release();
  auto receiver = io_.wrapListenSocketFd(
      fd, kj::LowLevelAsyncIoProvider::TAKE_OWNERSHIP | kj::LowLevelAsyncIoProvider::ALREADY_CLOEXEC);
  const auto made = std::make_shared<Listener>(Listener{kj::mv(receiver), fd, administration, false, 0, false, {}});
  listen(made);
  endListeners([&](const Listener& one) { return one.administration == administration && one.former; });
  for (const auto& one : listeners_) one->former = one->former || one->administration == administration;
  listeners_.push_back(made);
}

template <class Is>
void ControlServer::endListeners(Is&& is) {
  listeners_.remove_if([&](const std::shared_ptr<Listener>& one) {
    if (!is(*one)) return false;
    if (one->accepting) one->end->fulfill();  // Then its descriptor goes, too.
    return true;
  });
}

void ControlServer::listen(const std::shared_ptr<Listener>& listener) {
  auto end = kj::newPromiseAndFulfiller<void>();
  listener->end = kj::mv(end.fulfiller);
  listener->accepting = true;
  auto ended = kj::defer([listener] { listener->accepting = false; });
  tasks_.add(acceptLoop(*listener).exclusiveJoin(kj::mv(end.promise)).attach(kj::mv(ended)));
}

void ControlServer::startSteps() {
  stepping_ = true;
  auto ended = kj::defer([this] { stepping_ = false; });
  tasks_.add(stepLoop().attach(kj::mv(ended)));
}

kj::Promise<void> ControlServer::acceptLoop(Listener& listener) {
  // accept() may throw before there is a promise: what it throws must not pass by what follows and end the loop.
  return kj::evalNow([&listener] { return listener.receiver->acceptAuthenticated(); })
      .then([this, &listener](kj::AuthenticatedStream stream) { accept(kj::mv(stream), listener.administration); })
      .catch_([this, &listener](kj::Exception&& exception) -> kj::Promise<void> {
        if (listener.administration && spare_.valid()) {  // Who comes to stop a device finds a descriptor.
          spare_.reset();
          return kj::READY_NOW;
        }
        notAccepted(listener, exception);
        return timer_.afterDelay(100 * kj::MILLISECONDS);  // do not spin
      })
      .then([this, &listener] { return acceptLoop(listener); });
}

/** Out of descriptors, those who wait are let in and out again: else each would wait for an answer until its timeout.
 */
void ControlServer::notAccepted(const Listener& listener, const kj::Exception& why) {
  int turned_away = 0;
  while (turned_away < kMostTurnedAway && !spareDescriptor().valid()) {
    spare_.reset();
    UniqueFd one(::accept4(listener.fd, nullptr, nullptr, SOCK_CLOEXEC));
    const bool came = one.valid();
    one.reset();
    spare_ = spareDescriptor();
    if (!came) break;
    ++turned_away;
  }
  std::uint64_t suppressed = 0;
  if (!refused_log_.allow(core_.now(), suppressed)) return;
  log::warn("a connection was not accepted: {}{}{}", log::printable(why.getDescription().cStr()),
            turned_away == 0 ? "" : " (end clients, or raise LimitNOFILE= or ulimit -n)",
            log::suppressedNote(suppressed));
}

void ControlServer::accept(kj::AuthenticatedStream stream, bool administration) {
  auto* peer = dynamic_cast<kj::LocalPeerIdentity*>(stream.peerIdentity.get());
  if (peer == nullptr) return;  // not a Unix socket: dropped
  const auto credentials = peer->getCredentials();
  KJ_IF_MAYBE (uid, credentials.uid) {
    std::int32_t pid = 0;
    KJ_IF_MAYBE (p, credentials.pid) {
      pid = *p;
    }
    const auto leave = [this](std::uint64_t number) {
      connections_.erase(number);  // drops its capabilities, which ends its sessions
      core_.disconnect(number);
    };
    auto id = core_.connect(pid, *uid, administration);
    if (!id && !administration) {  // No user may block stopping by holding all the places for it.
      if (const auto oldest = core_.clients().oldestToStop(*uid)) {
        leave(*oldest);
        id = core_.connect(pid, *uid, administration);
      }
    }
    if (!id) {
      std::uint64_t suppressed = 0;
      if (refused_log_.allow(core_.now(), suppressed)) {
        log::warn("pid {} is not served: {}{}", pid, toString(id.error()), log::suppressedNote(suppressed));
      }
      return;
    }
    bool served = false;  // Not for want of memory.
    KJ_DEFER(if (!served) leave(*id));
    auto& connection = connections_[*id] = std::make_unique<Connection>(kj::mv(stream.stream), core_, *id);
    tasks_.add(connection->network.onDisconnect().then([leave, number = *id] { leave(number); },
                                                       [](kj::Exception&&) {}));  // It has been ended here.
    served = true;
  }
}

kj::Promise<void> ControlServer::stepLoop() {
  // Whatever fails, the daemon goes on; and what has no memory in the one keeps nothing from the other.
  const Result<void> polled = caught([this]() -> Result<void> {
    core_.poll();
    return {};
  });
  if (!polled) reserve_ = nullptr;
  // A defect that comes again in every step is the watchdog's: it hears nothing more.
  const bool sound = polled || polled.error().code == ErrorCode::kSystem;
  const Result<void> stepped = caught([this, sound]() -> Result<void> {
    if (after_step_ && sound) after_step_();
    if (!spare_.valid()) spare_ = spareDescriptor();
    if (reserve_ == nullptr) reserve_ = std::make_unique<std::byte[]>(kReserveBytes);
    for (const auto& one : listeners_)
      one->idle_steps = one->former && !somebodyWaits(one->fd) ? one->idle_steps + 1 : 0;
    endListeners([](const Listener& one) { return one.idle_steps >= kIdleSteps; });
    for (const auto& listener : listeners_) {
      if (!listener->accepting) listen(listener);
    }
    return {};
  });
  (void)stepped;
  return timer_.afterDelay((core_.busy() ? 1 : 5) * kj::MILLISECONDS).then([this] { return stepLoop(); });
}

void ControlServer::closeAll() {
  while (!connections_.empty()) {
    const std::uint64_t id = connections_.begin()->first;
    connections_.erase(id);
    core_.disconnect(id);
  }
}

/** A loop that has ended, for want of memory, begins again: the step's at once, the others' with its next step. */
void ControlServer::taskFailed(kj::Exception&& exception) {
  reserve_ = nullptr;
  std::uint64_t suppressed = 0;
  if (failed_log_.allow(core_.now(), suppressed)) {
    log::error("control: {}{}", log::printable(exception.getDescription().cStr()), log::suppressedNote(suppressed));
  }
  if (!stepping_) startSteps();
}

}  // namespace hapticd
