/** @file
 * Smooth shading of coarse meshes: the force is turned from the facet's normal to one interpolated between the corners
 * (Ruspini, Kolarov, Khatib, "The haptic display of complex graphical environments", SIGGRAPH 1997, section 4.3: force
 * shading).
 */
#pragma once

#include "rt/render/proxy.h"
#include "rt/scene/scene.h"

namespace hapticd {

/**
 * Turns contact.force where the surface touched asks for it (SurfaceParameters::smooth_cosine). The corners' normals
 * are angle-weighted over the facets about them as far as no edge between bends by more than that angle. The force
 * keeps its magnitude and its part across the normal, so a friction cone stays one; the proxy is not touched. Damping
 * is not turned but made anew along the turned normal, for a hand that moves at v_W [m/s]: it takes energy in any case.
 * On a crease, on a border, in a corner of two surfaces, beyond 60 degrees and where the work is used up nothing is
 * turned. Servo-safe: at most kMaxShadingWork nodes and triangles beside three fans.
 */
void shade(const Scene& scene, const Vec3& v_W, SurfaceContact& contact) HD_RT;

inline constexpr std::uint32_t kMaxShadingWork = 2000;
inline constexpr double kLeastTurnCosine = 0.5;  ///< No force is turned by more than 60 degrees.

}  // namespace hapticd
