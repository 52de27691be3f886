// hapticd's own renderer, as the servo calls it: the builder's snapshot, the scene, the proxy.
#include <memory>

#include "rt/render/proxy/proxy.h"
#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/algorithm/native.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/built_mesh.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

class Ours {
 public:
  explicit Ours(const haptic_algorithm_problem& problem) : mesh_(buildMesh(modelOf(problem))) {
    Spec options(std::string("ours:") + problem.options);
    const bool two_sided = options.count("two_sided", 0, 0, 1) != 0;
    options.finish();
    proxy_.setRadius(problem.radius);
    meshes_->publish(0, &mesh_.view);
    hapticd::AddObject order{};
    order.object = hapticd::makeObjectId(1, 1);
    order.flags = HD_OBJECT_ENABLED;
    if (two_sided) order.flags |= HD_OBJECT_TWO_SIDED;
    order.shape.kind = static_cast<std::uint32_t>(hapticd::ShapeKind::kMesh);
    order.material.stiffness = problem.stiffness;
    order.material.damping = problem.damping;
    order.material.friction_static = problem.friction_static;
    order.material.friction_dynamic = problem.friction_dynamic;
    order.q[0] = 1;
    const hapticd::ErrorCode code = scene_->apply(hapticd::makeCommand(hapticd::CommandKind::kAddObject, order));
    if (code != hapticd::ErrorCode::kOk) {
      throw Failure("ours", std::string(hapticd::describe(code)),
                    "stiffness, damping and friction as the daemon takes them");
    }
  }

  void start(const Vec3& hip) { proxy_.reset(hip); }

  void step(const Vec3& hip, const Vec3& v, double dt_s, haptic_algorithm_contact& contact) {
    scene_->advance(dt_s);
    proxy_.step(*scene_, hip, v, dt_s, surface_);
    answer(contact, surface_.force, surface_.proxy, surface_.object != 0);
  }

  [[nodiscard]] std::size_t bytes() const { return mesh_.mapping.size() + sizeof(hapticd::Scene) + sizeof(*this); }

 private:
  hapticd::SnapshotMemory mesh_;
  std::unique_ptr<hapticd::MeshTable> meshes_ = std::make_unique<hapticd::MeshTable>();
  std::unique_ptr<hapticd::Scene> scene_ = std::make_unique<hapticd::Scene>(*meshes_);
  hapticd::ProxyRenderer proxy_;
  hapticd::SurfaceContact surface_;
};

}  // namespace

const haptic_algorithm kOurs = nativeAlgorithm<Ours>("ours", "hapticd's proxy, as the servo runs it");

}  // namespace haptic_bench
