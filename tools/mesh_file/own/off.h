/** @file
 * OFF files in words, read by ourselves. assimp (5.2) makes corners of what a cut line lacks, takes negative numbers of
 * vertices for others, and leaves out faces of more than nine corners.
 */
#pragma once

#include <string>
#include <string_view>

#include "tools/mesh_file/polygons.h"

namespace hapticd_mesh_file {

/** Told by its name's ending, or its first word. */
[[nodiscard]] bool isOff(const std::string& path);

/**
 * Places of its vertices, and its faces; normals, colours and texture coordinates are passed over. A vertex or a face
 * has a line of its own. Throws MeshError. Any bytes can be given.
 */
[[nodiscard]] Polygons parseOff(std::string_view bytes);

}  // namespace hapticd_mesh_file
