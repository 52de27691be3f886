/** @file
 * What the library refuses of a push before it is sent, and the words for it. The daemon checks its own copy by the
 * same bounds (rt/ingest/limits.h), but can only count what it refuses; here the caller is told the field.
 */
#pragma once

#include <hapticclient/push.h>

#include <cstdint>

namespace hapticd::client {

/** What is wrong with a push; null `where`: nothing. Static texts: finding one is servo-safe. */
struct Objection {
  const char* where = nullptr;  ///< The field; of an entry of an array with `%u` in place of its index.
  const char* what = nullptr;
  const char* remedy = nullptr;
  std::uint32_t index = 0;

  explicit operator bool() const noexcept { return where != nullptr; }
};

/** The first field that the daemon would refuse. `devices`: how many share the session's servo. */
Objection objection(const haptic_object_pose& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_object_material& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_object_flags& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_object_vertices& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_local_model& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_force_field& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_clear_model& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_client_force& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_intent& c, std::uint32_t devices) noexcept;
Objection objection(const haptic_session_limits& c, std::uint32_t devices) noexcept;

}  // namespace hapticd::client
