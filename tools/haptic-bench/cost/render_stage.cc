#include "tools/haptic-bench/cost/render_stage.h"

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

RenderStage::RenderStage(MeshView& mesh, const MeshStroke& stroke)
    : stroke_(stroke), scene_(std::make_unique<Scene>(table_)) {
  table_.publish(0, &mesh);
  AddObject object{};
  object.object = makeObjectId(1, 1);
  object.flags = HD_OBJECT_ENABLED;
  object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
  object.material.stiffness = 1000;
  object.q[0] = 1;
  if (scene_->apply(makeCommand(CommandKind::kAddObject, object)) != ErrorCode::kOk)
    throw Failure("stroke", "the scene refuses the mesh", "");
  scene_->advance(kStrokeDt);
}

void RenderStage::begin(double radius) {
  radius_ = radius;
  renderer_.setRadius(radius);
  renderer_.reset(stroke_.at(0, radius + kStrokeAbove));
  touched_ = true;
}

Looked lookedAt(RenderStage& stage, const MeshStroke& stroke, double radius) {
  Looked looked;
  const Surroundings& around = stage.renderer().surroundings();
  stage.begin(radius);
  const std::uint64_t at_once = around.gatheredAtOnce(), ahead = around.gatheredAhead();
  for (std::size_t i = 0; i < stroke.ticks(); ++i) {
    stage.tick(i);
    const ProxyEffort& effort = stage.renderer().effort();
    looked.sweeps.push_back(effort.sweeps);
    looked.visited.push_back(effort.visited);
    looked.gathered.push_back(effort.gathered);
  }
  looked.at_once = static_cast<double>(around.gatheredAtOnce() - at_once);
  looked.ahead = static_cast<double>(around.gatheredAhead() - ahead);
  return looked;
}

}  // namespace haptic_bench
