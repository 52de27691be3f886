/** @file
 * A scene, a proxy and the commands to move them, in few words.
 */
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "rt/render/proxy/proxy.h"
#include "tests/support/stepped/solid.h"

namespace hapticd::test {

inline constexpr double kTick = 1e-3;
inline constexpr std::uint32_t kOneSided = HD_OBJECT_ENABLED, kTwoSided = HD_OBJECT_ENABLED | HD_OBJECT_TWO_SIDED;

/** Scene with its mesh table. */
class TestScene {
 public:
  explicit TestScene(double radius = 0) { proxy.setRadius(radius); }
  std::uint32_t add(ShapeKind kind, const Vec3& size, const Pose& X = {}, const hd_material& material = {1000, 0, 0, 0},
                    std::uint32_t flags = HD_OBJECT_ENABLED, std::uint32_t parent = 0, MeshView* mesh = nullptr) {
    const std::uint32_t slot = next_++;
    AddObject order = solid(makeObjectId(slot, 1), kind, material, X, size);
    order.parent = parent;
    order.flags = flags;
    order.shape.mesh = slot;
    table->publish(slot, mesh);
    return apply(CommandKind::kAddObject, order) == ErrorCode::kOk ? order.object : 0;
  }
  std::uint32_t addMesh(MeshView* mesh, const Pose& X = {}, const hd_material& material = {1000, 0, 0, 0},
                        std::uint32_t flags = HD_OBJECT_ENABLED) {
    return add(ShapeKind::kMesh, Vec3::Zero(), X, material, flags, 0, mesh);
  }
  ErrorCode pose(std::uint32_t id, const Pose& X, const Twist& V = {}) {
    return apply(CommandKind::kObjectPose, poseMessage(id, X, V));
  }
  void material(std::uint32_t id, const hd_material& material) {
    apply(CommandKind::kObjectMaterial, hd_object_material{id, 0, material});
  }
  void flags(std::uint32_t id, std::uint32_t mask, std::uint32_t value) {
    apply(CommandKind::kObjectFlags, hd_object_flags{id, mask, value, 0});
  }
  ErrorCode setShape(std::uint32_t id, const ShapeParameters& shape) {
    return apply(CommandKind::kSetShape, SetShape{id, 0, shape});
  }
  ErrorCode setSurface(std::uint32_t id, const SurfaceParameters& surface) {
    return apply(CommandKind::kSetSurface, SetSurface{id, 0, surface});
  }
  /** Moves vertices of a deformable mesh, as many commands as it takes. */
  ErrorCode moveVertices(std::uint32_t id, const std::vector<hd_vertex_move>& moves) {
    ErrorCode code = ErrorCode::kOk;
    for (std::size_t i = 0; i < moves.size() && code == ErrorCode::kOk; i += HD_VERTEX_MOVES) {
      hd_object_vertices order{};
      order.object = id;
      for (std::size_t k = i; k < moves.size() && order.count < HD_VERTEX_MOVES; ++k)
        order.move[order.count++] = moves[k];
      code = apply(CommandKind::kObjectVertices, order);
    }
    return code;
  }
  ErrorCode remove(std::uint32_t id) { return apply(CommandKind::kRemoveObject, ObjectRef{id}); }
  template <class T>
  ErrorCode apply(CommandKind kind, const T& payload) {
    return scene->apply(makeCommand(kind, payload));
  }

  /** One tick of scene and proxy with the hip at `hip`. */
  const SurfaceContact& tick(const Vec3& hip, const Vec3& v = Vec3::Zero()) {
    scene->advance(kTick);
    proxy.step(*scene, hip, v, kTick, contact);
    return contact;
  }

  std::unique_ptr<MeshTable> table = std::make_unique<MeshTable>();
  std::unique_ptr<Scene> scene = std::make_unique<Scene>(*table);
  ProxyRenderer proxy;
  SurfaceContact contact;

 private:
  std::uint32_t next_ = 1;
};

struct Stiffnesses {
  double softest, stiffest;
};

/** Of all that holds the proxy [N/m]; 0 in free space. */
inline Stiffnesses stiffnesses(const Scene& scene, const SurfaceContact& contact) {
  const auto of = [&](std::uint32_t id) { return id != 0 ? scene.find(id)->material.stiffness : 0.0; };
  Stiffnesses both{of(contact.object), of(contact.object)};
  for (std::uint32_t i = 0; i < contact.parts; ++i) {
    both.softest = std::min(both.softest, of(contact.part[i].object));
    both.stiffest = std::max(both.stiffest, of(contact.part[i].object));
  }
  return both;
}

/** Whether the force without friction and damping is one that surfaces of these stiffnesses can make. */
inline bool pressesAsItCan(const Scene& scene, const SurfaceContact& contact, const Vec3& hip) {
  const auto [softest, stiffest] = stiffnesses(scene, contact);
  const Vec3 pull = contact.proxy - hip;
  if (softest == stiffest) return (contact.force - stiffest * pull).norm() < 1e-9;
  return contact.force.dot(pull) > (softest * pull.squaredNorm()) * (1 - 1e-9) - 1e-12 &&
         contact.force.norm() < stiffest * pull.norm() + 1e-9;
}

}  // namespace hapticd::test
