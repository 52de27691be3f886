#include "tools/haptic-bench/cost/stroke.h"

#include <cmath>

#include "rt/geometry/sweep/sweep.h"
#include "rt/render/proxy/proxy.h"
#include "tools/haptic-bench/cost/bumpy_sphere.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

constexpr double kPlaneTurn = 0.61803;  // Of the stroke's plane per revolution: new ground each time round.

MeshStroke::MeshStroke(const hapticd::MeshView& mesh, double seconds, double speed) {
  using hapticd::Vec3;
  const auto count = static_cast<std::size_t>(seconds / kStrokeDt);
  for (std::size_t i = 0; i <= count; ++i) {
    const double angle = static_cast<double>(i) * kStrokeDt * speed / 0.05;
    const double tilt = 0.3 + kPlaneTurn * angle / (2 * M_PI);
    const Vec3 u(std::cos(angle), std::sin(angle) * std::cos(tilt), std::sin(angle) * std::sin(tilt));
    hapticd::Sweep sweep;
    sweep.a = 2 * bumpyRadius(u) * u;
    sweep.d = -sweep.a;
    sweep.limit = hapticd::ProxyRenderer::kMaxWork;
    hapticd::SweepHit hit;
    if (sweepMesh(mesh, sweep, hit) != hapticd::SweepResult::kHit)
      throw Failure("stroke", "no mesh below the hand", "");
    along_.push_back(u);
    radius_.push_back(((1 - hit.t) * sweep.a).norm());
  }
}

}  // namespace haptic_bench
