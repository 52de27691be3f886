/** @file
 * Corners, edges and rims of an obstacle that meet the mantle of a cylinder or a capsule in one point. Such a place is
 * told by the number of its edge (feature.h), not tied to the mantle, so that each tick sees it where both are now, as
 * what is round (round.h).
 */
#pragma once

#include <cstdint>

#include "rt/scene/scene.h"

namespace hapticd {

/** Whether it has a mantle about its z axis, of a radius size.x() and half as long as size.y(). */
[[nodiscard]] inline bool isAboutAxis(const Shape& shape) HD_RT {
  return shape.kind == ShapeKind::kCylinder || shape.kind == ShapeKind::kCapsule;
}

/** In the obstacle's frame. */
struct ObstacleEdge {
  Vec3 from = Vec3::Zero(), to = from;  ///< Of a corner one place, of a rim its middle.
  double radius = 0;                    ///< Of a rim about z, else 0 [m].
  /** Whether a straight edge may go on beyond its ends: a mesh has many in one line, and the place that is met leaves
   * one for the next before the next answer. */
  bool goes_on = false;

  [[nodiscard]] bool isRim() const HD_RT { return radius > 0; }
  [[nodiscard]] bool isCorner() const HD_RT { return !isRim() && from == to; }
};

/** That of a feature number, where it is one of these of the obstacle's. */
[[nodiscard]] bool edgeOfFeature(const Shape& obstacle, std::uint32_t feature, ObstacleEdge& out) HD_RT;

/** What an edge nearest to an axis meets of a mantle about it. */
enum class MantleMeeting : std::uint8_t {
  kNone,
  kAlong,   ///< The edge lies along the axis, which discs and balls tell.
  kBeyond,  ///< It is nearest beyond an end.
  kMet
};

/** Where an edge is nearest to an axis; in the frame of what has the axis. */
struct MantleTouch {
  double t;    ///< Of a straight edge, the place on it: from 0 to 1, or beyond.
  Vec3 x;      ///< That place.
  Vec3 n;      ///< Unit, from there to the axis and across it.
  double gap;  ///< Along it, to the mantle; negative: inside [m].
};

/**
 * Of an edge in a frame at X_AE; on a rim the place nearest to the axis about `start`, in the edge's frame. kNone also
 * where it is nearer to a cylinder's end than to its mantle, or on the axis; `out` is of use where it is met.
 */
[[nodiscard]] MantleMeeting meetMantle(const Shape& a, const ObstacleEdge& edge, const Pose& X_AE, const Vec3& start,
                                       MantleTouch& out) HD_RT;

/** Whether what touches the mantle there is told as its (mantle_obstacle.cc, discs, balls): else, about a cylinder's
 * rim, the edge may touch both and be left by each to the other. */
[[nodiscard]] inline bool isMantles(const Shape& a, const ObstacleEdge& edge, const Pose& X_AE,
                                    const Vec3& start) HD_RT {
  MantleTouch touch;
  return a.kind == ShapeKind::kCapsule || meetMantle(a, edge, X_AE, start, touch) != MantleMeeting::kBeyond;
}

}  // namespace hapticd
