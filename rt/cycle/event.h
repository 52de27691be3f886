/** @file
 * What a cycle has to tell the control thread: touches, buttons, faults. Fixed size; what does not fit is counted.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/** Numbers of EventKind in control.capnp; the servo raises these. */
enum class ServoEventKind : std::uint32_t {
  kTouch = 0,
  kUntouch = 1,
  kButton = 2,
  kFault = 3,
  kArmed = 4,
  kDisarmed = 5,
  kOverrun = 10,  ///< `value`: periods missed just before.
  kModelExpired = 13,
  kCommandRefused = 64,  ///< For the log: `value` is the error, `order` what was refused, `session` whose it was.
  kWarm = 65,            ///< For the log: the motors are warm (`value` 1) or no longer (0).
  kMoved = 66,           ///< For control: a clutch was let go, and the device's mount is at `point`.
};

struct ServoEvent {
  ServoEventKind kind = ServoEventKind::kTouch;
  std::uint32_t device = 0;
  std::uint32_t object = 0;
  std::uint32_t session = 0;  ///< Slot.
  std::uint32_t value = 0;
  std::uint32_t order = 0;  ///< CommandKind of what was refused.
  std::int64_t t_ns = 0;
  std::uint64_t tick = 0;
  double point[3] = {};
  double force = 0;
};

/** What a client brings about at whatever rate it likes. */
[[nodiscard]] constexpr bool isOfClients(ServoEventKind kind) HD_RT {
  return kind == ServoEventKind::kCommandRefused || kind == ServoEventKind::kModelExpired;
}

/** Events of one cycle. However many are of clients, there is room left for what devices and hands do. */
struct EventBatch {
  static constexpr std::uint32_t kMostRefusals = 32, kMostOfClients = 40;
  static constexpr std::uint32_t kCapacity = 96;
  std::array<ServoEvent, kCapacity> event;
  std::uint32_t count = 0;
  std::uint32_t refusals = 0, of_clients = 0;  ///< Of these.
  std::uint32_t dropped = 0;

  void clear() HD_RT { count = refusals = of_clients = dropped = 0; }
  void add(const ServoEvent& e) HD_RT {
    const std::uint32_t refusal = e.kind == ServoEventKind::kCommandRefused ? 1 : 0;
    const std::uint32_t of_client = isOfClients(e.kind) ? 1 : 0;
    if (count == kCapacity || refusals + refusal > kMostRefusals || of_clients + of_client > kMostOfClients) {
      ++dropped;
      return;
    }
    refusals += refusal;
    of_clients += of_client;
    event[count++] = e;
  }
};

}  // namespace hapticd
