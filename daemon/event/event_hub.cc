#include "daemon/event/event_hub.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace hapticd {

std::uint64_t EventHub::subscribe(std::uint32_t kinds, std::function<void()> wake) {
  Subscriber subscriber;
  subscriber.kinds = kinds == 0 ? ~0u : kinds;
  subscriber.wake = std::move(wake);
  subscribers_.emplace(next_, std::move(subscriber));
  return next_++;
}

void EventHub::publish(const Event& event) noexcept {
  const std::uint32_t bit = 1u << static_cast<std::uint32_t>(event.kind);
  for (auto& [id, subscriber] : subscribers_) {
    if ((subscriber.kinds & bit) == 0) continue;
    try {
      if (subscriber.queue.size() < queue_) {
        subscriber.queue.push_back(event);
      } else {
        ++subscriber.lost;
      }
    } catch (const std::bad_alloc&) {
      ++subscriber.lost;
    }
    if (subscriber.awake || subscriber.queue.empty() || !subscriber.wake) continue;
    try {
      subscriber.wake();
      subscriber.awake = true;
    } catch (const std::exception&) {  // With the next event.
    }
  }
}

void EventHub::lost(std::uint64_t count) noexcept {
  for (auto& [id, subscriber] : subscribers_) subscriber.lost += count;
}

void EventHub::notTold(std::uint64_t id, std::uint64_t count) noexcept {
  const auto it = subscribers_.find(id);
  if (it == subscribers_.end()) return;
  it->second.lost += count;
  it->second.awake = false;
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
  subscriber.awake = !subscriber.queue.empty();
  return batch;
}

}  // namespace hapticd
