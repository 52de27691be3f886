// Pushing: every function here is servo-safe. What is checked here is what a caller can get wrong by accident; the
// daemon checks its own copy of everything.
#include <cstdio>
#include <span>

#include "libclient/src/session/session.h"

using hapticd::ErrorCode;
using hapticd::MailboxWriter;
using hapticd::client::Failure;
using hapticd::client::Objection;
using hapticd::client::objection;

namespace hapticd::client {

MailboxWriter* Mailboxes::find(std::uint64_t target) noexcept {
  for (Box& box : boxes) {
    if (box.target == target) return &*box.writer;
  }
  return nullptr;
}

MailboxWriter* Mailboxes::take(std::uint64_t target, hd_region_b* region) noexcept {
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].target != 0) continue;
    boxes[i].target = target;
    return &boxes[i].writer.emplace(&region->mailbox[i]);
  }
  return nullptr;
}

}  // namespace hapticd::client

namespace {

/** What a mailbox holds the newest value of. Local models, fields and their clearing share a slot, hence a target. */
constexpr std::uint64_t target(std::uint32_t kind, std::uint32_t id) {
  if (kind == HD_COMMAND_FORCE_FIELD || kind == HD_COMMAND_CLEAR_MODEL) kind = HD_COMMAND_LOCAL_MODEL;
  return std::uint64_t{kind} << 32 | id;
}

/** Its newest value does not hold what those before it changed: a mailbox would lose that. */
constexpr bool changesAPart(std::uint32_t kind) {
  return kind == HD_COMMAND_OBJECT_FLAGS || kind == HD_COMMAND_OBJECT_VERTICES;
}

/** Keeps why a push is refused for haptic_push_refusal(). */
int refuse(haptic_session* session, int code, const Objection& why) {
  session->refused = code;
  session->objection = why;
  return code;
}

/** The same where the ring or the connection refuses. */
int refuse(haptic_session* session, int code, bool of_a_part = false) {
  switch (code) {
    case HAPTIC_OK:
      break;
    case HAPTIC_WOULD_BLOCK:
      return refuse(session, code,
                    {"push", "256 commands wait to be taken",
                     of_a_part ? "push less often" : "push less often, or the latest only (HAPTIC_PUSH_LATEST)"});
    case HAPTIC_QUOTA_EXCEEDED:
      return refuse(session, code,
                    {"flags", "16 targets of this session have a mailbox already",
                     "push this one without latest (HAPTIC_PUSH_LATEST)"});
    case HAPTIC_DISCONNECTED:
      if (!session->connection->ownProcess()) {
        return refuse(session, code, {"process", "the connection was made before fork()", "connect anew in the child"});
      }
      return refuse(session, code,
                    {"session", "is over", "haptic_reconnect() and haptic_session_reopen(), or open another"});
    default:
      return refuse(session, code, {"", haptic_error_text(code), ""});
  }
  session->refused = HAPTIC_OK;
  return code;
}

template <class T>
int send(haptic_session* session, const T* command, haptic_push* push, std::uint32_t kind, std::uint32_t id) {
  if (const int dead = session->check(); dead != HAPTIC_OK) return refuse(session, dead);
  const std::uint64_t at_tick = push == nullptr ? 0 : push->at_tick;
  const std::uint32_t flags = push == nullptr ? 0 : push->flags;
  hapticd::client::Opened& opened = *session->opened;
  if (const auto why = objection(*command, opened.device_count)) return refuse(session, HAPTIC_INVALID_ARGUMENT, why);
  if (push != nullptr && push->reserved != 0)
    return refuse(session, HAPTIC_INVALID_ARGUMENT, {"haptic_push.reserved", "is not 0", "start from zeros"});
  if ((flags & ~std::uint32_t{HAPTIC_PUSH_LATEST}) != 0) {
    return refuse(session, HAPTIC_INVALID_ARGUMENT,
                  {"flags", "has a bit that is no haptic_push_flag", "start from zeros"});
  }
  if (changesAPart(kind) && flags != 0) {
    return refuse(session, HAPTIC_INVALID_ARGUMENT,
                  {"flags", "asks for the latest only, but this push changes a part: those before it would be lost",
                   "push it without latest (HAPTIC_PUSH_LATEST)"});
  }

  MailboxWriter* mailbox = opened.mailboxes.find(target(kind, id));
  const bool latest = mailbox != nullptr || (flags & HAPTIC_PUSH_LATEST) != 0;
  if (latest && at_tick != 0) {
    return refuse(session, HAPTIC_INVALID_ARGUMENT,
                  {"at_tick", "is set, but this target has a mailbox, which takes effect at once",
                   "leave out at_tick, or latest (HAPTIC_PUSH_LATEST) at every push of this target"});
  }
  if (latest && mailbox == nullptr) {
    mailbox = opened.mailboxes.take(target(kind, id), opened.b());
    if (mailbox == nullptr) return refuse(session, HAPTIC_QUOTA_EXCEEDED);
  }
  const std::span<const std::byte> payload = std::as_bytes(std::span(command, 1));
  std::uint64_t seq = 0;
  const ErrorCode code =
      mailbox != nullptr ? mailbox->write(kind, payload, seq) : opened.producer->push(kind, payload, at_tick, seq);
  if (code == ErrorCode::kOk && push != nullptr) push->seq = seq;
  return refuse(session, static_cast<int>(code), changesAPart(kind));
}

}  // namespace

