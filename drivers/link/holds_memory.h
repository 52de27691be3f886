/** @file
 * For devices that keep much in memory while they are open.
 */
#pragma once

#include <cstddef>

namespace hapticd {

/** A Device that holds locked memory beside its own state: the rows of a recorded motion. */
class HoldsMemory {
 public:
  virtual ~HoldsMemory() = default;
  /** While it is open; else 0. Not while another thread opens or closes it. */
  [[nodiscard]] virtual std::size_t heldBytes() const noexcept = 0;
};

}  // namespace hapticd
