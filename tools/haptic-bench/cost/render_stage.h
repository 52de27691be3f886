/** @file
 * The renderer's tick on a mesh, without a servo about it; timed, and counted.
 */
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "rt/render/proxy/proxy.h"
#include "rt/scene/scene.h"
#include "tools/haptic-bench/cost/stroke.h"

namespace haptic_bench {

/** One mesh in a scene. */
class RenderStage {
 public:
  /** Throws Failure. */
  RenderStage(hapticd::MeshView& mesh, const MeshStroke& stroke);

  /** Puts a ball above the start of the stroke. */
  void begin(double radius);
  void tick(std::size_t i) {
    scene_->advance(kStrokeDt);
    renderer_.step(*scene_, stroke_.at(i, radius_ - kStrokeDepth), hapticd::Vec3::Zero(), kStrokeDt, contact_);
    touched_ = touched_ && contact_.object != 0;
  }
  /** Whether the hand has been in contact since begin(). */
  [[nodiscard]] bool touched() const { return touched_; }
  [[nodiscard]] const hapticd::ProxyRenderer& renderer() const { return renderer_; }

 private:
  const MeshStroke& stroke_;
  hapticd::MeshTable table_;
  std::unique_ptr<hapticd::Scene> scene_;
  hapticd::ProxyRenderer renderer_;
  hapticd::SurfaceContact contact_;
  double radius_ = 0;
  bool touched_ = true;
};

/** What the ticks of a stroke looked at. Counted, so the same on every machine and with all vector instructions. */
struct Looked {
  std::vector<double> sweeps, visited, gathered;  ///< Each tick; visited: for sweeps and looks.
  double at_once = 0, ahead = 0;                  ///< Vicinities gathered in the tick that needs them, and before.
};

/** The whole stroke, counted instead of timed. */
[[nodiscard]] Looked lookedAt(RenderStage& stage, const MeshStroke& stroke, double radius);

}  // namespace haptic_bench
