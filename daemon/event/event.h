/** @file
 * What happened, as it is told to subscribers. The numbers are those of EventKind in control.capnp.
 */
#pragma once

#include <cstdint>
#include <string>

namespace hapticd {

enum class EventKind : std::uint16_t {
  kTouch = 0,
  kUntouch = 1,
  kButton = 2,
  kFault = 3,
  kArmed = 4,
  kDisarmed = 5,
  kLeaseLost = 6,
  kLeaseTaken = 7,
  kDeviceAdded = 8,
  kDeviceRemoved = 9,
  kOverrun = 10,
  kClientJoined = 11,
  kClientLeft = 12,
  kModelExpired = 13,
  kObjectChanged = 14,
  kRefused = 15,  ///< What a client has pushed; `session` is its.
};
inline constexpr std::uint32_t kEventKinds = 16;

struct Event {
  EventKind kind = EventKind::kTouch;
  std::int64_t t_ns = 0;
  std::uint64_t tick = 0;
  std::string device;
  std::string object;
  std::uint64_t session = 0;
  std::uint32_t value = 0;  ///< Button mask, fault number, missed periods, model slot, ErrorCode.
  double point[3] = {};     ///< [m]
  double force = 0;         ///< [N]
  std::string text;
};

}  // namespace hapticd
