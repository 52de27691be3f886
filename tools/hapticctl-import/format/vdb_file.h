/** @file
 * OpenVDB files: sparse images of other programs, and our own (daemon/builder/vdb/write_vdb.h).
 *
 * OpenVDB trusts a file: read in a process that may die (child.h).
 */
#pragma once

#include <string>
#include <vector>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/** Told by the first bytes. */
[[nodiscard]] bool isVdb(const std::string& path);

struct VdbGrid {
  std::string name;
  std::string text;            ///< In words: what it is, how many voxels.
  double metres_per_unit = 0;  ///< 0: the file does not say.
};

/** The grids of a file that can be used: floats or doubles with a linear transform. Throws ImportError if there is
 * none. */
[[nodiscard]] std::vector<VdbGrid> gridsOf(const std::string& path);

/** One of them, its active voxels and one more all around. Level sets become distances (Image::distances). Throws
 * ImportError, also for a grid of ours whose checksum does not match. */
[[nodiscard]] Image readVdb(const std::string& path, const VdbGrid& grid, double metres_per_unit);

}  // namespace hapticctl_import
