#include "tools/hapticctl/output/counts.h"

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/output/output.h"

namespace hapticctl {
namespace {

std::uint64_t after(std::uint64_t now, std::uint64_t start) { return now >= start ? now - start : now; }

Baseline::ClientCounts countsOf(const haptic_client_status& client) {
  return {client.received, client.rejected, client.stale};
}

}  // namespace

std::vector<Owned<haptic_statistics>> statisticsOf(const Daemon& daemon, const haptic_status& status, bool reset) {
  std::vector<Owned<haptic_statistics>> all;
  for (std::uint32_t i = 0; i < status.device_count; ++i) {
    try {
      all.push_back(daemon.ask<haptic_statistics>(haptic_get_statistics, status.devices[i]->uri, reset ? 1 : 0));
    } catch (const Failure& failure) {
      if (failure.code != "NOT_FOUND") throw;
      all.emplace_back();
    }
  }
  return all;
}

DeviceCounts countsOf(const haptic_device_status& device, const haptic_statistics* statistics) {
  DeviceCounts out{.missed = device.missed, .stale = device.stale};
  if (statistics != nullptr) {
    out.answers = statistics->collide_queries;
    out.cut_short = statistics->collide_exhausted;
    out.lost = statistics->collide_unsent;
  }
  return out;
}

std::string collideLine(const std::string& device, const DeviceCounts& counts) {
  const bool all_well = counts.cut_short == 0 && counts.lost == 0;
  return styled(all_well ? Style::kPlain : Style::kWarn,
                fmt::format("{}: collisions: {} answers, {} cut short, {} lost", device, grouped(counts.answers),
                            grouped(counts.cut_short), grouped(counts.lost))) +
         (all_well ? "\n" : " (hapticctl doctor)\n");
}

void Baseline::take(const haptic_device_status& device, const haptic_statistics* statistics) {
  devices_[device.uri] = countsOf(device, statistics);
}

void Baseline::take(const haptic_client_status& client) { clients_[client.session] = countsOf(client); }

DeviceCounts Baseline::since(const haptic_device_status& device, const haptic_statistics* statistics) const {
  DeviceCounts out = countsOf(device, statistics);
  const auto it = devices_.find(device.uri);
  if (it == devices_.end()) return out;
  for (auto count : {&DeviceCounts::missed, &DeviceCounts::stale, &DeviceCounts::answers, &DeviceCounts::cut_short,
                     &DeviceCounts::lost}) {
    out.*count = after(out.*count, it->second.*count);
  }
  return out;
}

Baseline::ClientCounts Baseline::since(const haptic_client_status& client) const {
  ClientCounts out = countsOf(client);
  const auto it = clients_.find(client.session);
  if (it == clients_.end()) return out;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = after(out[i], it->second[i]);
  return out;
}

}  // namespace hapticctl
