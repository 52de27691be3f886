/** @file
 * Boxes, balls, cones and cylinders as faces, about the origin, their axis along y as in X3D. Wound outward.
 */
#pragma once

#include <array>

#include "tools/mesh_file/polygons.h"

namespace hapticd_mesh_file {

[[nodiscard]] Polygons boxFaces(const std::array<double, 3>& size);
[[nodiscard]] Polygons ballFaces(double radius);

/** A cylinder, or a cone where a radius is 0. */
struct Frustum {
  double bottom_radius = 1, top_radius = 1, height = 2;
  bool side = true, bottom = true, top = true;  ///< What it has of them.
};
[[nodiscard]] Polygons frustumFaces(const Frustum& shape);

}  // namespace hapticd_mesh_file
