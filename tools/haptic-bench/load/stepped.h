/** @file
 * The cycle stepped by hand along a given way of the hand: by the native scene, or by what a client at its own rate
 * and late sends. Deterministic: no thread, no clock.
 */
#pragma once

#include <span>
#include <vector>

#include "rt/scene/scene.h"
#include "tools/haptic-bench/load/local_client.h"
#include "tools/haptic-bench/load/stroke.h"

namespace haptic_bench {

/** How the native scene shows a mesh. */
enum class Facets {
  kFlat,
  kShaded,  ///< Edges of less than 30 degrees felt round, as the surface the mesh stands for.
};

/** Force of the native scene at each place of the hand: the mesh in entry 0 of `meshes`, without friction or damping.
 */
[[nodiscard]] std::vector<Vec3> nativeForces(const hapticd::MeshTable& meshes, double stiffness,
                                             std::span<const Vec3> hips, Facets facets = Facets::kFlat);

/** Stiffness times the way to the nearest point of the mesh: what a proxy without memory would make. */
[[nodiscard]] std::vector<Vec3> nearestForces(const haptic::SurfaceMesh& mesh, double stiffness,
                                              std::span<const Vec3> hips);

/** A latency as clientForces() has it: in whole ticks, and at least the one in which a message comes in. */
[[nodiscard]] double steppedLatency_s(double asked_s);

/** Force of the models or forces (kForce) that the client sends. */
[[nodiscard]] std::vector<Vec3> clientForces(Source source, const haptic::SurfaceMesh& mesh, const ClientTiming& timing,
                                             std::span<const Vec3> hips);

/** How far one run of forces is from another. Fractions of the reference's mean magnitude. */
struct ForceError {
  double rms = 0;         ///< Of the difference.
  double max = 0;         ///< Largest difference.
  double change_max = 0;  ///< The most by which the difference changes from tick to tick.
  double mean = 0;        ///< Mean magnitude of the reference [N].
};

[[nodiscard]] ForceError compareForces(std::span<const Vec3> forces, std::span<const Vec3> reference);

}  // namespace haptic_bench
