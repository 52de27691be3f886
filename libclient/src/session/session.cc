#include "libclient/src/session/session.h"

#include <capnp/message.h>

#include <chrono>
#include <thread>

#include "libclient/src/connection/descriptor.h"
#include "libclient/src/connection/loop.h"
#include "libclient/src/reply/convert.h"
#include "rt/ring/shared.h"

using hapticd::client::Connection;
using hapticd::client::Failure;
using hapticd::client::Link;
using hapticd::client::Mapping;
using hapticd::client::Opened;
using hapticd::client::Reply;
namespace client = hapticd::client;
namespace proto = hapticd::proto;

namespace {

/** Maps what a Region capability carries, on the library's thread. */
kj::Promise<void> mapRegion(proto::Region::Client region, std::size_t bytes, bool writable, const char* name,
                            Mapping& mapping, Failure& failure) {
  // The descriptor lives as long as the capability, the mapping longer.
  auto fd = region.getFd();
  return fd.then([bytes, writable, name, &mapping, &failure, keep = kj::mv(region)](kj::Maybe<int> received) {
    KJ_IF_MAYBE (descriptor, received) {
      failure = Mapping::map(*descriptor, bytes, writable, name, mapping);
    } else {
      failure = client::noDescriptor(name);
    }
  });
}

/** Both regions hold what this library was built for. */
Failure checkRegions(const Opened& opened) {
  if (hapticd::headerMatches(opened.a()->header, 'A', opened.map_a.bytes()) &&
      hapticd::headerMatches(opened.b()->header, 'B', opened.map_b.bytes())) {
    return {};
  }
  return {HAPTIC_VERSION_MISMATCH, "shared memory", "has another layout than this library",
          "install hapticd and libhapticclient of the same release"};
}

struct RegionBytes {
  std::size_t a = 0, b = 0;
};

/** Asks the daemon for a session with `session.uri`. */
Failure askSession(haptic_session& session, Opened& fresh, RegionBytes& bytes) {
  const auto make = [&](Link& link) {
    auto request = link.daemon.openSessionRequest();
    request.setUri(session.uri.c_str());
    request.setClientName(session.name.c_str());
    request.setLayoutMajor(HD_SHM_MAJOR);
    request.setLayoutMinor(HD_SHM_MINOR);
    return request;
  };
  return client::callDaemon(*session.connection, make, [&](auto& results) {
    const proto::SessionInfo::Reader info = results.getInfo();
    fresh.capability = results.getSession();
    fresh.id = info.getId();
    fresh.epoch = info.getEpoch();
    fresh.device_index = info.getDeviceIndex();
    fresh.device_count = info.getDeviceCount();
    fresh.period_ns = info.getPeriodNs();
    bytes = {info.getRegionABytes(), info.getRegionBBytes()};
    fresh.device = std::make_unique<capnp::MallocMessageBuilder>();
    fresh.device->setRoot(info.getDevice());
    // A reopening gets the same device: names are given out anew by each daemon, in its devices' order. Parameters that
    // the program did not ask for are the configuration's, and may be others by then.
    const std::string device = info.getDevice().getUri().cStr();
    const bool asks_parameters = session.uri.empty() || session.uri.find('?') != std::string::npos;
    session.uri = asks_parameters ? device : device.substr(0, device.find('?'));
  });
}

/** Maps both regions, which hold what this library was built for. */
Failure mapRegions(Connection& connection, Opened& fresh, const RegionBytes& bytes) {
  if (bytes.a < sizeof(hd_region_a) || bytes.b < sizeof(hd_region_b)) {
    return {HAPTIC_VERSION_MISMATCH, "shared memory", "is smaller than this library expects",
            "install hapticd and libhapticclient of the same release"};
  }
  Failure refusal, bad_a, bad_b;
  Failure broken = connection.call([&](Link&) -> kj::Promise<void> {
    return fresh.capability.regionsRequest().send().then([&](auto&& results) -> kj::Promise<void> {
      refusal = client::toFailure(results.getStatus());
      if (refusal) return kj::READY_NOW;
      return kj::joinPromises(kj::arr(mapRegion(results.getA(), bytes.a, false, "region A", fresh.map_a, bad_a),
                                      mapRegion(results.getB(), bytes.b, true, "region B", fresh.map_b, bad_b)));
    });
  });
  for (Failure* failure : {&broken, &refusal, &bad_a, &bad_b}) {
    if (*failure) return std::move(*failure);
  }
  return checkRegions(fresh);
}

/** All of an opening that can fail. Whatever comes of it, the capability must go on its own thread. */
Failure begin(haptic_session& session, Opened& fresh) {
  RegionBytes bytes;
  if (Failure failure = askSession(session, fresh, bytes)) return failure;
  if (Failure failure = mapRegions(*session.connection, fresh, bytes)) return failure;
  fresh.reader.emplace(fresh.a());
  fresh.producer.emplace(fresh.b(), fresh.a());
  fresh.producer->heartbeat(haptic_now_ns());
  return client::callDaemon(*session.connection, [&](Link&) { return fresh.capability.mappedRequest(); });
}

/** Runs a call on the session's capability that answers with a status alone. */
template <class Make>
int order(haptic_session* session, haptic_error* error, Make&& make) {
  return client::edge(error, [&]() -> Failure {
    if (session == nullptr) return client::badArgument("session", "is null");
    if (Failure failure = session->connection->foreign()) return failure;
    if (session->connection->connected() && session->check() != HAPTIC_OK) {
      return {HAPTIC_DISCONNECTED, "session", "the daemon has ended this session", "call haptic_session_reopen()"};
    }
    return client::callDaemon(*session->connection, [&](Link&) { return make(session->opened->capability); });
  });
}

/**
 * The order to arm may have waited longer than its program was willing to, and be obeyed still, when nobody looks: this
 * one follows it.
 */
void callOff(haptic_session& session) {
  session.connection->run([&](Connection::Loop&) {
    try {
      session.opened->capability.disarmRequest().send().ignoreResult().detach([](kj::Exception&&) {});
    } catch (...) {  // No memory, or the connection has gone, and the session with it.
    }
  });
}

/** Until the servo has published once, so that a program's first look finds something; not longer, if it is stuck. */
void awaitFirstSample(haptic_session& session) {
  constexpr int kLooks = 200;
  constexpr std::chrono::microseconds kLook(250);
  hapticd::StateReader& reader = *session.opened->reader;
  hd_sample sample;
  for (int look = 0; look < kLooks && session.check() == HAPTIC_OK; ++look) {
    if (reader.latest(session.opened->device_index, sample)) return;
    std::this_thread::sleep_for(kLook);
  }
}

}  // namespace

