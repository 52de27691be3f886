/** @file
 * The closed surface about what is dense in an image.
 */
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/** Indexed triangles, counter-clockwise seen from outside. */
struct Surface {
  std::vector<std::array<float, 3>> vertices;  ///< [mm], as the image's place says.
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/** A solid known at lattice points: inside where every layer has at least `iso`. */
struct LatticeSolid {
  std::array<std::uint32_t, 3> size{};         ///< Points along each axis.
  std::vector<std::span<const float>> layers;  ///< Values, x fastest.
  float iso = 0;
  bool mirrored = false;                         ///< `place` makes left-handed axes.
  std::function<Double3(const Double3&)> place;  ///< Of what lies between lattice points, in their numbers [mm].
};

/**
 * As below, of all layers: a vertex stands where the first of them crosses. Two solids that share a layer, one of them
 * with its sign turned, share the vertices of that cut to the bit. Throws ImportError for more than a million points
 * along an axis.
 */
[[nodiscard]] Surface isosurface(const LatticeSolid& solid);

/**
 * The surface between values of at least `iso` and those below, by marching tetrahedra: each cell of eight values is
 * cut into six tetrahedra along its diagonal (Kuhn), the same way everywhere, so that neighbours agree and the surface
 * is closed and 2-manifold by construction. About the image everything is empty. Vertices stand where the value is
 * linear interpolation's iso, at least a hundredth of the edge from its ends.
 */
[[nodiscard]] Surface isosurface(const Image& image, float iso);

/** Keeps the connected part with the most triangles. Returns how many parts there were. */
std::size_t keepLargest(Surface& surface);

/** Enclosed volume [mm^3]; positive if it looks outward. */
[[nodiscard]] double volumeOf(const Surface& surface);

/** Binary little-endian PLY. */
[[nodiscard]] std::string toPly(const Surface& surface);

}  // namespace hapticctl_import
