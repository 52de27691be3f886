/** @file
 * Reading and writing memory that another process may be writing at the same moment.
 *
 * Every access is an atomic one, so that it is defined in C++ whatever the other side does, happens exactly once (the
 * compiler may not read a field again after it was checked), and the thread sanitizer can judge it. Loads never write:
 * they work on a read-only mapping. The built-ins are used instead of std::atomic_ref because that has no const form in
 * C++20.
 */
#pragma once

#include <cstddef>
#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

template <class T>
[[nodiscard]] T loadRelaxed(const T& shared) HD_RT {
  T value;
  __atomic_load(&shared, &value, __ATOMIC_RELAXED);
  return value;
}

template <class T>
[[nodiscard]] T loadAcquire(const T& shared) HD_RT {
  T value;
  __atomic_load(&shared, &value, __ATOMIC_ACQUIRE);
  return value;
}

template <class T>
void storeRelaxed(T& shared, T value) HD_RT {
  __atomic_store(&shared, &value, __ATOMIC_RELAXED);
}

template <class T>
void storeRelease(T& shared, T value) HD_RT {
  __atomic_store(&shared, &value, __ATOMIC_RELEASE);
}

/** A 64-bit word of any structure. */
using SharedWord = std::uint64_t __attribute__((may_alias));

/** Words that hold `bytes`. */
[[nodiscard]] constexpr std::size_t sharedWords(std::size_t bytes) { return (bytes + 7) / 8; }

/**
 * Copies words out of shared memory, each loaded once with `Order` (relaxed or acquire). On x86-64 both orders are the
 * same plain loads. Both sides 8-byte aligned.
 */
template <int Order>
void copyFromShared(void* to, const void* shared, std::size_t words) HD_RT {
  auto* out = static_cast<SharedWord*>(to);
  const auto* in = static_cast<const SharedWord*>(shared);
  for (std::size_t i = 0; i < words; ++i) out[i] = __atomic_load_n(in + i, Order);
}

/** Copies words into shared memory, each stored once with `Order` (relaxed or release). */
template <int Order>
void copyToShared(void* shared, const void* from, std::size_t words) HD_RT {
  auto* out = static_cast<SharedWord*>(shared);
  const auto* in = static_cast<const SharedWord*>(from);
  for (std::size_t i = 0; i < words; ++i) __atomic_store_n(out + i, in[i], Order);
}

}  // namespace hapticd
