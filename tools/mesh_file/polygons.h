/** @file
 * What a reader of mesh files finds in one, before polygons are cut and equal corners joined.
 */
#pragma once

#include <array>
#include <initializer_list>
#include <vector>

namespace hapticd_mesh_file {

/** Faces of any number of corners, one behind the other. Numbers of vertices may be too large. */
struct Polygons {
  std::vector<std::array<float, 3>> vertices;
  std::vector<unsigned> corners, sizes;  ///< Of all faces: numbers of vertices; how many each face has.

  void add(std::initializer_list<unsigned> face) {
    corners.insert(corners.end(), face);
    sizes.push_back(static_cast<unsigned>(face.size()));
  }
};

}  // namespace hapticd_mesh_file
