/** @file
 * Which mesh has a volume: what the collide threads look up.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "rt/base/contract.h"
#include "rt/command.h"

namespace hapticd {

struct VolumeView;

/**
 * Volumes by entry of the mesh table; read-only, so one table serves every group. The control thread publishes a view
 * before the command that names its mesh, and takes it back when every servo has passed the command that drops it: a
 * thread beside a servo must not keep a view longer than its servo keeps the mesh.
 */
class VolumeTable {
 public:
  void publish(std::uint32_t entry, const VolumeView* view) noexcept {
    views_[entry].store(view, std::memory_order_release);
  }
  /** Null: that mesh has none. */
  [[nodiscard]] const VolumeView* get(std::uint32_t entry) const HD_RT {
    return entry < kMaxMeshes ? views_[entry].load(std::memory_order_acquire) : nullptr;
  }

 private:
  std::array<std::atomic<const VolumeView*>, kMaxMeshes> views_{};
};

}  // namespace hapticd
