#include "daemon/control/clients.h"

#include <fmt/format.h>

#include "daemon/log/log.h"

namespace hapticd {

Result<std::uint64_t> Clients::connect(std::int32_t pid, std::uint32_t uid, bool administration) {
  const auto counted = [&](bool stop_only) {
    std::size_t all = 0, same = 0;
    for (const auto& [number, other] : all_) {
      if (other.administration != administration || other.stop_only != stop_only) continue;
      ++all;
      same += other.uid == uid ? 1 : 0;
    }
    return std::pair(all, same);
  };
  const auto [all, same] = counted(false);
  const bool full = administration ? all >= kAdministrators : all >= kConnections || same >= kConnectionsPerUser;
  const auto [all_to_stop, same_to_stop] = counted(true);
  if (full && (administration || all_to_stop >= kStopOnly || same_to_stop >= kStopOnlyPerUser)) {
    return Error{ErrorCode::kQuotaExceeded, "connection",
                 fmt::format("user {} has {} of {} connections", uid, same, all), "close some"};
  }
  Client client;
  client.stop_only = full;
  client.connection = next_;
  client.pid = pid;
  client.uid = uid;
  client.administration = administration;
  all_.emplace(next_, client);
  log::debug("connection {}: pid {} uid {}{}", next_, pid, uid,
             administration ? " (administration)" : (full ? " (to stop devices)" : ""));
  return next_++;
}

std::optional<std::uint64_t> Clients::oldestToStop(std::uint32_t uid) const {
  std::optional<std::uint64_t> of_all;
  for (const auto& [number, client] : all_) {
    if (!client.stop_only || client.left) continue;
    if (client.uid == uid) return number;
    if (!of_all) of_all = number;
  }
  return of_all;
}

const Client* Clients::find(std::uint64_t connection) const {
  const auto it = all_.find(connection);
  return it == all_.end() ? nullptr : &it->second;
}

Client* Clients::find(std::uint64_t connection) {
  const auto it = all_.find(connection);
  return it == all_.end() ? nullptr : &it->second;
}

Result<void> Clients::regionHandedOut(std::uint32_t uid) {
  std::uint32_t& held = regions_out_[uid];
  if (held >= kRegionsPerUser) {
    return Error{ErrorCode::kQuotaExceeded, "region",
                 fmt::format("user {} holds {} regions, the most allowed", uid, kRegionsPerUser),
                 "map them and drop their capabilities"};
  }
  ++held;
  return {};
}

void Clients::regionDropped(std::uint32_t uid) {
  const auto it = regions_out_.find(uid);
  if (it != regions_out_.end() && --it->second == 0) regions_out_.erase(it);
}

Result<void> Clients::subscriptionOpened(const Subscriber& by) {
  std::size_t all = 0;
  for (const auto& [other, count] : subscriptions_) all += other.second == by.second ? count : 0;
  std::uint32_t& held = subscriptions_[by];
  if (held >= kSubscriptionsPerUser || all >= kConnections) {
    return Error{ErrorCode::kQuotaExceeded, "subscribe",
                 fmt::format("user {} has {} of {} subscriptions", by.first, held, all), "drop some"};
  }
  ++held;
  return {};
}

void Clients::subscriptionDropped(const Subscriber& by) {
  const auto it = subscriptions_.find(by);
  if (it != subscriptions_.end() && --it->second == 0) subscriptions_.erase(it);
}

}  // namespace hapticd
