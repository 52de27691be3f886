/** @file
 * What can be touched: objects in a tree of rigid transforms, kept in fixed slots of the servo's own memory.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "rt/base/math.h"
#include "rt/command.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

enum class ShapeKind : std::uint32_t { kGroup = 0, kPlane, kSphere, kBox, kCapsule, kCylinder, kMesh };

/** Geometry in the object's frame. Plane: solid below z = 0. Capsule and cylinder: along z. */
struct Shape {
  ShapeKind kind = ShapeKind::kGroup;
  Vec3 size = Vec3::Zero();  ///< As Shape in control.capnp [m].
  MeshView* mesh = nullptr;
};

/** One slot of the scene. */
struct SceneObject {
  std::uint32_t id = 0;      ///< 0: the slot is free.
  std::uint32_t parent = 0;  ///< Slot; 0 is the root.
  std::uint32_t flags = 0;   ///< hd_object_flag
  Pose X_PO;                 ///< In the parent.
  Twist V_PO;                ///< Velocity in the parent's frame, about the object's origin.
  Pose X_WO;                 ///< In the world, this tick.
  Pose X_WO_before;          ///< In the world, the tick before: contact sweeps relative to it.
  Twist V_WO;                ///< Velocity in the world.
  Shape shape;
  hd_material material{};
};

/**
 * Mesh views by table entry. The control thread publishes a view before the command that names it and takes it back
 * after the servo has passed the command that drops it.
 */
class MeshTable {
 public:
  void publish(std::uint32_t entry, MeshView* view) noexcept { views_[entry].store(view, std::memory_order_release); }
  [[nodiscard]] MeshView* get(std::uint32_t entry) const HD_RT {
    return entry < kMaxMeshes ? views_[entry].load(std::memory_order_acquire) : nullptr;
  }

 private:
  std::array<std::atomic<MeshView*>, kMaxMeshes> views_{};
};

/** The servo's scene. One thread. Construction allocates nothing but itself. */
class Scene {
 public:
  explicit Scene(const MeshTable& meshes) noexcept : meshes_(&meshes) {}

  /** Applies a scene command (object pose, material, flags, vertices, add, remove, shape). */
  ErrorCode apply(const Command& command) HD_RT;

  /** Moves objects on by their velocities and recomputes world poses; X_WO_before is last tick's X_WO. */
  void advance(double dt) HD_RT;

  /** Slots in which objects that can be touched stand, rising. */
  [[nodiscard]] std::span<const std::uint16_t> touchable() const HD_RT { return {touchable_.data(), touchable_count_}; }
  [[nodiscard]] const SceneObject& slot(std::uint32_t i) const HD_RT { return objects_[i]; }
  /** The object of that id, or null when it is gone. */
  [[nodiscard]] const SceneObject* find(std::uint32_t id) const HD_RT;

 private:
  SceneObject* findMutable(std::uint32_t id) HD_RT;
  void rebuildOrder() HD_RT;

  const MeshTable* meshes_;
  std::array<SceneObject, kMaxObjects> objects_{};
  std::array<std::uint16_t, kMaxObjects> order_{};  ///< Used slots, parents first.
  std::uint32_t order_count_ = 0;
  std::array<std::uint16_t, kMaxObjects> touchable_{};
  std::uint32_t touchable_count_ = 0;
};

}  // namespace hapticd
