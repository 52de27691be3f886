/** @file
 * Where a recording begins: a state of the cycle that a new one reaches by orders alone. No copy of its insides, so
 * that a recording outlives the build that made it.
 */
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "rt/cycle/cycle.h"

namespace hapticd {

/** Everything before the first CycleInput. */
struct CycleStart {
  struct Resolution {
    double position = 0, rotation = 0;  ///< As Cycle::setResolution().
  };
  CycleConfig config;  ///< With the limits in force.
  std::array<Resolution, kMaxDevices> resolution;
  std::uint64_t tick = 0;   ///< Of the cycle before the first.
  std::int64_t now_ns = 0;  ///< Its time.
  std::vector<Command> orders;
};

/**
 * Adds the orders that give a new cycle what `cycle` knows of devices and sessions: latched faults; sessions with their
 * limits, models and forces in force, for what is left of their leases; commands that wait for their tick. Left out is
 * what the hand feels only through armed devices: contacts, blends, velocities. The scene has to stand before these
 * orders. Not while the cycle is stepped.
 */
void restate(const Cycle& cycle, std::int64_t now_ns, std::vector<Command>& orders);

/** A new cycle in that state. The orders are applied in their order, at the start's tick. Allocates. */
[[nodiscard]] std::unique_ptr<Cycle> makeCycle(const CycleStart& start, const MeshTable& meshes);

}  // namespace hapticd
