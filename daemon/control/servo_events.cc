// What the servo and ingest have to tell, put into words for subscribers and the log.
#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <utility>

#include "daemon/control/core.h"

namespace hapticd {
namespace {

/** Why the servo refuses an order; what errors.h says of these is meant for clients. */
std::string_view whyRefused(ErrorCode code, CommandKind order, bool known) {
  if (code == ErrorCode::kDisconnected) return "the session that gave it has ended";
  if (code == ErrorCode::kUnsupported && order == CommandKind::kObjectVertices)
    return "it shows no mesh that was loaded as deformable";
  if (code == ErrorCode::kNotFound && order == CommandKind::kObjectVertices && known)
    return "it has no vertex of that number, or the servo has yet to hear of it";
  return describe(code);
}

const char* wordsOf(CommandKind order) {
  switch (order) {
    case CommandKind::kObjectPose:
      return "a pose";
    case CommandKind::kObjectMaterial:
      return "a material";
    case CommandKind::kObjectFlags:
      return "flags";
    case CommandKind::kObjectVertices:
      return "moves of vertices";
    case CommandKind::kLocalModel:
      return "a local model";
    case CommandKind::kForceField:
      return "a force field";
    case CommandKind::kClientForce:
      return "a client force";
    case CommandKind::kIntent:
      return "an intent";
    default:
      return "an order";
  }
}

}  // namespace

const char* faultText(std::uint32_t fault) noexcept {
  static constexpr const char* kText[HD_FAULT_COUNT] = {
      "none",
      "emergency stop",
      "a force or a sample was not finite",
      "the hand moved faster than the limit",
      "the device's samples stopped coming",
      "the device reports an error",
      "the dead-man switch opened",
      "the servo missed too many periods in a row",
      "the energy could not be kept passive",
  };
  return fault < HD_FAULT_COUNT ? kText[fault] : "unknown fault";
}

void Core::drain(GroupLink& link) {
  Servo& servo = link.group().servo();
  ServoEvent event;
  for (int i = 0; i < 1024 && servo.events.pop(event); ++i) {
    try {
      translate(link, event);
    } catch (const std::bad_alloc&) {
      events_.lost(1);
    }
  }
  try {
    tellMissed(link);
  } catch (const std::bad_alloc&) {  // Later: what follows is not to wait for it.
  }
  const std::uint64_t dropped = servo.counters.events_dropped.load(std::memory_order_relaxed);
  std::uint64_t& seen = events_dropped_[&link];
  if (dropped != seen) events_.lost(dropped - seen);
  seen = dropped;
  IngestReport report;
  for (int i = 0; i < 256 && link.group().ingest().reports.pop(report); ++i) sessions_.report(link, report);
}

void Core::tellRefused(const Session& session, ErrorCode code, const std::string& what, const std::string& object) {
  Event event;
  event.kind = EventKind::kRefused;
  event.t_ns = clock_.now();
  event.device = session.device->name;
  event.object = object;
  event.session = session.id;
  event.value = static_cast<std::uint32_t>(code);
  event.text = what;
  events_.publish(event);
}

void Core::refusedByServo(const std::string& device, const ServoEvent& e, Session* session) {
  const auto order = static_cast<CommandKind>(e.order);
  const auto code = static_cast<ErrorCode>(e.value);
  // What it moved to the last went with its client before that was read: no mistake of anybody's.
  if (session != nullptr && code == ErrorCode::kNotFound && !clients_.has(session->client.connection)) return;
  const std::string object = scene_.nameOf(e.object);
  const std::string what =
      fmt::format("{}{}: {}", wordsOf(order), object.empty() ? std::string() : fmt::format(" of object '{}'", object),
                  whyRefused(code, order, !object.empty()));
  std::uint64_t suppressed = 0;
  if (session != nullptr && session->refusals.allow(clock_.now(), suppressed))
    tellRefused(*session, code, what + log::suppressedNote(suppressed), object);
  if (!refused_log_.allow(clock_.now(), suppressed)) return;
  log::warn("{}: the servo refused {}{}{}", session == nullptr ? device : session->device->name,
            session == nullptr
                ? std::string()
                : fmt::format("'{}' (pid {}) ", log::printable(session->client.name), session->client.pid),
            what, log::suppressedNote(suppressed));
}

void Core::translate(GroupLink& link, const ServoEvent& e) {
  OpenDevice* const device = devices_.at(link, e.device);
  if (e.kind == ServoEventKind::kMoved) {  // First: no memory is needed to take it over.
    if (device != nullptr) device->mount = Mount(Pose{vec3(e.point), device->mount.pose().q}, device->mount.scale());
    return;
  }
  // Other events name no session: their 0 is not slot 0, which belongs to somebody.
  const bool told_of = e.kind == ServoEventKind::kModelExpired || e.kind == ServoEventKind::kCommandRefused;
  Session* const session = told_of ? sessions_.bySlot(link, e.session) : nullptr;
  const std::string name = device == nullptr ? link.name() : device->name;
  if (e.kind == ServoEventKind::kCommandRefused) return refusedByServo(name, e, session);
  if (e.kind == ServoEventKind::kWarm) {
    if (e.value != 0) {
      log::warn("{}: its motors are warm; if this goes on, the force will be derated to what they stand for ever",
                name);
    } else {
      log::info("{}: its motors have cooled", name);
    }
    return;
  }
  Event event;
  event.kind = static_cast<EventKind>(e.kind);
  event.t_ns = e.t_ns;
  event.tick = e.tick;
  event.device = name;
  event.object = scene_.lastNameOf(e.object);
  event.session = session == nullptr ? 0 : session->id;
  event.value = e.value;
  for (int i = 0; i < 3; ++i) event.point[i] = e.point[i];
  event.force = e.force;
  std::uint64_t suppressed = 0;
  switch (e.kind) {
    case ServoEventKind::kFault:
      event.text = faultText(e.value);
      log::warn("{}: fault, force off: {}", name, event.text);
      break;
    case ServoEventKind::kArmed:
      log::info("{}: armed", name);
      forgetDisarmed(name);
      break;
    case ServoEventKind::kDisarmed:
      disarmed_.push_back(std::move(event));
      return;
    case ServoEventKind::kOverrun: {
      // A machine that is too busy misses some in every second one: not each is worth an event.
      Missed& missed = missed_[&link];
      missed.last = e;
      missed.periods += e.value;
      return;
    }
    case ServoEventKind::kModelExpired:
      if (session == nullptr) break;
      if (!session->expiries.allow(clock_.now(), suppressed)) return;  // Else one client's fill everybody's queues.
      event.text = log::suppressedNote(suppressed);
      if (!event.text.empty()) event.text.erase(0, 1);  // The space.
      break;
    default:
      break;
  }
  events_.publish(event);
}

/** What was held back, too, when it is its turn, or the last. */
void Core::tellMissed(const GroupLink& link, bool last) {
  const auto it = missed_.find(&link);
  if (it == missed_.end() || it->second.periods == 0) return;
  Missed& missed = it->second;
  std::uint64_t suppressed = 0;
  if (!missed.told.allow(clock_.now(), suppressed) && !last) return;
  Event event;
  const OpenDevice* const device = devices_.at(link, missed.last.device);
  event.kind = EventKind::kOverrun;
  event.t_ns = missed.last.t_ns;
  event.tick = missed.last.tick;
  event.device = device == nullptr ? link.name() : device->name;
  event.value = static_cast<std::uint32_t>(std::min<std::uint64_t>(missed.periods, ~0u));
  if (overrun_log_.allow(clock_.now(), suppressed)) {
    log::info("{}: missed {} period{}{}", event.device, event.value, event.value == 1 ? "" : "s",
              log::suppressedNote(suppressed));
  }
  events_.publish(event);
  missed.periods = 0;
}

/** Armed again before it was off: then it never was. */
void Core::forgetDisarmed(const std::string& name) {
  const auto is = [&](const Event& event) { return event.device == name; };
  disarmed_.erase(std::remove_if(disarmed_.begin(), disarmed_.end(), is), disarmed_.end());
}

void Core::tellDisarmed(const std::string& name) noexcept {
  for (auto it = std::ranges::find(disarmed_, name, &Event::device); it != disarmed_.end();
       it = std::ranges::find(disarmed_, name, &Event::device)) {
    log::info("{}: disarmed", name);
    events_.publish(*it);
    disarmed_.erase(it);
  }
}

/** The servo has disarmed them; that is told when no thread of the driver's has anything else on its way any more. */
void Core::pollDisarmed() {
  for (auto it = disarmed_.begin(); it != disarmed_.end();) {
    if (const auto device = devices_.find(it->device); device && !(*device)->device().isOff()) {
      ++it;
      continue;
    }
    log::info("{}: disarmed", it->device);
    events_.publish(*it);
    it = disarmed_.erase(it);
  }
}

}  // namespace hapticd
