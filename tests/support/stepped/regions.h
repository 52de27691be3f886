/** @file
 * A session's two regions in plain memory, for tests of both ends in one process.
 */
#pragma once

#include <cstring>
#include <memory>
#include <span>

#include "rt/ring/state.h"

namespace hapticd::test {

struct Regions {
  explicit Regions(const RegionIdentity& identity = {})
      : a(std::make_unique<hd_region_a>()), b(std::make_unique<hd_region_b>()) {
    initialiseRegions(a.get(), b.get(), identity);
  }
  std::unique_ptr<hd_region_a> a;
  std::unique_ptr<hd_region_b> b;
};

template <class T>
std::span<const std::byte> bytesOf(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

template <class T>
T payloadOf(const hd_slot& slot) {
  T value;
  std::memcpy(&value, slot.payload, sizeof value);
  return value;
}

}  // namespace hapticd::test
