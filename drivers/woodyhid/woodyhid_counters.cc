#include "drivers/woodyhid/woodyhid_counters.h"

#include <algorithm>

namespace hapticd {

std::shared_ptr<WoodyPlugged> WoodyCounters::of(const HidPlugged& plugged) {
  const std::lock_guard lock(mutex_);
  const auto its = [&](const auto& one) { return one->device == plugged.device; };
  for (const auto& one : seen_) {
    if (its(one) && one->plugging == plugged.plugging && !plugged.plugging.empty()) return one;
  }
  auto one = std::make_shared<WoodyPlugged>();
  one->device = plugged.device;
  one->plugging = plugged.plugging;
  const auto& beside = plugged.beside;
  const auto may_be_it = [&](const auto& before) {
    return its(before) && std::find(beside.begin(), beside.end(), before->plugging) == beside.end();
  };
  one->lost.store(std::any_of(seen_.begin(), seen_.end(), may_be_it));
  const auto before = std::count_if(seen_.begin(), seen_.end(), its);
  seen_.push_back(one);
  if (static_cast<std::size_t>(before) >= kMostOfOne) seen_.erase(std::find_if(seen_.begin(), seen_.end(), its));
  return one;
}

}  // namespace hapticd
