/** @file
 * Contacts of what is round, between two answers of the collide thread. A point tied to a ball that rolls climbs up its
 * back, and the plane tied to one that spins tilts with it; but of a ball only the centre matters.
 */
#pragma once

#include <cstdint>

#include "rt/body/response.h"
#include "rt/geometry/nearest/nearest.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** One of two bodies that touch. */
struct RoundBody {
  const Shape& shape;
  Pose X_WO;
};

/** A sphere or a capsule: balls of one radius along an axis. */
[[nodiscard]] inline bool isRound(const Shape& shape) HD_RT {
  return shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule;
}
/** What has a mantle: a cylinder's is made of discs about its axis. */
[[nodiscard]] inline bool hasMantle(const Shape& shape) HD_RT {
  return isRound(shape) || shape.kind == ShapeKind::kCylinder;
}
/** Half as long as a capsule's or cylinder's axis; a sphere has none [m]. */
[[nodiscard]] inline double halfAxis(const Shape& shape) HD_RT {
  return shape.kind == ShapeKind::kSphere ? 0 : shape.size.y();
}

/** A's surface and a ball or disc of B, where they are nearest; in the world. */
struct BallTouch {
  Vec3 p_A;    ///< On A.
  Vec3 n;      ///< Unit, from B to A.
  double gap;  ///< Negative: inside [m].
};

/** With the ball or disc about `center`; `query`: reach from there and limit of work, in A's frame. Of a cylinder
 * kNone where A is nearer to an end than to its mantle. */
[[nodiscard]] NearestResult meetBall(const RoundBody& a, const RoundBody& b, const Vec3& center, NearestQuery& query,
                                     BallTouch& out) HD_RT;
/** The point of B's axis nearest to x_W. */
[[nodiscard]] Vec3 onAxis(const RoundBody& b, const Vec3& x_W) HD_RT;

/**
 * Where A or B is a sphere or a capsule, the touch becomes that of its ball where both are now; where A is a cylinder,
 * a disc's is that of its round mantle, and a corner or edge of B that meets the mantle is where it is now; else it
 * stays. A ball of A is met by the nearest point of a box or cylinder B, a sphere also by that of a mesh, near to the
 * triangle that the last answer found. `feature`: as in feature.h; a ball of B is met by the nearest point of a
 * primitive A. A's centre of mass is at com_W, and B turns with w_B; r_b is not looked at.
 */
void rollTo(const RoundBody& a, std::uint32_t feature, const RoundBody& b, const Vec3& com_W, const Vec3& w_B,
            Touch& touch) HD_RT;

}  // namespace hapticd
