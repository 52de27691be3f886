/** @file
 * A ball (or, with radius 0, a point) swept along a segment against one shape: where it first enters the solid, and
 * the tangent plane there.
 *
 * A ball enters where its centre enters the solid grown by the radius: faces move out, edges become cylinders, vertices
 * balls. What is said of the surface below is, for a ball, said of this grown one.
 *
 * All in the shape's frame. A solid is entered from outside only: a segment that starts inside, deeper than the
 * tolerance, meets nothing. The tolerance belongs to rounding, not to the surface: it catches a start that lies on the
 * surface or behind it by a few units in the last place, and moves no surface. Servo-safe.
 */
#pragma once

#include <cstdint>

#include "rt/base/math.h"
#include "rt/geometry/feature.h"
#include "rt/geometry/triangle.h"
#include "rt/scene/scene.h"

namespace hapticd {

class Vicinity;

/** The swept centre: a + t d, t in [0, 1]. */
struct Sweep {
  Vec3 a = Vec3::Zero();
  Vec3 d = Vec3::Zero();
  double radius = 0;       ///< Of the ball [m].
  double tolerance = 0;    ///< Depth at which a start still counts as outside [m].
  bool two_sided = false;  ///< Both faces of triangles stop the point, from `tolerance` before them.
  /** A triangle of the mesh that may well be met first: tried first, it shortens the search, whose answer is the same.
   */
  std::uint32_t hint = HD_NO_INDEX;
  /**
   * Unit, or zero: a direction in which much of the mesh may well lie below all of the way. Looked at before anything
   * else of a triangle; any will do, and the answer is the same.
   */
  Vec3 above = Vec3::Zero();
  /** Triangles of the mesh about the start, if somebody keeps them: asked instead of the tree as far as they reach. */
  Vicinity* vicinity = nullptr;
  std::uint32_t work = 0;   ///< In and out: tree nodes and triangles visited, primitives too.
  std::uint32_t limit = 0;  ///< Of `work`.
};

inline constexpr double kAtEnd = 1 - 0x1p-53;  ///< The last moment of a way: when it meets what it ends on.

/** First entry. */
struct SweepHit {
  double t = 1;                ///< Fraction of the segment, in [0, 1).
  double height = 0;           ///< Of the start above the tangent plane or surface [m]; may be negative by rounding.
  Vec3 normal = Vec3::Zero();  ///< Outward, unit; on an edge or vertex from the contact point to the ball's centre.
  double offset = 0;           ///< The tangent plane that stops the centre is normal . x = offset.
  std::uint32_t feature = 0;   ///< Triangle, or face, edge or vertex of the primitive.
  FeatureKind kind = FeatureKind::kFace;
  std::uint32_t corner = 0;   ///< Of a triangle: which edge (01, 12, 20) or vertex, if it is one.
  Vec3 point = Vec3::Zero();  ///< Of contact, on the shape itself. Set by sweepShape().
};

enum class SweepResult : std::uint8_t { kNone, kHit, kExhausted };

/** First entry earlier than hit.t; `hit` is written only then. kExhausted: the work limit was met, nothing is known. */
[[nodiscard]] SweepResult sweepShape(const Shape& shape, Sweep& sweep, SweepHit& hit) HD_RT;

/** The shapes one by one. Those that take no radius of their own leave the ball's to sweepShape(). */
[[nodiscard]] bool sweepPlane(const Sweep& sweep, SweepHit& hit) HD_RT;
[[nodiscard]] bool sweepSphere(double radius, const Sweep& sweep, SweepHit& hit) HD_RT;
[[nodiscard]] bool sweepBox(const Vec3& half, const Sweep& sweep, SweepHit& hit) HD_RT;
[[nodiscard]] bool sweepCapsule(double radius, double half, const Sweep& sweep, SweepHit& hit) HD_RT;
[[nodiscard]] bool sweepCylinder(double radius, double half, const Sweep& sweep, SweepHit& hit) HD_RT;
/** A ball against box and cylinder: their edges are rounded. radius > 0. */
[[nodiscard]] bool sweepRoundBox(const Vec3& half, const Sweep& sweep, SweepHit& hit) HD_RT;
[[nodiscard]] bool sweepRoundCylinder(double radius, double half, const Sweep& sweep, SweepHit& hit) HD_RT;
/**
 * Point or ball against triangles. Of triangles met at the same time the one of the lowest number is the first, so that
 * the answer does not depend on the order in which they are tried. On a one-sided mesh an edge or vertex stops the ball
 * only from outside; a ball that overlaps one triangle is still stopped by those it does not touch yet.
 */
[[nodiscard]] SweepResult sweepMesh(const MeshView& mesh, Sweep& sweep, SweepHit& hit) HD_RT;
[[nodiscard]] SweepResult sweepBallOverMesh(const MeshView& mesh, Sweep& sweep, SweepHit& hit) HD_RT;

/** Whether a face of the shape has tangent planes of its own at each point. */
[[nodiscard]] inline bool isCurved(const Shape& shape, std::uint32_t feature) HD_RT {
  return shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule ||
         (shape.kind == ShapeKind::kCylinder && feature == 0);
}

/**
 * Normal and offset of the tangent plane of a curved feature, grown by `grown`, at its point nearest to x. False for
 * flat features, for edges and vertices, and where it is not unique (x on the axis or in the centre).
 */
[[nodiscard]] bool tangentNearest(const Shape& shape, std::uint32_t feature, const Vec3& x, Vec3& normal,
                                  double& offset, double grown = 0) HD_RT;

/** Skins from a surface: nearer, rounding and what a push leaves behind do not tell on which side of it a point is. */
inline constexpr double kLiesOn = 4;

/**
 * The other way round: a triangle that moves past a resting point x, one corner along a straight line. If it overtakes
 * the point, which is on that side of it (1: the front, or -1) or nearer than kLiesOn, the point is carried on with the
 * surface and left a skin above it. A point that is behind it already was pushed there: it is put above what covers it.
 */
[[nodiscard]] bool overtakes(const TriangleMove& move, int side, double skin, Vec3& x) HD_RT;

/** Whether x, seen along the normal, is within the triangle or a hair beside it. */
[[nodiscard]] bool covers(const Corners& triangle, const Vec3& x) HD_RT;

/** Where x comes to, which is to stay as high above the same place of a triangle; `weight`: of the corner that moves.
 */
[[nodiscard]] Vec3 takenAlong(const TriangleMove& move, double weight, const Vec3& x) HD_RT;

struct Ball {
  Vec3 center = Vec3::Zero();
  double radius = 0;
};
/** A ball about the shape; radius infinite for a plane, 0 for a group. */
[[nodiscard]] Ball boundingBall(const Shape& shape) HD_RT;

}  // namespace hapticd
