/** @file
 * A session: its two mappings, what each of its threads owns, and its capability on the library's thread.
 */
#pragma once

#include <capnp/message.h>
#include <hapticclient/push.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "libclient/src/connection/connection.h"
#include "libclient/src/session/mapping.h"
#include "libclient/src/session/push_check.h"
#include "proto/shm_layout.h"
#include "rt/ring/command_ring.h"
#include "rt/ring/state.h"

namespace hapticd::client {

/** Which targets have a mailbox. Pushing thread. */
struct Mailboxes {
  struct Box {
    std::uint64_t target = 0;  ///< 0: free.
    std::optional<MailboxWriter> writer;
  };
  std::array<Box, HD_MAILBOXES> boxes;

  [[nodiscard]] MailboxWriter* find(std::uint64_t target) noexcept;
  /** Null when all are taken. */
  MailboxWriter* take(std::uint64_t target, hd_region_b* region) noexcept;
};

/** Everything of one opening; a reopening makes a new one. */
struct Opened {
  Mapping map_a, map_b;
  std::uint64_t id = 0, epoch = 0;
  std::uint32_t device_index = 0, device_count = 0;
  std::int64_t period_ns = 0;
  std::unique_ptr<capnp::MallocMessageBuilder> device;  ///< DeviceInfo as it was then.
  std::optional<StateReader> reader;                    ///< Reading thread.
  std::optional<CommandProducer> producer;              ///< Pushing thread; its heartbeat the library's.
  Mailboxes mailboxes;                                  ///< Pushing thread.
  proto::Session::Client capability = nullptr;          ///< Library's thread.

  [[nodiscard]] const hd_region_a* a() const noexcept { return static_cast<const hd_region_a*>(map_a.address()); }
  [[nodiscard]] hd_region_b* b() const noexcept { return static_cast<hd_region_b*>(map_b.address()); }
};

}  // namespace hapticd::client

/** The handle of session.h. */
struct haptic_session final : hapticd::client::Dependent {
  haptic_session(std::shared_ptr<hapticd::client::Connection> c, std::string device_uri, std::string client_name)
      : connection(std::move(c)), uri(std::move(device_uri)), name(std::move(client_name)) {}
  ~haptic_session() noexcept override = default;

  void lost() noexcept override { alive.store(false, std::memory_order_release); }
  void beat(std::int64_t now_ns) noexcept override {
    if (alive.load(std::memory_order_relaxed)) opened->producer->heartbeat(now_ns);
  }

  hapticd::client::Failure open();
  /** Ends the session at the daemon; the mappings stay until the next open(). */
  void end() noexcept;
  /** HAPTIC_OK, or why the session is dead. Servo-safe. */
  [[nodiscard]] int check() const noexcept;

  std::shared_ptr<hapticd::client::Connection> connection;
  std::string uri;  ///< As asked for; of the device itself once it was opened.
  std::string name;
  std::unique_ptr<hapticd::client::Opened> opened;
  std::atomic<bool> alive{false};
  int refused = HAPTIC_OK;  ///< Code of the last push, and why. Pushing thread.
  hapticd::client::Objection objection;
};
