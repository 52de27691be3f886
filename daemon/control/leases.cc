// Who may energise a device: the rules of lease, arm, disarm, stop and limits.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <new>

#include "daemon/control/core.h"
#include "daemon/device/buttons.h"
#include "daemon/device/limits.h"
#include "daemon/device/mount.h"
#include "rt/render/proxy/proxy.h"

namespace hapticd {
namespace {

Error gone() { return {ErrorCode::kTimeout, "session", "the session has ended", "open a new session"}; }

Error notLive() {
  return {ErrorCode::kInvalidArgument, "session", "its regions are not mapped yet", "call mapped() first"};
}

bool live(const Session& session) { return session.state != Session::State::kOffered; }

}  // namespace

namespace {

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

Result<GuardLimits> Core::setLimits(std::string_view uri, const GuardLimits& wanted, std::uint64_t connection) {
  auto found = devices_.find(uri);
  if (!found) return found.error();
  OpenDevice& device = **found;
  auto merged = mergeLimits(device.limits, wanted);
  if (!merged) return merged;
  if (!raises(*merged, device.limits) && !raises(device.limits, *merged)) return *merged;  // It only asks.
  const Client& by = client(connection);
  const Session* holder = device.lease == 0 ? nullptr : sessions_.find(device.lease);
  const bool holds = holder != nullptr && holder->client.uid == by.uid;
  if (!by.administration && raises(*merged, device.limits)) {
    return Error{ErrorCode::kPermissionDenied, device.name, "raising limits needs the administration socket",
                 facts_.admin_socket.empty() ? "" : "connect to " + facts_.admin_socket};
  }
  if (!by.administration && !holds) {
    return Error{ErrorCode::kLeaseRequired, device.name,
                 "lowering limits is for the lease holder's user or administration", "acquire the lease first"};
  }
  if (auto r = checkMaxima(*merged, device.maxima, device.name); !r) return r.error();
  // What is lowered overtakes the edits that wait; what is raised comes after those that were to come first.
  const bool raised = raises(*merged, device.limits);
  if ((raised && !device.link->accepting()) || !device.link->lowerLimits(device.index, *merged)) {
    return Error{ErrorCode::kTimeout, device.name, "the servo takes no more orders now",
                 "try again; see hapticctl status"};
  }
  device.limits = *merged;
  if (raised)
    (void)device.link->post(makeCommand(CommandKind::kDeviceLimits, limitsOrder(device.index, *merged, false)));
  log::info("{}: limits {:g} N, {:g} N m, {:g} m/s by '{}' (pid {})", device.name, merged->force, merged->torque,
            merged->velocity, log::printable(by.name), by.pid);
  return *merged;
}

Result<void> Core::setRadius(OpenDevice& device, double radius, const Client& by) {
  if (!(radius >= 0 && radius <= ProxyRenderer::kMaxRadius)) {
    return Error{ErrorCode::kInvalidArgument, device.name,
                 fmt::format("a ball has a radius of 0 to {:g} m", ProxyRenderer::kMaxRadius), "for example 0.001"};
  }
  if (auto r = mayChange(device, by); !r) return r;
  device.radius = radius;
  device.applyRadius();
  return {};
}

Result<void> Core::setFinger(OpenDevice& device, const SetFinger& finger, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  device.wear(finger, device.info());
  device.applyFinger();
  return {};
}

bool Core::mayBeArmed(const OpenDevice& device) const {
  const std::string& uri = device.info().uri;
  const auto listed = std::ranges::find(listed_, uri, &Listed::uri);
  hd_sample sample;
  return listed != listed_.end() &&
         (!device.link->passed(listed->ticket) || !device.link->latest(device.index, sample) ||
          (sample.flags & HD_SAMPLE_ARMED) != 0);
}

/** Elsewhere, or of another size. */
Result<void> Core::mayBeSetUp(const OpenDevice& device, const std::string& where, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  if (!mayBeArmed(device)) return {};
  return Error{ErrorCode::kWouldBlock, where, "the device is armed, and its hand would jump",
               "disarm it and wait until its force is down"};
}

Result<void> Core::setMount(OpenDevice& device, const Pose& X_WD, const Client& by) {
  const std::string where = device.name + "/mount";
  if (!isFinite(X_WD.p) || !(X_WD.p.cwiseAbs().maxCoeff() <= Mount::kFarthest)) {
    return Error{ErrorCode::kInvalidArgument, where,
                 fmt::format("a place is within {:g} m of the world's origin, by axis", Mount::kFarthest),
                 "for example 0.3,0,0"};
  }
  const double norm = X_WD.q.norm();
  if (!(norm > 1e-6 && norm < 1e6)) {
    return Error{ErrorCode::kInvalidArgument, where, "the quaternion says no turn",
                 "w,x,y,z with a length near 1: 1,0,0,0 is none"};
  }
  if (auto r = mayBeSetUp(device, where, by); !r) return r;
  device.mount = Mount(Pose{X_WD.p, X_WD.q.normalized()}, device.mount.scale());
  device.applyMount();
  const Vec3 turns = toDegrees(device.mount.pose().q);
  log::info("{}: stands at {:g}, {:g}, {:g} m, turned by {:g}, {:g}, {:g} degrees", device.name, X_WD.p.x(), X_WD.p.y(),
            X_WD.p.z(), turns.x(), turns.y(), turns.z());
  return {};
}

Result<void> Core::setClutch(OpenDevice& device, bool held, std::uint32_t button, const Client& by) {
  if (button > 32) {
    return Error{ErrorCode::kInvalidArgument, device.name + "/clutch", fmt::format("there is no button {}", button),
                 "1 is the first; 0 binds none"};
  }
  const std::uint32_t there = buttonsOf(device.info(), &lines_);
  if (button > there && button != device.clutch_button) {
    return Error{ErrorCode::kInvalidArgument, device.name + "/clutch",
                 fmt::format("there is no button {}: it has {}", button, there), "1 is the first; 0 binds none"};
  }
  if (auto r = mayChange(device, by); !r) return r;
  device.clutch_held = held;
  device.clutch_button = button;
  device.applyClutch();
  return {};
}

Result<void> Core::setScale(OpenDevice& device, double scale, const Client& by) {
  const std::string where = device.name + "/scale";
  if (!Mount::validScale(scale)) {
    return Error{ErrorCode::kInvalidArgument, where,
                 fmt::format("a metre of the hand is {:g} to {:g} m of the world, not {:g}", Mount::kLeast,
                             Mount::kLargest, scale),
                 "make the scene larger or smaller; for example 5"};
  }
  if (auto r = mayBeSetUp(device, where, by); !r) return r;
  device.mount = Mount(device.mount.pose(), scale);
  device.applyScale();
  holdAnew(device);
  log::info("{}: a metre of the hand is {:g} m of the world{}", device.name, scale,
            device.info().max_stiffness > 0 ? fmt::format("; the stiffest surface that it bears has {:g} N/m there",
                                                          device.info().max_stiffness / scale)
                                            : std::string());
  return {};
}

}  // namespace hapticd
