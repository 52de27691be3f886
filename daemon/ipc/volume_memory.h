/** @file
 * A volume in the daemon's memory: mapped, checked, locked, ready for the collide threads.
 */
#pragma once

#include "daemon/ipc/memfd.h"
#include "rt/volume/volume_view.h"

namespace hapticd {

/** Owns the memory that `view` points into. Its readers must have passed before it goes. */
struct VolumeMemory {
  Mapping mapping;
  VolumeView view;
};

/**
 * Takes a volume that the builder made (or that was read from a cache file): requires Seals::kFrozen, maps it,
 * validates all of it and, if `lock`, locks it. Control thread; about 10 ms for 10 MB.
 */
[[nodiscard]] Result<VolumeMemory> openVolume(UniqueFd fd, bool lock);

}  // namespace hapticd
