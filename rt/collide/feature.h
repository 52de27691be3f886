/** @file
 * What a contact's feature number says: which point of the tool, or which place of the obstacle, it is of.
 */
#pragma once

#include <cstdint>

#include "rt/collide/tool_points.h"

namespace hapticd {

// Below: points, balls and discs of A, by ToolPoints' number. All are below ContactModel's 2^24 - 1.
inline constexpr std::uint32_t kFirstBall = ToolPoints::kMost;  ///< Balls or discs of B that A's surface meets.
inline constexpr std::uint32_t kFirstEdge =
    4 * ToolPoints::kMost;                              ///< Places on edges of a box or cylinder B, three on each.
inline constexpr std::uint32_t kFirstRidge = 1u << 16;  ///< Places on ridges of a mesh B.
inline constexpr std::uint32_t kFeatures = (1u << 24) - 2;

// What of B is met by A's mantle (mantle.h).
inline constexpr std::uint32_t kBoxCorners = 8, kBoxEdges = 12, kRimArcs = 32, kRimParts = 16;
inline constexpr std::uint32_t kFirstBoxCorner = kFirstEdge + 3 * 2 * kRimArcs;
inline constexpr std::uint32_t kFirstBoxEdge = kFirstBoxCorner + kBoxCorners;
inline constexpr std::uint32_t kFirstRim = kFirstBoxEdge + kBoxEdges;  ///< Of a cylinder's two.
inline constexpr std::uint32_t kFirstPeak = 1u << 22;                  ///< Vertices of a mesh,
/** And its edges: triangle times 3 plus corner. Of a sphere A it says which triangle, and of a sheet the side, instead
 * of the corner (ballFeature()). */
inline constexpr std::uint32_t kFirstMeshEdge = 1u << 23;

/** No place: the whole of A and the whole of B are in each other (way_out.cc). No edge has that number. */
inline constexpr std::uint32_t kWayOut = kFeatures;

/** Whether it says of which corner, edge or rim of B: the touch turns with it from tick to tick (mantle.h). */
[[nodiscard]] constexpr bool isOfMantle(std::uint32_t feature) {
  return (feature >= kFirstBoxCorner && feature < kFirstRidge) || feature >= kFirstPeak;
}
/** Of a vertex of B; 0: its number is too large. */
[[nodiscard]] constexpr std::uint32_t peakFeature(std::uint32_t vertex) {
  return vertex < kFirstMeshEdge - kFirstPeak ? kFirstPeak + vertex : 0;
}
/** Of the edge that leaves that corner of a triangle of B; 0: its number is too large. */
[[nodiscard]] constexpr std::uint32_t meshEdgeFeature(std::uint32_t triangle, std::uint32_t corner) {
  return triangle < (kFeatures - kFirstMeshEdge) / 3 ? kFirstMeshEdge + 3 * triangle + corner : 0;
}
/** Of a sphere A on a triangle of B; `side`: of a sheet 1 or -1, of what has an inside 0. 0: its number is too large.
 */
[[nodiscard]] constexpr std::uint32_t ballFeature(std::uint32_t triangle, int side) {
  return meshEdgeFeature(triangle, side < 0 ? 2 : static_cast<std::uint32_t>(side));
}
/** The side that ballFeature() was told. */
[[nodiscard]] constexpr int sideOfBall(std::uint32_t feature) {
  const std::uint32_t corner = (feature - kFirstMeshEdge) % 3;
  return corner == 2 ? -1 : static_cast<int>(corner);
}

}  // namespace hapticd
