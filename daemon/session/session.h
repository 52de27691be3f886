/** @file
 * One client's session on one device: its two regions and its life from the offer to the last unmapping.
 */
#pragma once

#include <cstdint>
#include <string>

#include "daemon/device/device_manager.h"
#include "daemon/ipc/memfd.h"
#include "daemon/log/log.h"
#include "daemon/scene/object.h"
#include "proto/shm_layout.h"

namespace hapticd {

/** Daemon's side of regions A and B. */
class SessionRegions {
 public:
  /** Makes, sizes and fills both; A is sealed against any writer but the daemon at once. */
  [[nodiscard]] static Result<SessionRegions> create(const RegionIdentity& identity);

  /** The client has mapped both: seals B against new writers, checks both sets of seals, locks and touches all pages.
   */
  [[nodiscard]] Result<void> sealAndLock(bool must_lock);

  [[nodiscard]] hd_region_a* a() const { return a_.as<hd_region_a>(); }
  [[nodiscard]] hd_region_b* b() const { return b_.as<hd_region_b>(); }
  [[nodiscard]] const Memfd& fileA() const { return file_a_; }
  [[nodiscard]] const Memfd& fileB() const { return file_b_; }
  [[nodiscard]] std::uint64_t bytes() const { return a_.size() + b_.size(); }
  /** Tells the client that the daemon has closed the session. */
  void markEnded() const;

 private:
  Memfd file_a_, file_b_;
  Mapping a_, b_;
};

/** Bytes of a session's regions, for the quota before they are made. */
inline constexpr std::uint64_t kSessionBytes = sizeof(hd_region_a) + sizeof(hd_region_b);

struct Session {
  enum class State {
    kOffered,  ///< The client is to map the regions.
    kAdding,   ///< The servo is told; ingest will be.
    kLive,     ///< Ingest reads it, the servo renders it.
    kEnding,   ///< Ingest lets go, the share fades.
    kFreeing,  ///< The servo gives the slot back.
  };

  std::uint64_t id = 0;
  Client client;
  OpenDevice* device = nullptr;
  GroupLink* link = nullptr;
  std::uint32_t slot = 0;
  SessionRegions regions;
  State state = State::kOffered;
  std::int64_t offered_ns = 0;
  std::uint64_t ticket = 0;     ///< Order that the present state waits for.
  bool detach_sent = false;     ///< Ingest has the order to let go.
  bool detached = false;        ///< Ingest has let go.
  std::uint32_t said = 0;       ///< Index in ingest's ring past all that it had said of this session by then.
  bool fading = false;          ///< The last loss order is posted; `ticket` is its.
  bool fade_started = false;    ///< The servo has it.
  bool free_sent = false;       ///< The order to give the slot back is posted; `ticket` is its.
  std::uint64_t fade_tick = 0;  ///< Servo tick when it had it.
  std::string why;              ///< Why it ended.
  /** Of what the servo refuses, told to subscribers. */
  log::RateLimit refusals{1'000'000'000, 5};
  /** Of its models that expire, told to subscribers: all that it may have at once. */
  log::RateLimit expiries{1'000'000'000, HD_MODEL_SLOTS};
};

}  // namespace hapticd
