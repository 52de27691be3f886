/** @file
 * What the surface of a benchmark is like.
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
};

/** --stiffness, --damping, --friction-static and --friction-dynamic. */
void addSurface(CLI::App& sub, Surface& surface);

}  // namespace haptic_bench
