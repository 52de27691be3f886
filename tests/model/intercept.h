/** @file
 * Included before all else in whatever runs on the machine of weak_memory.h: leads the compiler's atomic built-ins, and
 * with them those of std::atomic, to it. Outside of a run they do what they always do.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace hapticd::model {

/** False: no run is on, do it yourself. */
[[nodiscard]] bool running();
std::uint64_t modelLoad(const void* at, std::size_t bytes, int order);
void modelStore(void* at, std::size_t bytes, std::uint64_t value, int order);
/** Stores next(old, with) for the last value that was stored, which is returned. */
std::uint64_t modelChange(void* at, std::size_t bytes, int order,
                          std::uint64_t (*next)(std::uint64_t old, std::uint64_t with), std::uint64_t with);

template <class T>
std::uint64_t bitsOf(T value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof value);
  return bits;
}
template <class T>
T fromBits(std::uint64_t bits) {
  T value;
  std::memcpy(static_cast<void*>(&value), &bits, sizeof value);
  return value;
}
template <class T>
using Plain = std::remove_cv_t<T>;

template <class T>
Plain<T> load(T* at, int order) {
  if (!running()) return __atomic_load_n(at, order);
  return fromBits<Plain<T>>(modelLoad(const_cast<const Plain<T>*>(at), sizeof(T), order));
}
template <class T, class V>
void store(T* at, V value, int order) {
  if (!running()) return __atomic_store_n(at, value, order);
  modelStore(const_cast<Plain<T>*>(at), sizeof(T), bitsOf(static_cast<Plain<T>>(value)), order);
}
template <class T, class V>
Plain<T> exchange(T* at, V value, int order) {
  if (!running()) return __atomic_exchange_n(at, value, order);
  const auto next = [](std::uint64_t, std::uint64_t with) { return with; };
  return fromBits<Plain<T>>(
      modelChange(const_cast<Plain<T>*>(at), sizeof(T), order, next, bitsOf(static_cast<Plain<T>>(value))));
}
template <class T, class V>
Plain<T> fetchAdd(T* at, V value, int order) {
  if (!running()) return __atomic_fetch_add(at, value, order);
  static_assert(std::is_integral_v<T>);
  const auto next = [](std::uint64_t old, std::uint64_t with) { return old + with; };  // What overflows is cut off.
  return fromBits<Plain<T>>(
      modelChange(const_cast<Plain<T>*>(at), sizeof(T), order, next, bitsOf(static_cast<Plain<T>>(value))));
}
template <class T, class V>
Plain<T> fetchSub(T* at, V value, int order) {
  return fetchAdd(at, static_cast<Plain<T>>(0 - static_cast<Plain<T>>(value)), order);
}
template <class T, class V>
void loadTo(T* at, V* out, int order) {
  if (!running()) return __atomic_load(at, out, order);
  *out = fromBits<V>(modelLoad(const_cast<const Plain<T>*>(at), sizeof(V), order));
}
template <class T, class V>
void storeFrom(T* at, V* value, int order) {
  if (!running()) return __atomic_store(at, value, order);
  modelStore(const_cast<Plain<T>*>(at), sizeof(V), bitsOf(*value), order);
}

}  // namespace hapticd::model

// NOLINTBEGIN(bugprone-reserved-identifier,cppcoreguidelines-macro-usage)
#define __atomic_load_n(at, order) ::hapticd::model::load(at, static_cast<int>(order))
#define __atomic_store_n(at, value, order) ::hapticd::model::store(at, value, static_cast<int>(order))
#define __atomic_exchange_n(at, value, order) ::hapticd::model::exchange(at, value, static_cast<int>(order))
#define __atomic_fetch_add(at, value, order) ::hapticd::model::fetchAdd(at, value, static_cast<int>(order))
#define __atomic_fetch_sub(at, value, order) ::hapticd::model::fetchSub(at, value, static_cast<int>(order))
#define __atomic_load(at, out, order) ::hapticd::model::loadTo(at, out, static_cast<int>(order))
#define __atomic_store(at, value, order) ::hapticd::model::storeFrom(at, value, static_cast<int>(order))
// NOLINTEND(bugprone-reserved-identifier,cppcoreguidelines-macro-usage)
