/** @file
 * An algorithm in the box behind the same table as those from shared objects.
 */
#pragma once

#include <cstdio>
#include <exception>

#include "rt/base/math.h"
#include "tools/haptic-bench/model/model.h"
#include "tools/haptic-bench/plugin/haptic_algorithm.h"

namespace haptic_bench {

/** The triangles of a problem. */
[[nodiscard]] Model modelOf(const haptic_algorithm_problem& problem);

/**
 * The table of a class T with T(const haptic_algorithm_problem&), start(hip), step(hip, v, dt, contact&) and bytes().
 * What its constructor throws becomes the sentence of create().
 */
template <class T>
[[nodiscard]] constexpr haptic_algorithm nativeAlgorithm(const char* name, const char* summary) {
  haptic_algorithm table{};
  table.version = HAPTIC_ALGORITHM_VERSION;
  table.bytes = sizeof(haptic_algorithm);
  table.name = name;
  table.summary = summary;
  table.create = [](const haptic_algorithm_problem* problem, char* error, std::size_t error_bytes) -> void* {
    try {
      return new T(*problem);
    } catch (const std::exception& e) {
      std::snprintf(error, error_bytes, "%s", e.what());
      return nullptr;
    }
  };
  table.destroy = [](void* instance) { delete static_cast<T*>(instance); };
  table.start = [](void* instance, const double* hip) {
    static_cast<T*>(instance)->start(Vec3(hip[0], hip[1], hip[2]));
  };
  table.step = [](void* instance, const double* hip, const double* v, double dt_s, haptic_algorithm_contact* contact) {
    static_cast<T*>(instance)->step(Vec3(hip[0], hip[1], hip[2]), Vec3(v[0], v[1], v[2]), dt_s, *contact);
  };
  table.memory_bytes = [](void* instance) -> std::uint64_t { return static_cast<T*>(instance)->bytes(); };
  return table;
}

/** Throws Failure: for algorithms that know only a point. */
void refuseBall(const haptic_algorithm_problem& problem);

inline void answer(haptic_algorithm_contact& contact, const Vec3& force, const Vec3& proxy, bool touches) {
  hapticd::store(force, contact.force);
  hapticd::store(proxy, contact.proxy);
  contact.touches = touches ? 1 : 0;
}

}  // namespace haptic_bench
