/** @file
 * Who is connected, and what is counted by number of what they hold.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "daemon/scene/object.h"
#include "rt/base/error.h"

namespace hapticd {

/** Control thread only. */
class Clients {
 public:
  static constexpr std::size_t kConnections = 256;  ///< Of all users together.
  static constexpr std::size_t kConnectionsPerUser = 64;
  static constexpr std::size_t kStopOnly = 16, kStopOnlyPerUser = 4;  ///< Beyond those, for who comes to stop a device.
  static constexpr std::size_t kAdministrators = 16;          ///< Connections beside those: users leave them the room.
  static constexpr std::uint32_t kRegionsPerUser = 64;        ///< Region capabilities: each holds a descriptor of ours.
  static constexpr std::uint32_t kSubscriptionsPerUser = 64;  ///< Each may hold a queue of events.

  /** Beyond its numbers one that may stop devices and no more, or kQuotaExceeded. */
  [[nodiscard]] Result<std::uint64_t> connect(std::int32_t pid, std::uint32_t uid, bool administration);
  /** The connection to end first where nobody may come even to stop: the user's own oldest of that kind, or that of
   * all. */
  [[nodiscard]] std::optional<std::uint64_t> oldestToStop(std::uint32_t uid) const;
  /** Null when it has gone for good; one that has left is there until all of it is cleared away. */
  [[nodiscard]] Client* find(std::uint64_t connection);
  [[nodiscard]] const Client* find(std::uint64_t connection) const;
  /** And has not left. */
  [[nodiscard]] bool has(std::uint64_t connection) const {
    const Client* const client = find(connection);
    return client != nullptr && !client->left;
  }
  void remove(std::uint64_t connection) { all_.erase(connection); }
  [[nodiscard]] const std::map<std::uint64_t, Client>& all() const { return all_; }

  /** kQuotaExceeded if that user holds kRegionsPerUser already; else regionDropped() is due when it goes. */
  [[nodiscard]] Result<void> regionHandedOut(std::uint32_t uid);
  void regionDropped(std::uint32_t uid);
  /** A user; and whether by the administration socket, where subscriptions count apart. */
  using Subscriber = std::pair<std::uint32_t, bool>;
  /** kQuotaExceeded if there is no room for one more; else subscriptionDropped() is due when it goes. */
  [[nodiscard]] Result<void> subscriptionOpened(const Subscriber& by);
  void subscriptionDropped(const Subscriber& by);

 private:
  std::map<std::uint64_t, Client> all_;  ///< In the order they came.
  std::uint64_t next_ = 1;
  std::map<std::uint32_t, std::uint32_t> regions_out_;  ///< By user.
  std::map<Subscriber, std::uint32_t> subscriptions_;
};

}  // namespace hapticd
