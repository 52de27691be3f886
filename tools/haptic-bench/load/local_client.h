/** @file
 * A good client of local models, and a plain one of forces: what it makes of a sample. The same code in the stepped
 * comparison and in real client processes.
 */
#pragma once

#include <hapticclient/push.h>

#include <hapticclient/patch.hpp>

#include "rt/base/math.h"

namespace haptic_bench {

using hapticd::Vec3;

/** What the client sends. */
enum class Source { kNative, kPlane, kPatch, kForce };

[[nodiscard]] const char* nameOf(Source source);

/** When and of what material. */
struct ClientTiming {
  double period_s = 1.0 / 30;
  double latency_s = 0.005;  ///< From the sample to the tick that feels what was made of it.
  double stiffness = 1000;   ///< [N/m]
};

/** Plane or patch for a hand at p with velocity v. */
[[nodiscard]] haptic_local_model fitModel(Source source, const haptic::SurfaceMesh& mesh, const Vec3& p, const Vec3& v,
                                          const ClientTiming& timing);

/** Stiffness times the way out of the mesh: what a client that renders by itself computes. */
[[nodiscard]] haptic_client_force fitForce(const haptic::SurfaceMesh& mesh, const Vec3& p, const ClientTiming& timing);

}  // namespace haptic_bench
