/** @file
 * Orders that wait for a servo.
 */
#pragma once

#include <cstddef>
#include <list>

#include "rt/command.h"

namespace hapticd {

/** First in, first out, with room for kSpare ahead of need: what must be said is said where there is no memory, too. */
class Outbox {
 public:
  static constexpr std::size_t kSpare = 256;

  Outbox() : spare_(kSpare) {}

  /** Throws std::bad_alloc, and then changes nothing, only where kSpare have been pushed without memory. */
  void push(const Command& order) {
    if (spare_.empty()) {
      orders_.push_back(order);
      return;
    }
    spare_.front() = order;
    orders_.splice(orders_.end(), spare_, spare_.begin());
  }
  void pop() noexcept {
    if (spare_.size() < kSpare) {
      spare_.splice(spare_.end(), orders_, orders_.begin());
    } else {
      orders_.pop_front();
    }
  }
  [[nodiscard]] const Command& front() const { return orders_.front(); }
  [[nodiscard]] std::size_t size() const { return orders_.size(); }
  [[nodiscard]] bool empty() const { return orders_.empty(); }
  /** Those that wait may be replaced. */
  [[nodiscard]] auto begin() { return orders_.begin(); }
  [[nodiscard]] auto end() { return orders_.end(); }

 private:
  std::list<Command> orders_, spare_;
};

}  // namespace hapticd
