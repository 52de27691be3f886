// Who may energise a device: the rules of lease, arm, disarm and stop.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <new>

#include "daemon/control/core.h"

namespace hapticd {
namespace {

Error gone() { return {ErrorCode::kTimeout, "session", "the session has ended", "open a new session"}; }

Error notLive() {
  return {ErrorCode::kInvalidArgument, "session", "its regions are not mapped yet", "call mapped() first"};
}

bool live(const Session& session) { return session.state != Session::State::kOffered; }

Result<void> speaksOurLayout(std::uint16_t major, std::uint16_t minor) {
  if (major != HD_SHM_MAJOR || minor > HD_SHM_MINOR) {
    return Error{ErrorCode::kVersionMismatch, "layoutMajor",
                 fmt::format("the client's shared memory layout is {}.{}, the daemon's {}.{}", major, minor,
                             HD_SHM_MAJOR, HD_SHM_MINOR),
                 major < HD_SHM_MAJOR ? "update the client's libhapticclient" : "update hapticd"};
  }
  return {};
}

}  // namespace

Result<Session*> Core::openSession(std::string_view uri, std::uint64_t connection, const std::string& name,
                                   std::uint16_t major, std::uint16_t minor) {
  if (auto speaks = speaksOurLayout(major, minor); !speaks) return speaks.error();
  auto device = openDevice(uri, connection);
  if (!device) return device.error();
  return sessionOn(**device, connection, name);
}

void Core::openSession(std::string_view uri, std::uint64_t connection, const std::string& name, std::uint16_t major,
                       std::uint16_t minor, SessionDone done) {
  if (auto speaks = speaksOurLayout(major, minor); !speaks) return done(speaks.error());
  fulfil({std::string(uri), connection, name, clock_.now() + kRoomNs, std::move(done)});
}

Result<Session*> Core::sessionOn(OpenDevice& device, std::uint64_t connection, const std::string& name) {
  Client by = client(connection);
  if (!name.empty()) by.name = name;
  auto session = sessions_.open(device, by, clock_.now());
  if (session) recordings_.sessionOpens(*device.link, by.uid);
  return session;
}

Result<void> Core::mayHoldLease(std::uint64_t id) {
  Session* session = sessions_.find(id);
  if (session == nullptr) return gone();
  if (!live(*session)) return notLive();
  OpenDevice& device = *session->device;
  if (device.lease == id) return {};
  if (device.lease != 0) {
    const Session* holder = sessions_.find(device.lease);
    return Error{ErrorCode::kLeaseHeld, device.name,
                 holder == nullptr
                     ? "another client holds the lease"
                     : fmt::format("'{}' (pid {}) holds the lease", holder->client.name, holder->client.pid),
                 "ask it to release the lease, or end it"};
  }
  return {};
}

Result<void> Core::acquireLease(std::uint64_t id) {
  if (auto r = mayHoldLease(id); !r) return r;
  Session* session = sessions_.find(id);
  OpenDevice& device = *session->device;
  if (device.lease == id) return {};
  device.releaseClutch();  // One that another client held does not pass on to the new holder.
  device.lease = id;
  log::info("{}: lease to '{}' (pid {})", device.name, log::printable(session->client.name), session->client.pid);
  publish(EventKind::kLeaseTaken, device.name, session->client.name, id);
  return {};
}

Result<void> Core::releaseLease(std::uint64_t id) {
  auto session = leaseHolder(id, "release the lease");
  if (!session) return session.error();
  loseLease(*(*session)->device, "released by its holder");
  return {};
}

void Core::loseLease(OpenDevice& device, std::string_view why) noexcept {
  const std::uint64_t session = std::exchange(device.lease, 0);
  switchOff(device, CommandKind::kDisarm);
  // Let the clutch go: the force is being lowered anyway, and whoever arms next should not find it held.
  try {
    device.releaseClutch();
  } catch (const std::bad_alloc&) {  // With the next lease.
  }
  log::info("{}: lease of session {} ends, disarmed: {}", device.name, session, why);
  publish(EventKind::kLeaseLost, device.name, why, session);
}

Result<Session*> Core::leaseHolder(std::uint64_t id, const char* to_do) {
  Session* session = sessions_.find(id);
  if (session == nullptr) return gone();
  if (session->device->lease == id) return session;
  return Error{ErrorCode::kLeaseRequired, session->device->name, fmt::format("only the lease holder may {}", to_do),
               "acquire the lease first"};
}

Result<void> Core::mayArm(OpenDevice& device) const {
  if (asleep_) {
    return Error{ErrorCode::kWouldBlock, device.name, "the machine goes to sleep", "arm it when the machine is awake"};
  }
  if (stopping_) {  // A client that reconnects quickly must not be ramping up when hapticd ends.
    return Error{ErrorCode::kWouldBlock, device.name, "hapticd stops", "arm it when hapticd is back"};
  }
  if (device.device().calibration() == Calibration::kNeeded || device.device().calibration() == Calibration::kRunning) {
    const std::string& how = device.info().calibration_style;
    return Error{ErrorCode::kUnsupported, device.name, "the device is not calibrated",
                 how.empty() || how == "none" ? "calibrate it, then arm" : how + "; then arm"};
  }
  if (!device.link->acceptingArm(device.index)) {
    return Error{ErrorCode::kTimeout, device.name, "too many orders to arm it wait for the servo",
                 "try again; if it stays so, see hapticctl status"};
  }
  return {};
}

void Core::arm(std::uint64_t id, std::function<void(Result<void>)> done) {
  if (auto r = mayHoldLease(id); !r) return done(r);
  OpenDevice& device = *sessions_.find(id)->device;
  if (auto r = mayArm(device); !r) return done(r);
  const std::string& uri = device.info().uri;
  // All that could fail for want of memory comes before the order: nothing may be armed that is not listed and watched.
  std::list<PendingArm> arm(1);
  std::vector<Listed> listed;
  listed.reserve(listed_.size() + 1);
  std::copy_if(listed_.begin(), listed_.end(), std::back_inserter(listed),
               [&](const Listed& other) { return other.uri != uri; });
  listed.push_back({uri, 0});
  if (auto r = armed_.add(uri); !r) return done(r);
  const bool takes = device.lease != id;
  try {
    (void)acquireLease(id);  // It may, as was just found.
    listed.back().ticket = device.link->post(makeCommand(CommandKind::kArm, DeviceRef{device.index}));
  } catch (const std::bad_alloc&) {
    if (takes && device.lease == id) loseLease(device, "no memory");
    if (std::ranges::find(listed_, uri, &Listed::uri) == listed_.end()) armed_.remove(uri);
    throw;
  }
  arm.front() = {id, listed.back().ticket, clock_.now(), takes, std::move(done)};
  listed_ = std::move(listed);
  arms_.splice(arms_.end(), arm);
}

void Core::pollArms() {
  std::list<PendingArm> waiting, one;
  waiting.swap(arms_);  // done() may arm again
  while (!waiting.empty()) {
    one.splice(one.end(), waiting, waiting.begin());
    bool settled = true;
    try {
      settled = settle(one.front(), waiting);
    } catch (const std::bad_alloc&) {
      refuse(one.front());
    }
    if (settled) {
      one.clear();
    } else {
      arms_.splice(arms_.end(), one);
    }
  }
}

/** There is no memory for its answer: nobody is to have armed it without knowing. */
void Core::refuse(PendingArm& arm) noexcept {
  const Session* const session = sessions_.find(arm.session);
  if (session != nullptr && session->device->lease == arm.session) {
    if (arm.took_lease) {
      loseLease(*session->device, "no memory");
    } else {
      switchOff(*session->device, CommandKind::kDisarm);
    }
  }
  try {
    arm.done(Aside::noMemory());
  } catch (const std::bad_alloc&) {  // It hears so when its answer goes.
  }
}

bool Core::settle(PendingArm& arm, std::list<PendingArm>& others) {
  const Session* session = sessions_.find(arm.session);
  if (session == nullptr) {
    arm.done(gone());
    return true;
  }
  OpenDevice& device = *session->device;
  hd_sample sample;
  if (device.link->passed(arm.ticket) && device.link->latest(device.index, sample)) {
    if (sample.fault != HD_FAULT_NONE) {
      if (arm.took_lease && device.lease == arm.session) loseLease(device, "it could not be armed");
      arm.done(Error{ErrorCode::kFaultLatched, device.name,
                     fmt::format("the cause is still there: {}", faultText(sample.fault)),
                     sample.fault == HD_FAULT_OVERRUN ? "see hapticctl doctor, then arm again"
                                                      : "clear the cause, then arm again"});
    } else if (device.lease != arm.session) {
      arm.done(Error{ErrorCode::kLeaseRequired, device.name, "the lease was lost meanwhile", {}});
    } else if ((sample.flags & HD_SAMPLE_ARMED) == 0) {
      const auto later = std::ranges::find(others, arm.session, &PendingArm::session);
      if (arm.took_lease && later != others.end()) {
        later->took_lease = true;  // It has been ordered again since.
      } else if (arm.took_lease) {
        loseLease(device, "it was disarmed before it was armed");
      }
      arm.done(Error{ErrorCode::kCancelled, device.name, "it was disarmed meanwhile", {}});
    } else {
      arm.done({});
    }
    return true;
  }
  if (clock_.now() - arm.since_ns <= kArmAnswerNs) return false;
  // Disarm, or the order might still arm it after this refusal. A lease lost meanwhile has disarmed it already.
  if (device.lease == arm.session) {
    if (arm.took_lease) {
      loseLease(device, "it could not be armed");
    } else {
      switchOff(device, CommandKind::kDisarm);
    }
  }
  arm.done(Error{ErrorCode::kTimeout, device.name, "the servo did not answer", "see hapticctl status"});
  return true;
}

/** A device leaves the list when it has been off for a while, its driver's own thread included, or is closed. */
void Core::pollListed() {
  const std::int64_t now = clock_.now();
  const auto off = [&](Listed& listed) {
    if (devices_.isClosing(listed.uri)) return false;  // only its driver knows whether it is at zero
    const auto device = devices_.find(listed.uri);
    if (!device) return true;  // closed, and so made safe
    hd_sample sample;
    const OpenDevice& open = **device;
    if (!open.link->passed(listed.ticket) || !open.link->latest(open.index, sample)) return false;
    if ((sample.flags & HD_SAMPLE_ARMED) != 0 || !open.device().isOff()) {
      listed.off_ns = 0;
      return false;
    }
    if (listed.off_ns == 0) listed.off_ns = now;
    return now - listed.off_ns >= kListedAfterDisarm_ns;
  };
  const auto gone = std::partition(listed_.begin(), listed_.end(), [&](Listed& listed) { return !off(listed); });
  for (auto it = gone; it != listed_.end(); ++it) armed_.remove(it->uri);
  listed_.erase(gone, listed_.end());
}

Result<void> Core::disarm(std::uint64_t id) {
  const Session* const by = sessions_.find(id);
  if (by != nullptr && by->device->lease == 0) return {};  // It is off, or goes off: who ends may say so twice.
  auto session = leaseHolder(id, "disarm it; anybody may stop it");
  if (!session) return session.error();
  switchOff(*(*session)->device, CommandKind::kDisarm);
  return {};
}

Result<void> Core::stop(std::string_view uri, std::uint64_t connection) {
  const Client& by = client(connection);
  const auto end = [&](OpenDevice& device) noexcept {  // It needs no memory.
    switchOff(device, CommandKind::kStop);
    if (std::uint64_t suppressed = 0; stopped_log_.allow(clock_.now(), suppressed)) {
      log::warn("{}: stopped by '{}' (pid {}){}", device.name, log::printable(by.name), by.pid,
                log::suppressedNote(suppressed));
    }
  };
  if (uri.empty()) {
    for (const auto& device : devices_.devices()) end(*device);
    return {};
  }
  auto device = devices_.find(uri);
  if (!device) return device.error();
  end(**device);
  return {};
}

void Core::setAsleep(bool asleep) {
  if (asleep == asleep_) return;
  asleep_ = asleep;
  if (!asleep) return log::info("the machine is awake");
  log::info("the machine goes to sleep");
  for (const Listed& listed : listed_) {
    const auto device = devices_.find(listed.uri);
    if (!device) continue;  // Closed, or closing.
    log::warn("{}: stopped, for the machine goes to sleep", (*device)->name);
    switchOff(**device, CommandKind::kStop);
  }
}

/** Disarm and stop overtake everything, and no arming that they overtake comes after them. */
void Core::switchOff(OpenDevice& device, CommandKind kind) noexcept {
  if (!device.link->switchOff(device.index, kind, clock_.now())) bypass(device);
}

/** A servo that does not take such an order does not come back from a driver, or has died. */
void Core::pollOffs() {
  for (const auto& device : devices_.devices()) {
    const std::int64_t since_ns = device->link->offSince(device->index);
    if (since_ns == 0 || device->bypassed_ns == since_ns || clock_.now() - since_ns < kOffTaken_ns) continue;
    device->bypassed_ns = since_ns;
    bypass(*device);
  }
}

void Core::bypass(OpenDevice& device) noexcept {
  if (std::uint64_t suppressed = 0; bypassed_log_.allow(clock_.now(), suppressed)) {
    log::error("{}: the servo takes no order at the moment; the device is made safe without it{}", device.name,
               log::suppressedNote(suppressed));
  }
  device.link->group().device(device.index).safe();
}

}  // namespace hapticd
