/** @file
 * Single-producer single-consumer ring between two threads of one process that trust each other. For memory shared with
 * a client see command_ring.h.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "rt/base/contract.h"

namespace hapticd {

/**
 * Wait-free on both sides. Indices run freely and are masked on access; they wrap at 2^32, which `N` divides, so that
 * tail - head is the fill even across the wrap. Each side caches the other's index and reads it only when it must.
 */
template <class T, std::uint32_t N>
class SpscRing {
  static_assert(N != 0 && (N & (N - 1)) == 0, "capacity is a power of two");
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  static constexpr std::uint32_t kCapacity = N;

  /** Producer. False when full. */
  bool push(const T& value) HD_RT {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_seen_ == N) {
      head_seen_ = head_.load(std::memory_order_acquire);  // A1, pairs with R1: the slot has been read
      if (tail - head_seen_ == N) return false;
    }
    slot_[tail & (N - 1)] = value;
    tail_.store(tail + 1, std::memory_order_release);  // R0, pairs with A0: the slot is written
    return true;
  }

  /** Consumer. False when empty. */
  bool pop(T& value) HD_RT {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_seen_) {
      tail_seen_ = tail_.load(std::memory_order_acquire);  // A0, pairs with R0
      if (head == tail_seen_) return false;
    }
    value = slot_[head & (N - 1)];
    head_.store(head + 1, std::memory_order_release);  // R1, pairs with A1
    return true;
  }

  /** Either side. The other may have moved since: a bound from above for the producer, from below for the consumer. */
  [[nodiscard]] std::uint32_t size() const HD_RT {
    return tail_.load(std::memory_order_acquire) - head_.load(std::memory_order_acquire);
  }
  /** For any thread, together: an index past all that was pushed, and whether all before an index has been popped. */
  [[nodiscard]] std::uint32_t pushed() const HD_RT { return tail_.load(std::memory_order_acquire); }
  [[nodiscard]] bool passed(std::uint32_t index) const HD_RT {
    return static_cast<std::int32_t>(head_.load(std::memory_order_acquire) - index) >= 0;  // A1, pairs with R1
  }

 private:
  alignas(128) std::atomic<std::uint32_t> tail_{0};
  std::uint32_t head_seen_ = 0;  // producer's
  alignas(128) std::atomic<std::uint32_t> head_{0};
  std::uint32_t tail_seen_ = 0;  // consumer's
  alignas(128) std::array<T, N> slot_{};
};

}  // namespace hapticd
