/** @file
 * Contacts of what is round, between two answers of the collide thread. A point tied to a ball that rolls climbs up its
 * back, and the plane tied to one that spins tilts with it; but of a ball only the centre matters.
 */
#pragma once

#include "rt/body/response.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** One of two bodies that touch. */
struct RoundBody {
  const Shape& shape;
  Pose X_WO;
};

/**
 * Where A or B is a sphere or a capsule, the touch becomes that of its ball where both are now; where A is a cylinder,
 * that of its round mantle, of which ToolPoints knows a prism's edges; else it stays. `feature`: ToolPoints' number of
 * A's point or ball. A's centre of mass is at com_W, and B turns with w_B; r_b is not looked at.
 */
void rollTo(const RoundBody& a, std::uint32_t feature, const RoundBody& b, const Vec3& com_W, const Vec3& w_B,
            Touch& touch) HD_RT;

}  // namespace hapticd
