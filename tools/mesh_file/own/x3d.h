/** @file
 * X3D in XML, read by ourselves. assimp (5.2) refuses files with nodes that it does not know, such as the surfaces of
 * H3D, heeds no `ccw`, leaves out sets of four corners, shows what a Switch hides, and draws cones, cylinders and
 * extrusions with holes or other shapes.
 */
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/mesh_file/polygons.h"

namespace hapticd_mesh_file {

/** Told by its name's ending. */
[[nodiscard]] bool isX3d(const std::string& path);

/**
 * What its shapes are, each in its place, in metres (the standard's unit, or by the one that the file names) with y up.
 * Balls and the like are made of flat faces, 128 around. Throws MeshError, also for geometry that is not known: nothing
 * with a surface is left out. Lines, points and texts are faces without a triangle. Any bytes can be given.
 *
 * @param inlined  The bytes of a file that is named, by a URI from the folder of the first one on; none if there is
 *                 none.
 */
[[nodiscard]] std::vector<Polygons> parseX3d(std::string_view bytes,
                                             const std::function<std::string(const std::string& name)>& inlined);

}  // namespace hapticd_mesh_file
