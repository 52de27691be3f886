/** @file
 * Slots of the scene that hold no object.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/scene/scene.h"

namespace hapticd {

/** Longest free first, so that a stale id stays refused for long. Needs no memory beyond itself. */
class FreeSlots {
 public:
  FreeSlots() {
    for (std::uint32_t slot = 1; slot < kMaxObjects; ++slot) giveBack(slot);
  }

  /** 0: there is none. */
  [[nodiscard]] std::uint32_t first() const noexcept { return count_ == 0 ? 0 : ring_[at_]; }
  void takeFirst() noexcept {
    at_ = (at_ + 1) % kMaxObjects;
    --count_;
  }
  void giveBack(std::uint32_t slot) noexcept { ring_[(at_ + count_++) % kMaxObjects] = slot; }

 private:
  std::array<std::uint32_t, kMaxObjects> ring_{};
  std::uint32_t at_ = 0, count_ = 0;
};

}  // namespace hapticd
