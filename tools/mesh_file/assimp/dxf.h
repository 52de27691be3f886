/** @file
 * What assimp (5.2) makes another thing of in DXF files: blocks that are inserted otherwise than by a shift.
 */
#pragma once

#include <string_view>

namespace hapticd_mesh_file {

/**
 * Throws MeshError if a file inserts a block with faces turned, in rows, upside down, scaled beside the origin, or in
 * another block: it would stand elsewhere than in the program that made it, or not at all. Of bytes that are no DXF it
 * says nothing. Any bytes can be given.
 */
void requirePlainInserts(std::string_view bytes);

}  // namespace hapticd_mesh_file
