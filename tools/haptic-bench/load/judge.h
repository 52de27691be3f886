/** @file
 * What a servo's samples say of the force that was felt, against the native force at the same places of the hand.
 */
#pragma once

#include <hapticclient/session.h>

#include <span>

#include "tools/haptic-bench/load/built_surface.h"
#include "tools/haptic-bench/load/stepped.h"

namespace haptic_bench {

/**
 * The share of the force that `source` gave, against that of a scene with the mesh alone, of that stiffness [N/m],
 * whose hand comes from outside. Throws Failure when the hand was never in the mesh: no error can be given of no force.
 */
[[nodiscard]] ForceError judgeForces(std::span<const haptic_sample> samples, const BuiltSurface& surface, Source source,
                                     double stiffness);

}  // namespace haptic_bench
