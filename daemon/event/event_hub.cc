#include "daemon/event/event_hub.h"

#include <algorithm>
#include <utility>

namespace hapticd {

std::uint64_t EventHub::subscribe(std::uint32_t kinds, std::function<void()> wake) {
  Subscriber subscriber;
  subscriber.kinds = kinds == 0 ? ~0u : kinds;
  subscriber.wake = std::move(wake);
  subscribers_.emplace(next_, std::move(subscriber));
  return next_++;
}

void EventHub::publish(const Event& event) {
  const std::uint32_t bit = 1u << static_cast<std::uint32_t>(event.kind);
  for (auto& [id, subscriber] : subscribers_) {
    if ((subscriber.kinds & bit) == 0) continue;
    if (subscriber.queue.size() >= queue_) {
      ++subscriber.lost;
      continue;
    }
    subscriber.queue.push_back(event);
    if (subscriber.queue.size() == 1 && subscriber.wake) subscriber.wake();
  }
}

void EventHub::lost(std::uint64_t count) {
  for (auto& [id, subscriber] : subscribers_) subscriber.lost += count;
}

EventHub::Batch EventHub::take(std::uint64_t id) {
  Batch batch;
  const auto it = subscribers_.find(id);
  if (it == subscribers_.end()) return batch;
  Subscriber& subscriber = it->second;
  const std::size_t count = std::min(subscriber.queue.size(), kMostPerCall);
  batch.events.assign(std::make_move_iterator(subscriber.queue.begin()),
                      std::make_move_iterator(subscriber.queue.begin() + static_cast<std::ptrdiff_t>(count)));
  subscriber.queue.erase(subscriber.queue.begin(), subscriber.queue.begin() + static_cast<std::ptrdiff_t>(count));
  if (!batch.events.empty()) batch.lost = std::exchange(subscriber.lost, 0);  // Else the next batch tells it.
  return batch;
}

}  // namespace hapticd
