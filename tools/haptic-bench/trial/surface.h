/** @file
 * What the surface of a benchmark is like, and what touches it.
 */
#pragma once

namespace CLI {
class App;
}

namespace haptic_bench {

struct Surface {
  double stiffness = 1000;  ///< [N/m]
  double damping = 0;       ///< Along the normal [N s/m].
  double friction_static = 0;
  double friction_dynamic = 0;
  double radius = 0;  ///< Of the ball that touches; 0: a point [m].
};

/** --stiffness, --damping, --friction-static, --friction-dynamic and --radius. */
void addSurface(CLI::App& sub, Surface& surface);

/** --threshold. */
void addThreshold(CLI::App& sub, double& threshold);

/** Throws Failure for friction that is less at rest than while sliding: no renderer of ours takes it. */
void checkSurface(const Surface& surface);

}  // namespace haptic_bench
