/** @file
 * OpenVDB files: sparse images of other programs, and the distances of ours for them.
 *
 * OpenVDB trusts a file: read in a process that may die (child.h).
 */
#pragma once

#include <string>
#include <vector>

#include "rt/volume/volume_view.h"
#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/** Told by the first bytes. */
[[nodiscard]] bool isVdb(const std::string& path);

struct VdbGrid {
  std::string name;
  std::string text;            ///< In words: what it is, how many voxels.
  double metres_per_unit = 0;  ///< 0: the file does not say.
};

/** The grids of a file that can be used: floats with a linear transform. Throws ImportError if there is none. */
[[nodiscard]] std::vector<VdbGrid> gridsOf(const std::string& path);

/** One of them, about its active voxels. Level sets become distances (Image::distances). Throws ImportError. */
[[nodiscard]] Image readVdb(const std::string& path, const VdbGrid& grid, double metres_per_unit);

/**
 * The distances of a volume three voxels about its surface, as a level set in metres named "surface"; the volume's band
 * must be four voxels at least. Throws ImportError.
 */
void writeVdb(const std::string& path, const hapticd::VolumeView& volume);

}  // namespace hapticctl_import
