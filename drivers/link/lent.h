/** @file
 * What safe() reaches a device through, which the thread that owns it gives up when the device goes.
 */
#pragma once

#include <time.h>

#include <atomic>
#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/** A handle (a pointer, a descriptor; `kNone` is none) of one owner, used by any thread and by a signal handler. */
template <class T, T kNone>
class Lent {
 public:
  /** The owner, of what is whole. */
  void lend(T handle) noexcept { handle_.store(handle); }
  /** The owner's own. */
  [[nodiscard]] T get() const noexcept { return handle_.load(std::memory_order_relaxed); }
  /** The owner. Gives back what was lent, when nobody uses it any more: waits for as long as a use takes. */
  T takeBack() noexcept {
    const T handle = handle_.exchange(kNone);  // D2: before users_ is read; pairs with D1
    constexpr timespec kLook{0, 20'000};
    while (users_.load() != 0) (void)clock_nanosleep(CLOCK_MONOTONIC, 0, &kLook, nullptr);  // A, pairs with R
    return handle;
  }

  /** Anybody: use(handle), if one is lent. It stays valid until then. */
  template <class Use>
  void use(Use&& use) noexcept {
    users_.fetch_add(1);  // D1: before handle_ is read; pairs with D2
    if (const T handle = handle_.load(); handle != kNone) use(handle);
    users_.fetch_sub(1, std::memory_order_release);  // R
  }

 private:
  std::atomic<T> handle_{kNone};
  std::atomic<std::uint32_t> users_{0};
};

}  // namespace hapticd
