/** @file
 * Where the control thread's orders for one servo go. The scene writes to every sink alike.
 */
#pragma once

#include <cstdint>

#include "rt/cycle/pose_board.h"

namespace hapticd {

/** Control thread only. Orders are kept until the servo has room; none is lost and their order stays. */
class CommandSink {
 public:
  virtual ~CommandSink() = default;
  /** Queues the order and gives its ticket. */
  virtual std::uint64_t post(const Command& command) = 0;
  /** The last ticket given. */
  [[nodiscard]] virtual std::uint64_t posted() const = 0;
  /** The servo has taken the order of that ticket; conservative. */
  [[nodiscard]] virtual bool passed(std::uint64_t ticket) = 0;
  /** False when too many orders wait, of whom they are given for or in all: refuse the edit before changing anything.
   */
  [[nodiscard]] virtual bool accepting() const = 0;
  /** Number of the tick that takes an order given now, if the servo has room for it. */
  [[nodiscard]] virtual std::uint64_t nextTick() const = 0;
  /** Of the servo: what is resampled for it depends on it. */
  [[nodiscard]] virtual std::int64_t periodNs() const = 0;
  /** Where this servo's copies of the meshes and textures are published. */
  [[nodiscard]] virtual MeshTable& meshes() = 0;
  /** What stands in that scene slot, if it reflects the order of `ticket` already. */
  [[nodiscard]] virtual bool posed(std::uint32_t slot, std::uint64_t ticket, PosedObject& out) = 0;
};

}  // namespace hapticd
