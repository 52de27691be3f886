/** @file
 * A session: state out, models and forces in. Threads as in session.h and push.h.
 */
#pragma once

#include <hapticclient/push.h>
#include <hapticclient/session.h>

#include <chrono>
#include <cstdint>
#include <hapticclient/result.hpp>
#include <memory>
#include <span>

namespace haptic {

/** How a push travels. */
struct PushOptions {
  bool latest = false;        ///< By a mailbox: only the newest value matters.
  std::uint64_t at_tick = 0;  ///< By the ring: takes effect at this tick.
};

class Session {
 public:
  explicit Session(haptic_session* handle) noexcept : handle_(handle) {}

  [[nodiscard]] Result<Reply<haptic_session_info>> describe() const {
    return detail::ask<haptic_session_info>(
        [&](auto** out, auto* e) { return haptic_session_describe(get(), out, e); });
  }
  /** After Client::reconnect(). */
  Result<void> reopen() {
    return detail::run([&](auto* e) { return haptic_session_reopen(get(), e); });
  }
  Result<void> acquireLease() {
    return detail::run([&](auto* e) { return haptic_session_acquire_lease(get(), e); });
  }
  Result<void> releaseLease() {
    return detail::run([&](auto* e) { return haptic_session_release_lease(get(), e); });
  }
  Result<void> arm() {
    return detail::run([&](auto* e) { return haptic_session_arm(get(), e); });
  }
  Result<void> disarm() {
    return detail::run([&](auto* e) { return haptic_session_disarm(get(), e); });
  }

  [[nodiscard]] bool alive() const noexcept { return haptic_session_check(get()) == HAPTIC_OK; }

  /** The newest sample of the session's device. Servo-safe, as all below. */
  [[nodiscard]] Result<haptic_sample> latest() const {
    haptic_sample sample;
    if (const int code = haptic_session_latest(get(), &sample); code != HAPTIC_OK) return Error{code, {}, {}, {}};
    return sample;
  }
  /** That of another device of the group, by its index. */
  [[nodiscard]] Result<haptic_sample> latest(std::uint32_t device) const {
    haptic_sample sample;
    if (const int code = haptic_session_latest_of(get(), device, &sample); code != HAPTIC_OK) {
      return Error{code, {}, {}, {}};
    }
    return sample;
  }
  /** Fills `room` with the oldest unread samples and gives the filled part; `lost` grows by those overwritten. */
  [[nodiscard]] Result<std::span<haptic_sample>> drain(std::span<haptic_sample> room, std::uint64_t& lost) {
    std::uint32_t count = 0;
    const auto capacity = static_cast<std::uint32_t>(room.size());
    const int code = haptic_session_drain(get(), room.data(), capacity, &count, &lost);
    if (code != HAPTIC_OK) return Error{code, {}, {}, {}};
    return room.first(count);
  }
  [[nodiscard]] Result<haptic_acks> acks() const { return read<haptic_acks>(haptic_session_acks); }
  [[nodiscard]] Result<haptic_counters> counters() const { return read<haptic_counters>(haptic_session_counters); }
  [[nodiscard]] Result<haptic_model_status> model(std::uint32_t slot) const {
    haptic_model_status status;
    if (const int code = haptic_session_model_status(get(), slot, &status); code != HAPTIC_OK) {
      return Error{code, {}, {}, {}};
    }
    return status;
  }

  /** Pushes a command; gives its number. A refusal comes in words, but for a full ring, which costs nothing. */
  Result<std::uint64_t> push(const haptic_object_pose& c, PushOptions how = {}) {
    return send(haptic_push_object_pose, c, how);
  }
  Result<std::uint64_t> push(const haptic_object_material& c, PushOptions how = {}) {
    return send(haptic_push_object_material, c, how);
  }
  Result<std::uint64_t> push(const haptic_object_flags& c, PushOptions how = {}) {
    return send(haptic_push_object_flags, c, how);
  }
  Result<std::uint64_t> push(const haptic_object_vertices& c, PushOptions how = {}) {
    return send(haptic_push_object_vertices, c, how);
  }
  Result<std::uint64_t> push(const haptic_local_model& c, PushOptions how = {}) {
    return send(haptic_push_local_model, c, how);
  }
  Result<std::uint64_t> push(const haptic_force_field& c, PushOptions how = {}) {
    return send(haptic_push_force_field, c, how);
  }
  Result<std::uint64_t> push(const haptic_clear_model& c, PushOptions how = {}) {
    return send(haptic_push_clear_model, c, how);
  }
  Result<std::uint64_t> push(const haptic_client_force& c, PushOptions how = {}) {
    return send(haptic_push_client_force, c, how);
  }
  Result<std::uint64_t> push(const haptic_intent& c, PushOptions how = {}) { return send(haptic_push_intent, c, how); }
  Result<std::uint64_t> push(const haptic_session_limits& c, PushOptions how = {}) {
    return send(haptic_push_limits, c, how);
  }
  [[nodiscard]] std::uint32_t space() const noexcept { return haptic_push_space(get()); }

  /** The handle of the C interface; still owned here. */
  [[nodiscard]] haptic_session* get() const noexcept { return handle_.get(); }

 private:
  struct Close {
    void operator()(haptic_session* handle) const noexcept { haptic_session_close(handle); }
  };

  template <class T>
  Result<T> read(int (*call)(const haptic_session*, T*)) const {
    T value;
    if (const int code = call(get(), &value); code != HAPTIC_OK) return Error{code, {}, {}, {}};
    return value;
  }
  template <class T>
  Result<std::uint64_t> send(int (*call)(haptic_session*, const T*, haptic_push*), const T& command, PushOptions how) {
    haptic_push push{how.at_tick, how.latest ? std::uint32_t{HAPTIC_PUSH_LATEST} : 0u, 0, 0};
    const int code = call(get(), &command, &push);
    if (code == HAPTIC_OK) return push.seq;
    if (code == HAPTIC_WOULD_BLOCK || get() == nullptr) return Error{code, {}, {}, {}};
    return detail::run([&](auto* e) { return haptic_push_refusal(get(), e); }).error();
  }

  std::unique_ptr<haptic_session, Close> handle_;
};

}  // namespace haptic
