/** @file
 * The newest value from one thread to another: wait-free on both sides, whatever the other does.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/**
 * A double buffer with a third slot in between, so that neither side ever waits or repeats: the writer fills its own
 * slot and swaps it with the one between; the reader swaps that with its own. Older values are overwritten unseen.
 * One writer, one reader; T is copied.
 */
template <class T>
class Newest {
 public:
  /** The writer. */
  void put(const T& value) HD_RT {
    slot_[back_] = value;
    // R1, pairs with A1: the value is whole before it is there. And A2, pairs with R2: the reader has left that slot.
    back_ = between_.exchange(back_ | kNew, std::memory_order_acq_rel) & kIndex;
  }

  /** The reader. False, and `out` untouched, when nothing was put since the last take. */
  [[nodiscard]] bool take(T& out) HD_RT {
    if ((between_.load(std::memory_order_relaxed) & kNew) == 0) return false;
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & kIndex;  // A1, R2
    out = slot_[front_];
    return true;
  }

 private:
  static constexpr std::uint32_t kIndex = 3, kNew = 4;

  std::array<T, 3> slot_{};
  std::uint32_t back_ = 0;   ///< The writer's.
  std::uint32_t front_ = 1;  ///< The reader's.
  std::atomic<std::uint32_t> between_{2};
};

}  // namespace hapticd
