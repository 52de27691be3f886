/** @file
 * The voxel model of a surface, as hapticd would build it, for other programs.
 */
#pragma once

#include <string>

#include "tools/hapticctl-import/isosurface.h"

namespace hapticctl_import {

/**
 * Builds the surface's volume with voxels of that side, its bricks four voxels wide, and writes its distances as .vdb.
 * Gives what it was, in words. Throws ImportError.
 */
std::string writeModel(const Surface& surface, double voxel_mm, const std::string& path);

}  // namespace hapticctl_import