#define HAPTICD_PUSH(name, type, kind, id)                                                           \
  int haptic_push_##name(haptic_session* session, const type* command, haptic_push* push) {          \
    if (session == nullptr) return HAPTIC_INVALID_ARGUMENT;                                          \
    if (command == nullptr) return refuse(session, HAPTIC_INVALID_ARGUMENT, {#name, "is null", ""}); \
    return send(session, command, push, kind, id);                                                   \
  }

extern "C" {

HAPTICD_PUSH(object_pose, haptic_object_pose, HD_COMMAND_OBJECT_POSE, command->object)
HAPTICD_PUSH(object_material, haptic_object_material, HD_COMMAND_OBJECT_MATERIAL, command->object)
HAPTICD_PUSH(object_flags, haptic_object_flags, HD_COMMAND_OBJECT_FLAGS, command->object)
HAPTICD_PUSH(object_vertices, haptic_object_vertices, HD_COMMAND_OBJECT_VERTICES, command->object)
HAPTICD_PUSH(local_model, haptic_local_model, HD_COMMAND_LOCAL_MODEL, command->slot)
HAPTICD_PUSH(force_field, haptic_force_field, HD_COMMAND_FORCE_FIELD, command->slot)
HAPTICD_PUSH(clear_model, haptic_clear_model, HD_COMMAND_CLEAR_MODEL, command->slot)
HAPTICD_PUSH(client_force, haptic_client_force, HD_COMMAND_CLIENT_FORCE, command->device)
HAPTICD_PUSH(intent, haptic_intent, HD_COMMAND_INTENT, command->device)
HAPTICD_PUSH(limits, haptic_session_limits, HD_COMMAND_LIMITS, 0)

uint32_t haptic_push_space(const haptic_session* session) {
  if (session == nullptr || session->check() != HAPTIC_OK) return 0;
  return session->opened->producer->space();
}

int haptic_push_refusal(const haptic_session* session, haptic_error* error) {
  return hapticd::client::edge(error, [&]() -> Failure {
    if (session == nullptr) return hapticd::client::badArgument("session", "is null");
    if (session->refused == HAPTIC_OK) return {};
    const Objection& why = session->objection;
    char where[64];
    std::snprintf(where, sizeof where, why.where, why.index);  // NOLINT: one of push_check.cc's
    return {session->refused, where, why.what, why.remedy};
  });
}

}  // extern "C"
