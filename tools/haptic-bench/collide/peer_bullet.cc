#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include "tools/haptic-bench/collide/peer.h"

namespace haptic_bench {
namespace {

constexpr double kScale = 1000;  // Bullet's margins suppose bodies of about its unit: work in mm.

/** Counts points instead of keeping the four that Bullet's manifolds hold. */
class Counter final : public btManifoldResult {
 public:
  using btManifoldResult::btManifoldResult;
  void addContactPoint(const btVector3& /*normal*/, const btVector3& /*point*/, btScalar /*depth*/) override {
    ++count;
  }
  std::uint32_t count = 0;
};

class Solid {
 public:
  explicit Solid(const Model& model) {
    for (const auto& v : model.vertices) {
      for (const float x : v) vertices_.push_back(static_cast<btScalar>(x * kScale));
    }
    for (const auto& t : model.triangles) {
      for (const std::uint32_t v : t) indices_.push_back(static_cast<int>(v));
    }
    triangles_ = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(model.triangles.size()), indices_.data(), 3 * static_cast<int>(sizeof(int)),
        static_cast<int>(model.vertices.size()), vertices_.data(), 3 * static_cast<int>(sizeof(btScalar)));
    shape_ = std::make_unique<btGImpactMeshShape>(triangles_.get());
    shape_->setMargin(0);
    shape_->updateBound();
    object.setCollisionShape(shape_.get());
  }
  btCollisionObject object;

 private:
  std::vector<btScalar> vertices_;
  std::vector<int> indices_;
  std::unique_ptr<btTriangleIndexVertexArray> triangles_;
  std::unique_ptr<btGImpactMeshShape> shape_;
};

class Bullet final : public Peer {
 public:
  Bullet(const Model& base, const Model& tool) : base_(base), tool_(tool) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
  }

  bool touch(const hapticd::Pose& tool) override { return contacts(tool, 0) > 0; }

  std::uint32_t contacts(const hapticd::Pose& tool, std::uint32_t /*most*/) override {
    const hapticd::Vec3 p = tool.p * kScale;
    tool_.object.setWorldTransform(btTransform(
        btQuaternion(static_cast<btScalar>(tool.q.x()), static_cast<btScalar>(tool.q.y()),
                     static_cast<btScalar>(tool.q.z()), static_cast<btScalar>(tool.q.w())),
        btVector3(static_cast<btScalar>(p.x()), static_cast<btScalar>(p.y()), static_cast<btScalar>(p.z()))));
    const btCollisionObjectWrapper a(nullptr, tool_.object.getCollisionShape(), &tool_.object,
                                     tool_.object.getWorldTransform(), -1, -1);
    const btCollisionObjectWrapper b(nullptr, base_.object.getCollisionShape(), &base_.object,
                                     base_.object.getWorldTransform(), -1, -1);
    btCollisionAlgorithm* algorithm = dispatcher_.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    Counter counter(&a, &b);
    algorithm->processCollision(&a, &b, info_, &counter);
    algorithm->~btCollisionAlgorithm();
    dispatcher_.freeCollisionAlgorithm(algorithm);
    return counter.count;
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDispatcherInfo info_;
  Solid base_, tool_;
};

}  // namespace

extern const PeerKind kBulletPeer{
    "Bullet GImpact", "points",
    [](const Model& base, const Model& tool) -> std::unique_ptr<Peer> { return std::make_unique<Bullet>(base, tool); }};

}  // namespace haptic_bench
