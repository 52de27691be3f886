#include "daemon/session/session_manager.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>

#include "daemon/log/log.h"
#include "rt/ring/state.h"

namespace hapticd {
namespace {

Command sessionCommand(CommandKind kind, const Session& session) {
  return makeCommand(kind, SessionRef{session.slot, 0, session.id});
}

bool isInUse(const Session& session) {
  return session.state == Session::State::kOffered || session.state == Session::State::kAdding ||
         session.state == Session::State::kLive;
}

}  // namespace

SessionManager::~SessionManager() = default;

Result<Session*> SessionManager::open(OpenDevice& device, const Client& client, std::int64_t now_ns) {
  if (countOf(client.uid) >= options_.per_user) {
    return Error{ErrorCode::kQuotaExceeded, "session",
                 fmt::format("user {} has {} session{}, the most allowed", client.uid, options_.per_user,
                             options_.per_user == 1 ? "" : "s"),
                 "end one, or raise quotas.sessions in the configuration"};
  }
  if (hooks_.quota) {
    if (auto r = hooks_.quota(client.uid, kSessionBytes); !r) return r.error();
  }
  std::array<bool, kClientSessions> used{};
  for (const auto& [id, session] : sessions_) {
    if (session->link == device.link) used[session->slot] = true;
  }
  std::uint32_t slot = 0;
  while (slot < kClientSessions && used[slot]) ++slot;
  if (slot == kClientSessions) {
    return Error{
        ErrorCode::kQuotaExceeded, "session",
        fmt::format("the devices of group '{}' have {} sessions, their most", device.link->name(), kClientSessions),
        "wait until a client leaves"};
  }
  RegionIdentity identity;
  identity.epoch = options_.epoch;
  identity.session = next_id_;
  identity.device_count = static_cast<std::uint32_t>(device.link->group().deviceCount());
  identity.period_ns = device.link->group().options().cycle.period_ns;
  auto regions = SessionRegions::create(identity);
  if (!regions) return regions.error();

  auto session = std::make_unique<Session>();
  session->id = next_id_++;
  session->client = client;
  session->device = &device;
  session->link = device.link;
  session->slot = slot;
  session->regions = std::move(*regions);
  session->offered_ns = now_ns;
  Session* raw = session.get();
  sessions_.emplace(raw->id, std::move(session));
  ++device.sessions;
  return raw;
}

Result<void> SessionManager::mapped(std::uint64_t id) {
  Session* session = find(id);
  if (session == nullptr) {
    return Error{ErrorCode::kTimeout, "session", "the handshake took too long or the session has ended",
                 "open a new session"};
  }
  if (session->state != Session::State::kOffered) return {};
  if (auto r = session->regions.sealAndLock(options_.must_lock); !r) {
    end(id, "its memory could not be sealed and locked");
    return r;
  }
  // Release, pairs with the servo's acquire when it takes kAddSession: region A is initialised.
  session->link->group().servo().ports[session->slot].region.store(session->regions.a(), std::memory_order_release);
  session->ticket = session->link->post(sessionCommand(CommandKind::kAddSession, *session));
  session->state = Session::State::kAdding;
  return {};
}

void SessionManager::end(std::uint64_t id, std::string_view why) noexcept {
  Session* session = find(id);
  if (session == nullptr) return;
  try {
    session->why = why;
  } catch (const std::bad_alloc&) {  // Nobody is told why.
  }
  const bool added = session->state != Session::State::kOffered;
  const bool attached = session->state == Session::State::kLive;
  log::info("session {} of '{}' (pid {}) ends: {}", id, log::printable(session->client.name), session->client.pid,
            session->why);
  session->regions.markEnded();
  if (hooks_.ending) hooks_.ending(*session);
  session->state = attached ? Session::State::kEnding : Session::State::kFreeing;
  session->free_sent = !added;  // Nothing is to be given back.
  if (!added) return;
  try {
    if (attached) {
      (void)session->link->post(sessionCommand(CommandKind::kLoseSession, *session));
    } else {
      postFree(*session);
    }
  } catch (const std::bad_alloc&) {  // step() orders it.
  }
}

void SessionManager::postFree(Session& session) {
  session.ticket = session.link->post(sessionCommand(CommandKind::kFreeSession, session));
  session.free_sent = true;
}

void SessionManager::endAllOf(std::uint64_t connection, std::string_view why) noexcept {
  for (const auto& [id, session] : sessions_) {
    if (session->client.connection == connection) end(id, why);
  }
}

void SessionManager::poll(std::int64_t now_ns) {
  for (auto it = sessions_.begin(); it != sessions_.end();) {
    if (step(*it->second, now_ns)) {
      --it->second->device->sessions;
      it = sessions_.erase(it);
    } else {
      ++it;
    }
  }
}

bool SessionManager::step(Session& session, std::int64_t now_ns) {
  GroupLink& link = *session.link;
  Servo& servo = link.group().servo();
  Ingest& ingest = link.group().ingest();
  switch (session.state) {
    case Session::State::kOffered:
      if (now_ns - session.offered_ns > kHandshakeNs) end(session.id, "the client did not map its regions in time");
      return false;
    case Session::State::kAdding: {
      if (!link.passed(session.ticket)) return false;
      IngestOrder order;
      order.kind = IngestOrder::Kind::kAttach;
      order.slot = session.slot;
      order.session = {session.id, session.regions.b(), session.regions.a(),
                       static_cast<std::uint32_t>(link.group().deviceCount())};
      if (!ingest.orders.push(order)) return false;
      session.state = Session::State::kLive;
      log::info("session {} is live on {}", session.id, session.device->name);
      return false;
    }
    case Session::State::kLive:
      return false;
    case Session::State::kEnding: {
      if (!session.detach_sent) {
        IngestOrder order;
        order.kind = IngestOrder::Kind::kDetach;
        order.slot = session.slot;
        session.detach_sent = ingest.orders.push(order);
        return false;
      }
      if (!session.detached) return false;
      // Ingest may have revived the slot between our first loss order and its letting go: the fade that counts starts
      // when the servo has taken that, and nothing can revive it any more. Not before, as the servo takes our orders
      // ahead of ingest's. For a share that fades already the order changes nothing.
      if (!session.fading) {
        if (!ingest.commands.passed(session.said)) return false;
        session.ticket = link.post(sessionCommand(CommandKind::kLoseSession, session));
        session.fading = true;
        return false;
      }
      if (!link.passed(session.ticket)) return false;
      const std::uint64_t tick = servo.counters.tick.load(std::memory_order_relaxed);
      if (!session.fade_started) {
        session.fade_started = true;
        session.fade_tick = tick;
      }
      const CycleConfig& cycle = link.group().options().cycle;
      const auto fade_ticks = static_cast<std::uint64_t>(cycle.loss_fade_ns / cycle.period_ns) + 2;
      if (tick < session.fade_tick + fade_ticks) return false;
      postFree(session);
      session.state = Session::State::kFreeing;
      return false;
    }
    case Session::State::kFreeing:
      if (!session.free_sent) postFree(session);
      if (!link.passed(session.ticket)) return false;
      servo.ports[session.slot].region.store(nullptr, std::memory_order_release);
      return true;
  }
  return false;
}

void SessionManager::report(GroupLink& link, const IngestReport& report) {
  Session* session = bySlot(link, report.slot);
  if (session == nullptr) return;
  switch (report.kind) {
    case IngestReport::Kind::kDetached:
      if (!session->detach_sent) return;
      session->detached = true;
      session->said = link.group().ingest().commands.pushed();
      return;
    case IngestReport::Kind::kViolation:
      log::warn("session {} of '{}' (pid {}) broke the ring's protocol", session->id,
                log::printable(session->client.name), session->client.pid);
      end(session->id, "it broke the ring's protocol");
      return;
    case IngestReport::Kind::kRejected: {
      const auto code = static_cast<ErrorCode>(report.code);
      const std::string what =
          fmt::format("command {}: {}{}", report.seq, describe(code), log::suppressedNote(report.suppressed));
      log::warn("session {} of '{}': refused {}", session->id, log::printable(session->client.name), what);
      if (hooks_.refused) hooks_.refused(*session, code, what);
      return;
    }
    case IngestReport::Kind::kStale:
      log::warn("session {} of '{}' (pid {}): heartbeat is late, its force fades", session->id,
                log::printable(session->client.name), session->client.pid);
      return;
    case IngestReport::Kind::kKinds:
      return;
    case IngestReport::Kind::kAlive:
      log::info("session {}: heartbeat is back", session->id);
      return;
  }
}

Session* SessionManager::find(std::uint64_t id) {
  const auto it = sessions_.find(id);
  return it == sessions_.end() || !isInUse(*it->second) ? nullptr : it->second.get();
}

bool SessionManager::inUse(const OpenDevice& device) const {
  return std::any_of(sessions_.begin(), sessions_.end(),
                     [&](const auto& s) { return s.second->device == &device && isInUse(*s.second); });
}

SessionManager::Ended SessionManager::takeEnded(const GroupLink& link) {
  Ended ended;
  for (auto it = sessions_.begin(); it != sessions_.end();) {
    if (it->second->link != &link || isInUse(*it->second)) {
      ++it;
      continue;
    }
    ended.emplace_back();  // Only then does it count as gone: there may be no memory.
    ended.back() = std::move(it->second);
    --ended.back()->device->sessions;
    it = sessions_.erase(it);
  }
  return ended;
}

Session* SessionManager::bySlot(const GroupLink& link, std::uint32_t slot) {
  for (const auto& [id, session] : sessions_) {
    if (session->link == &link && session->slot == slot) return session.get();
  }
  return nullptr;
}

std::vector<Session*> SessionManager::all() const {
  std::vector<Session*> out;
  for (const auto& [id, session] : sessions_) out.push_back(session.get());
  return out;
}

std::uint64_t SessionManager::bytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& [id, session] : sessions_) {
    if (session->client.uid == uid) sum += session->regions.bytes();
  }
  return sum;
}

std::uint64_t SessionManager::bytes() const {
  std::uint64_t sum = 0;
  for (const auto& [id, session] : sessions_) sum += session->regions.bytes();
  return sum;
}

std::uint32_t SessionManager::countOf(std::uint32_t uid) const {
  std::uint32_t count = 0;
  for (const auto& [id, session] : sessions_) count += session->client.uid == uid ? 1 : 0;
  return count;
}

bool SessionManager::anyEnds(std::uint32_t uid, const GroupLink& link) const {
  return std::any_of(sessions_.begin(), sessions_.end(), [&](const auto& s) {
    return !isInUse(*s.second) && (s.second->client.uid == uid || s.second->link == &link);
  });
}

}  // namespace hapticd
