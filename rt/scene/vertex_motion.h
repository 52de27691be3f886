/** @file
 * How fast a mesh deforms: what the moves of its vertices are samples of.
 */
#pragma once

#include "rt/scene/mesh_view.h"

namespace hapticd {

/**
 * The velocity told by moves of one vertex, as poses tell an object's (Scene): the step over the time since the move
 * before, until the next one or half as long again.
 */
struct VertexMotion {
  double time = 0;     ///< Of the tick in which it moved last, on the scene's clock [s].
  float from[3] = {};  ///< Where it was before that tick, in the object's frame [m].
  float duration = 0;  ///< Of that move [s]; 0: it has not moved.
};

inline constexpr double kLatePose = 1.5;     ///< Times what there was between two poses, until the next counts as none.
inline constexpr double kPoseSpread = 0.05;  ///< Most between samples of one motion: 20 of them a second [s].

/** Notes that the vertex was at `from` until the tick at `time`; `dt` is a tick's length [s]. */
void noteMotion(MeshView& mesh, std::uint32_t vertex, const float (&from)[3], double time, double dt) HD_RT;

/** For a scene whose clock is another one: no vertex has moved yet. Control thread, while no servo reads the mesh. */
void forgetMotion(MeshView& mesh) noexcept;

/** Whether the vertex' last move was no motion, for it was too fast: as a pose that is a teleport. */
[[nodiscard]] bool isJump(const MeshView& mesh, std::uint32_t vertex) HD_RT;

/** Velocity at x, a point of that triangle, of its deforming in the tick at `time`; in the object's frame. */
[[nodiscard]] Vec3 deformingVelocity(const MeshView& mesh, std::uint32_t triangle, const Vec3& x, double time) HD_RT;

}  // namespace hapticd