Failure haptic_session::open() {
  auto fresh = std::make_unique<Opened>();
  if (Failure failure = begin(*this, *fresh)) {
    connection->run([&](Connection::Loop&) { fresh->capability = nullptr; });
    return failure;
  }
  connection->run([&](Connection::Loop& loop) {
    if (opened != nullptr) Connection::remove(loop, *this);
    std::swap(opened, fresh);
    if (fresh != nullptr) fresh->capability = nullptr;
    Connection::add(loop, *this);
    alive.store(connection->connected(), std::memory_order_release);
  });
  awaitFirstSample(*this);
  return {};
}

void haptic_session::end() noexcept {
  connection->run([&](Connection::Loop& loop) {
    alive.store(false, std::memory_order_release);
    Connection::remove(loop, *this);
    if (opened != nullptr) opened->capability = nullptr;
  });
}

int haptic_session::check() const noexcept {
  if (!alive.load(std::memory_order_acquire) || !connection->ownProcess()) return HAPTIC_DISCONNECTED;
  return hapticd::loadRelaxed(opened->a()->acks.ended) == 0 ? HAPTIC_OK : HAPTIC_DISCONNECTED;
}

extern "C" {

int haptic_session_open(haptic_client* c, const haptic_session_options* options, haptic_session** session,
                        haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    if (session == nullptr) return client::badArgument("session", "is null");
    haptic_session_options full = HAPTIC_SESSION_OPTIONS_INIT;
    if (options != nullptr) {
      if (Failure bad =
              client::readSized(options, full, offsetof(haptic_session_options, uri), "haptic_session_options")) {
        return bad;
      }
    }
    if (full.flags != 0) {
      return {HAPTIC_UNSUPPORTED, "haptic_session_options.flags", "has bits that are not defined", "set it to 0"};
    }
    auto made = std::make_unique<haptic_session>(c->connection, full.uri == nullptr ? "" : full.uri,
                                                 full.name == nullptr ? c->connection->name() : full.name);
    if (Failure failure = made->open()) return failure;
    *session = made.release();
    return {};
  });
}

void haptic_session_close(haptic_session* session) {
  if (session == nullptr || !session->connection->ownProcess()) return;
  session->end();
  delete session;
}

int haptic_session_reopen(haptic_session* session, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (session == nullptr) return client::badArgument("session", "is null");
    if (Failure failure = session->connection->unreachable()) return failure;  // Before what stands is ended.
    session->end();
    return session->open();
  });
}

int haptic_session_describe(haptic_session* session, haptic_session_info** info, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (session == nullptr) return client::badArgument("session", "is null");
    if (info == nullptr) return client::badArgument("info", "is null");
    if (Failure failure = session->connection->foreign()) return failure;
    if (session->opened == nullptr) return {HAPTIC_DISCONNECTED, "session", "is not open", {}};
    Opened& opened = *session->opened;
    Reply reply;
    auto* to = reply.make<haptic_session_info>();
    to->device = client::convert(opened.device->getRoot<proto::DeviceInfo>().asReader(), reply);
    to->device_index = opened.device_index;
    to->device_count = opened.device_count;
    to->id = opened.id;
    to->epoch = opened.epoch;
    to->period_ns = opened.period_ns;
    *info = reply.release(to);
    return {};
  });
}

int haptic_session_acquire_lease(haptic_session* session, haptic_error* error) {
  return order(session, error, [](auto& capability) { return capability.acquireLeaseRequest(); });
}
int haptic_session_release_lease(haptic_session* session, haptic_error* error) {
  return order(session, error, [](auto& capability) { return capability.releaseLeaseRequest(); });
}
int haptic_session_arm(haptic_session* session, haptic_error* error) {
  const int code = order(session, error, [](auto& capability) { return capability.armRequest(); });
  if (code == HAPTIC_TIMEOUT) callOff(*session);
  return code;
}
int haptic_session_disarm(haptic_session* session, haptic_error* error) {
  return order(session, error, [](auto& capability) { return capability.disarmRequest(); });
}

}  // extern "C"
