/** @file
 * Walls that are thinner than a volume's voxels.
 */
#pragma once

#include <string>

#include "rt/volume/volume_view.h"

namespace hapticd {

/**
 * That more than 5 % of a surface is of walls so thin that the distances show no inside behind it, in words; empty: it
 * is not. At sharp edges of a solid there is always some.
 */
[[nodiscard]] std::string noteOfThinWalls(const VolumeView& volume);

}  // namespace hapticd
