/** @file
 * Hands each event to every subscriber that wants its kind, through a bounded queue that counts what it lost.
 */
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <vector>

#include "daemon/event/event.h"

namespace hapticd {

/** Control thread only. */
class EventHub {
 public:
  static constexpr std::size_t kMostPerCall = 256;  ///< Events of one take().

  /** `queue`: events that may wait for one subscriber. */
  explicit EventHub(std::size_t queue = 1024) : queue_(queue) {}

  /** What a subscriber gets at once. */
  struct Batch {
    std::vector<Event> events;
    std::uint64_t lost = 0;  ///< Events that did not fit since the last batch.
  };

  /** `kinds`: a bit (1 << EventKind) each, 0 for all. `wake` is called when the queue stops being empty; again with the
   * next event if it throws. */
  std::uint64_t subscribe(std::uint32_t kinds, std::function<void()> wake);
  void unsubscribe(std::uint64_t id) { subscribers_.erase(id); }

  /** An event for which there is no memory is lost: whoever publishes is in the middle of something. */
  void publish(const Event& event) noexcept;
  /** Adds to what every subscriber is told it lost: the servo's own queue was full, or an event could not be made. */
  void lost(std::uint64_t count) noexcept;
  /** That subscriber could not be told of so many that it had taken; it is woken again with the next event. */
  void notTold(std::uint64_t id, std::uint64_t count) noexcept;
  /** Oldest first; empty when there is nothing to tell. */
  [[nodiscard]] Batch take(std::uint64_t id);

 private:
  struct Subscriber {
    std::uint32_t kinds = 0;
    std::function<void()> wake;
    std::deque<Event> queue;
    std::uint64_t lost = 0;
    bool awake = false;  ///< It takes until the queue is empty.
  };
  std::size_t queue_;
  std::map<std::uint64_t, Subscriber> subscribers_;
  std::uint64_t next_ = 1;
};

}  // namespace hapticd
