/** @file
 * What a tool or a free body may touch soon: filled into the collide thread's question.
 */
#pragma once

#include <cstdint>
#include <span>

#include "rt/body/rigid_body.h"
#include "rt/collide/request.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Whether a slot is that one, or below it in the tree. */
[[nodiscard]] bool isPartOf(const Scene& scene, std::uint32_t slot, std::uint32_t of) HD_RT;

/** No point of an object's ball is faster, as this body carries it [m/s]. */
[[nodiscard]] double speedBound(const RigidBody& body, const SceneObject& object) HD_RT;

/**
 * Touchable objects that are felt, within reach of `self` at held.X_WO; its own parts and those of the objects `but`
 * are none. Of more than there is room for, those whose balls are nearest. The speed of the fastest is added to
 * held.speed, which is that of `self` on entry.
 */
void findObstacles(const Scene& scene, const SceneObject& self, std::span<const std::uint32_t> but,
                   CollideRequest::Held& held) HD_RT;

}  // namespace hapticd
