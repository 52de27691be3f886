/** @file
 * A scene, a proxy and the commands to move them, in few words.
 */
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "rt/render/proxy.h"
#include "rt/scene/scene.h"

namespace hapticd::test {

inline constexpr double kTick = 1e-3;
inline constexpr std::uint32_t kOneSided = HD_OBJECT_ENABLED, kTwoSided = HD_OBJECT_ENABLED | HD_OBJECT_TWO_SIDED;

/** Scene with its mesh table. */
class TestScene {
 public:
  std::uint32_t add(ShapeKind kind, const Vec3& size, const Pose& X = {}, const hd_material& material = {1000, 0, 0, 0},
                    std::uint32_t flags = HD_OBJECT_ENABLED, std::uint32_t parent = 0, MeshView* mesh = nullptr) {
    Command command;
    command.kind = CommandKind::kAddObject;
    auto& order = command.as<AddObject>();
    const std::uint32_t slot = next_++;
    order.object = makeObjectId(slot, 1);
    order.parent = parent;
    order.flags = flags;
    order.shape.kind = static_cast<std::uint32_t>(kind);
    order.shape.mesh = slot;
    table->publish(slot, mesh);
    store(size, order.shape.size);
    order.material = material;
    store(X.p, order.p);
    store(X.q, order.q);
    return scene->apply(command) == ErrorCode::kOk ? order.object : 0;
  }
  std::uint32_t addMesh(MeshView* mesh, const Pose& X = {}, const hd_material& material = {1000, 0, 0, 0},
                        std::uint32_t flags = HD_OBJECT_ENABLED) {
    return add(ShapeKind::kMesh, Vec3::Zero(), X, material, flags, 0, mesh);
  }
  ErrorCode pose(std::uint32_t id, const Pose& X, const Twist& V = {}) {
    Command command;
    command.kind = CommandKind::kObjectPose;
    auto& order = command.as<hd_object_pose>();
    order.object = id;
    store(X.p, order.p);
    store(X.q, order.q);
    store(V.v, order.v);
    store(V.w, order.w);
    return scene->apply(command);
  }
  void material(std::uint32_t id, const hd_material& material) {
    Command command;
    command.kind = CommandKind::kObjectMaterial;
    command.as<hd_object_material>() = {id, 0, material};
    scene->apply(command);
  }
  void flags(std::uint32_t id, std::uint32_t mask, std::uint32_t value) {
    Command command;
    command.kind = CommandKind::kObjectFlags;
    command.as<hd_object_flags>() = {id, mask, value, 0};
    scene->apply(command);
  }
  /** Moves vertices of a deformable mesh, as many commands as it takes. */
  ErrorCode moveVertices(std::uint32_t id, const std::vector<hd_vertex_move>& moves) {
    ErrorCode code = ErrorCode::kOk;
    for (std::size_t i = 0; i < moves.size() && code == ErrorCode::kOk; i += HD_VERTEX_MOVES) {
      Command command;
      command.kind = CommandKind::kObjectVertices;
      auto& order = command.as<hd_object_vertices>();
      order.object = id;
      for (std::size_t k = i; k < moves.size() && order.count < HD_VERTEX_MOVES; ++k)
        order.move[order.count++] = moves[k];
      code = scene->apply(command);
    }
    return code;
  }
  ErrorCode remove(std::uint32_t id) {
    Command command;
    command.kind = CommandKind::kRemoveObject;
    command.as<ObjectRef>() = {id};
    return scene->apply(command);
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
