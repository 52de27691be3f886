// Pushing: every function here is servo-safe. What is checked here is what a caller can get wrong by accident; the
// daemon checks its own copy of everything.
#include <hapticclient/scene.h>

#include <cmath>
#include <span>

#include "libclient/src/session/session.h"

using hapticd::ErrorCode;
using hapticd::MailboxWriter;

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

template <class... Numbers>
bool finite(const Numbers&... numbers) {
  const auto all = [](const auto& number) {
    if constexpr (std::is_array_v<std::remove_reference_t<decltype(number)>>) {
      for (const auto x : number) {
        if (!std::isfinite(x)) return false;
      }
      return true;
    } else {
      return static_cast<bool>(std::isfinite(number));
    }
  };
  return (all(numbers) && ...);
}

bool rotation(const double (&q)[4]) {
  const double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return std::abs(n - 1) < 1e-3;  // false for NaN
}

bool direction(const auto& n) {
  const double length = double{n[0]} * n[0] + double{n[1]} * n[1] + double{n[2]} * n[2];
  return std::abs(length - 1) < 1e-3;
}

bool sound(const haptic_material& m) {
  return finite(m.stiffness, m.damping, m.friction_static, m.friction_dynamic) && m.stiffness >= 0 && m.damping >= 0 &&
         m.friction_dynamic >= 0 && m.friction_static >= m.friction_dynamic;
}

bool sound(const haptic_object_pose& c) {
  return c.object != 0 && c.reserved == 0 && finite(c.p, c.v, c.w) && rotation(c.q);
}
bool sound(const haptic_object_material& c) { return c.object != 0 && c.reserved == 0 && sound(c.material); }
bool sound(const haptic_object_flags& c) {
  constexpr std::uint32_t kKnown = HAPTIC_OBJECT_ENABLED | HAPTIC_OBJECT_VISIBLE | HAPTIC_OBJECT_TWO_SIDED;
  return c.object != 0 && c.reserved == 0 && ((c.mask | c.value) & ~kKnown) == 0;
}
bool sound(const haptic_object_vertices& c) {
  if (c.object == 0 || c.count == 0 || c.count > HAPTIC_VERTEX_MOVES) return false;
  for (std::uint32_t i = 0; i < c.count; ++i) {
    if (!finite(c.move[i].p)) return false;
  }
  return true;
}
bool sound(const haptic_local_model& c) {
  if (c.slot >= HAPTIC_MODEL_SLOTS || c.device >= HD_MAX_DEVICES || c.reserved != 0) return false;
  if (c.lease_ns <= 0 || c.blend_ns < 0) return false;
  if (!sound(c.material) || !finite(c.origin, c.normal, c.radius)) return false;
  switch (c.kind) {
    case HAPTIC_MODEL_PLANE:
      return direction(c.normal);
    case HAPTIC_MODEL_SPRING:
      return c.radius >= 0;
    case HAPTIC_MODEL_SPHERE:
      return c.radius != 0;
    case HAPTIC_MODEL_HALFSPACES:
    case HAPTIC_MODEL_CORNER:
      if (c.count == 0 || c.count > HAPTIC_HALFSPACES) return false;
      for (std::uint32_t i = 0; i < c.count; ++i) {
        if (!finite(c.halfspace[i]) || !direction(c.halfspace[i])) return false;
      }
      return true;
    default:
      return false;
  }
}
bool sound(const haptic_force_field& c) {
  return c.slot < HAPTIC_MODEL_SLOTS && c.device < HD_MAX_DEVICES && c.reserved == 0 && c.lease_ns > 0 &&
         c.blend_ns >= 0 && finite(c.x0, c.f0, c.jacobian, c.radius) && c.radius > 0;
}
bool sound(const haptic_clear_model& c) { return c.slot < HAPTIC_MODEL_SLOTS && c.reserved == 0 && c.blend_ns >= 0; }
bool sound(const haptic_client_force& c) {
  return c.device < HD_MAX_DEVICES && c.reserved == 0 && c.lease_ns > 0 && finite(c.force, c.torque);
}
bool sound(const haptic_intent& c) {
  return c.device < HD_MAX_DEVICES && c.reserved == 0 && finite(c.p, c.gripper_rad) && rotation(c.q);
}
bool sound(const haptic_session_limits& c) {
  return finite(c.force_n, c.torque_nm) && c.force_n >= 0 && c.torque_nm >= 0;
}

template <class T>
int send(haptic_session* session, const T* command, haptic_push* push, std::uint32_t kind, std::uint32_t id) {
  if (const int dead = session->check(); dead != HAPTIC_OK) return dead;
  const std::uint64_t at_tick = push == nullptr ? 0 : push->at_tick;
  const std::uint32_t flags = push == nullptr ? 0 : push->flags;
  if (!sound(*command) || (flags & ~std::uint32_t{HAPTIC_PUSH_LATEST}) != 0) return HAPTIC_INVALID_ARGUMENT;

  hapticd::client::Opened& opened = *session->opened;
  MailboxWriter* mailbox = opened.mailboxes.find(target(kind, id));
  const bool latest = mailbox != nullptr || (flags & HAPTIC_PUSH_LATEST) != 0;
  if (latest && at_tick != 0) return HAPTIC_INVALID_ARGUMENT;
  if (latest && mailbox == nullptr) {
    mailbox = opened.mailboxes.take(target(kind, id), opened.b());
    if (mailbox == nullptr) return HAPTIC_QUOTA_EXCEEDED;
  }
  const std::span<const std::byte> payload = std::as_bytes(std::span(command, 1));
  std::uint64_t seq = 0;
  const ErrorCode code =
      mailbox != nullptr ? mailbox->write(kind, payload, seq) : opened.producer->push(kind, payload, at_tick, seq);
  if (code == ErrorCode::kOk && push != nullptr) push->seq = seq;
  return static_cast<int>(code);
}

}  // namespace

#define HAPTICD_PUSH(name, type, kind, id)                                                  \
  int haptic_push_##name(haptic_session* session, const type* command, haptic_push* push) { \
    if (session == nullptr || command == nullptr) return HAPTIC_INVALID_ARGUMENT;           \
    return send(session, command, push, kind, id);                                          \
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

}  // extern "C"
