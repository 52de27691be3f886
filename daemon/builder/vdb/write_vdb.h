/** @file
 * A volume as an OpenVDB file, for Blender, Houdini, vdb_print and whatever else reads one.
 *
 * Two grids: "surface", a level set in metres three voxels wide, and "states", whole numbers: 1 proximity, 2 surface, 3
 * full, and 0 (inactive) empty. In the metadata of each: metres_per_unit (1), and what checksumOf() gives; in that of
 * the file: hapticd_version, hapticd_volume_version, and hapticd_source, the checksums of what it was made of.
 */
#pragma once

#include <iosfwd>
#include <string>

#include "daemon/builder/volume/volume_source.h"
#include "rt/volume/volume_view.h"

namespace hapticd {

inline constexpr const char* kVdbUnit = "metres_per_unit";
inline constexpr const char* kVdbChecksum = "hapticd_checksum";
inline constexpr double kVdbHalfWidth = 3;  ///< Voxels: what other programs expect of a level set.

/**
 * `out` must be able to seek. `field` measures the same surface on latticeOf(volume); null if the volume's bricks reach
 * four voxels. kInternal with what OpenVDB says, kSystem if `out` fails.
 */
[[nodiscard]] Result<void> writeVdb(std::ostream& out, const VolumeView& volume, DistanceField* field,
                                    const std::string& source);

/**
 * Has OpenVDB do once whatever it does at first use, and never use a thread but the caller's: after that writeVdb()
 * makes no system call but for memory.
 */
void prepareVdb();

}  // namespace hapticd
