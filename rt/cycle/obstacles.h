/** @file
 * What a tool or a free body may touch soon: filled into the collide thread's question.
 */
#pragma once

#include <cstdint>
#include <span>

#include "rt/collide/request.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Whether a slot is that one, or below it in the tree. */
[[nodiscard]] bool isPartOf(const Scene& scene, std::uint32_t slot, std::uint32_t of) HD_RT;

/** Time in which the collide thread has answered anew [s]. */
inline constexpr double kAnswerTime = 5e-3;

/** Whether contacts found before are of the object in that slot, where it is: it has not just come there by no motion.
 */
[[nodiscard]] inline bool isKnown(const Scene& scene, std::uint32_t slot) HD_RT {
  return scene.sinceArrival(slot) >= kAnswerTime;
}

/**
 * Touchable objects that are felt, within reach of `self` at held.X_WO; its own parts and those of the objects `but`
 * are none. Of more than there is room for, those whose balls are nearest. held.speed becomes that of whichever of the
 * ball's points is fastest relative to any of them: where the scene moves as a whole it is the same.
 */
void findObstacles(const Scene& scene, const SceneObject& self, std::span<const std::uint32_t> but,
                   CollideRequest::Held& held) HD_RT;

}  // namespace hapticd
