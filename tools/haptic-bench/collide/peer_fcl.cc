#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>

#include "tools/haptic-bench/collide/peer.h"

namespace haptic_bench {
namespace {

using Tree = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Tree> makeTree(const Model& model) {
  std::vector<fcl::Vector3d> vertices;
  std::vector<fcl::Triangle> triangles;
  for (std::uint32_t v = 0; v < model.vertices.size(); ++v) vertices.push_back(model.vertex(v));
  for (const auto& t : model.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  auto tree = std::make_shared<Tree>();
  tree->beginModel();
  tree->addSubModel(vertices, triangles);
  tree->endModel();
  return tree;
}

class Fcl final : public Peer {
 public:
  Fcl(const Model& base, const Model& tool) : base_(makeTree(base)), tool_(makeTree(tool)) {}

  bool touch(const hapticd::Pose& tool) override { return ask(tool, 1, false) > 0; }
  std::uint32_t contacts(const hapticd::Pose& tool, std::uint32_t most) override { return ask(tool, most, true); }

 private:
  std::uint32_t ask(const hapticd::Pose& tool, std::uint32_t most, bool each) {
    fcl::Transform3d there = fcl::Transform3d::Identity();
    there.linear() = tool.q.toRotationMatrix();
    there.translation() = tool.p;
    const fcl::CollisionRequest<double> request(most, each);
    fcl::CollisionResult<double> result;
    fcl::collide(tool_.get(), there, base_.get(), fcl::Transform3d::Identity(), request, result);
    return static_cast<std::uint32_t>(result.numContacts());
  }

  std::shared_ptr<Tree> base_, tool_;
};

}  // namespace

extern const PeerKind kFclPeer{
    "FCL", "pairs of triangles",
    [](const Model& base, const Model& tool) -> std::unique_ptr<Peer> { return std::make_unique<Fcl>(base, tool); }};

}  // namespace haptic_bench
