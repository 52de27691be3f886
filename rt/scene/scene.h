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
#include "rt/scene/texture.h"
#include "rt/scene/vertex_motion.h"

namespace hapticd {

enum class ShapeKind : std::uint32_t { kGroup = 0, kPlane, kSphere, kBox, kCapsule, kCylinder, kMesh };

/** Geometry in the object's frame. Plane: solid below z = 0. Capsule and cylinder: along z. */
struct Shape {
  ShapeKind kind = ShapeKind::kGroup;
  Vec3 size = Vec3::Zero();  ///< As Shape in control.capnp [m].
  MeshView* mesh = nullptr;
  std::uint32_t mesh_entry = 0;  ///< Of the mesh table, for meshes.
  std::uint64_t number = 0;      ///< Of the command that made it: no two have the same, whatever their mesh's address.
};

/** One slot of the scene. */
struct SceneObject {
  /** What clients change through their rings, too; each by itself. */
  enum Part : std::uint32_t { kPlace, kMaterial, kFlags, kParts };

  std::uint32_t id = 0;                              ///< 0: the slot is free.
  std::uint32_t parent = 0;                          ///< Slot; 0 is the root.
  std::uint32_t flags = 0;                           ///< hd_object_flag
  std::array<std::uint32_t, kParts> client_edits{};  ///< Changes of each part by clients through their rings; wrap.
  Pose X_PO;                                         ///< In the parent.
  Twist V_PO;                                        ///< Velocity in the parent's frame, about the object's origin.
  Pose X_WO;                                         ///< In the world, this tick: set by place().
  Mat3 R_WO = Mat3::Identity();                      ///< Its rotation: a tick of the renderer turns a dozen vectors.
  Pose X_WO_before;                                  ///< In the world, the tick before: contact sweeps relative to it.
  Twist V_WO;                                        ///< Velocity of the frame's origin and its rotation, in the world.
  Shape shape;
  hd_material material{};
  Surface surface;
  Vec3 center_W = Vec3::Zero();  ///< Of a ball about the shape, this tick.
  double radius = 0;             ///< Of that ball; infinite for a plane, 0 for a group.
  bool moved = false;            ///< X_WO differs from X_WO_before.
  bool appeared = false;         ///< It could not be touched the tick before, or not as this mesh: see Scene.
  bool loose = false;            ///< What pushes it moves it: nobody else says where it is.

  void place(const Pose& X) HD_RT {
    X_WO = X;
    R_WO = X.q.toRotationMatrix();
  }
  /** The ball about its shape, where it is now. */
  void placeBall() HD_RT;
  [[nodiscard, gnu::always_inline]] inline Vec3 toWorld(const Vec3& x_O) const HD_RT { return R_WO * x_O + X_WO.p; }
  [[nodiscard, gnu::always_inline]] inline Vec3 toLocal(const Vec3& x_W) const HD_RT {
    return R_WO.transpose() * (x_W - X_WO.p);
  }
  /** Velocity of the body's point that is now at x_W. */
  [[nodiscard]] Vec3 velocityAt(const Vec3& x_W) const HD_RT { return V_WO.v + V_WO.w.cross(x_W - X_WO.p); }
};

/** Whether tools and free bodies touch an object at all: it is there, enabled, and has a stiffness. */
[[nodiscard]] inline bool isFelt(const SceneObject& object) HD_RT {
  return object.id != 0 && (object.flags & HD_OBJECT_ENABLED) != 0 && object.material.stiffness > 0;
}

/** An object is at that place in its parent's frame, and moves so. */
[[nodiscard]] inline hd_object_pose poseMessage(std::uint32_t object, const Pose& X, const Twist& V = {}) HD_RT {
  hd_object_pose pose{};
  pose.object = object;
  store(X.p, pose.p);
  store(X.q, pose.q);
  store(V.v, pose.v);
  store(V.w, pose.w);
  return pose;
}

/** One corner of a triangle moved by a vertex command, in the object's frame [m]. */
struct TriangleMove {
  const MeshView* mesh = nullptr;  ///< Whose; not to be followed.
  std::uint32_t triangle = 0;
  std::uint32_t corner = 0;  ///< Which corner moved.
  float before[3][3] = {};   ///< All corners before it.
  float after[3] = {};       ///< Where that corner is then.
};

/**
 * Mesh and texture views by table entry. The control thread publishes a view before the command that names it and takes
 * it back after the servo has passed the command that drops it.
 */
class MeshTable {
 public:
  void publish(std::uint32_t entry, MeshView* view) noexcept { views_[entry].store(view, std::memory_order_release); }
  [[nodiscard]] MeshView* get(std::uint32_t entry) const HD_RT {
    return entry < kMaxMeshes ? views_[entry].load(std::memory_order_acquire) : nullptr;
  }
  void publishTexture(std::uint32_t entry, const TextureView* view) noexcept {
    textures_[entry].store(view, std::memory_order_release);
  }
  [[nodiscard]] const TextureView* texture(std::uint32_t entry) const HD_RT {
    return entry < kMaxTextures ? textures_[entry].load(std::memory_order_acquire) : nullptr;
  }

 private:
  std::array<std::atomic<MeshView*>, kMaxMeshes> views_{};
  std::array<std::atomic<const TextureView*>, kMaxTextures> textures_{};
};

/**
 * The servo's scene. One thread. Construction allocates nothing but itself.
 *
 * Motion. Between pose commands an object moves on by its velocity; in the tick of a pose command it stands exactly at
 * the commanded pose. A pose command is a motion that contact sweeps along, if it is credible: at most kTeleportSpeed
 * over the time since the object's last pose (one tick to kPoseHold) and at most kTeleportAngle. Otherwise it is a
 * teleport, as is creation, and a change of shape together with a pose (a new shape may have its origin elsewhere):
 * X_WO_before is X_WO, and a hand that finds itself inside feels nothing until it has left. So it is with one object
 * alone, not with those below it, when it is enabled; where it came from unseen is no motion, nor are the moves of its
 * vertices in that tick, or those of a mesh that it is given. V_WO follows the given velocity. Where that is zero it is
 * the poses' difference over the time between them (one tick to kPoseSpread), from the command on for half as long
 * again, so that poses which come at a client's own pace, and a little late, count as the motion they are samples of;
 * then the object rests. Moves of vertices tell the velocity of a place of a mesh in the same way.
 */
class Scene {
 public:
  static constexpr double kTeleportSpeed = 10.0;  ///< [m/s]
  static constexpr double kTeleportAngle = 1.0;   ///< In one command [rad].
  static constexpr double kPoseHold = 0.02;       ///< [s]
  static constexpr double kLeastPut = 1e-5;       ///< Than which a pose that is no motion is farther [m].
  static constexpr double kLeastPutAngle = 2e-4;  ///< Or more turned [rad].
  static constexpr double kUnmetStep = 0.002;     ///< Of its surface, beside what its velocity brings [m].
  static constexpr double kMetTime = 0.002;       ///< So far ahead of poses contacts are surely looked for [s].
  static constexpr std::uint32_t kMaxTriangleMoves = 8192;

  explicit Scene(const MeshTable& meshes) noexcept : meshes_(&meshes) {}

  /**
   * Applies a scene command (object pose, material, flags, vertices, add, remove, shape, surface, effect). A refused
   * command changes nothing. kNotFound: no such object (a stale generation included), parent, mesh, texture or vertex.
   * kAlreadyExists: the slot is taken. kInvalidArgument: a value is not finite or out of range, or the object to remove
   * has children. kUnsupported: not a scene command, or vertices of a rigid mesh.
   */
  ErrorCode apply(const Command& command) HD_RT;

  /** As if all that is there had come by control's orders. */
  void forgetEdits() HD_RT {
    for (SceneObject& object : objects_) object.client_edits = {};
  }
  /** What that session has given a velocity stands from now on: nobody is there who would end its motion. */
  void halt(std::uint32_t session) HD_RT;
  /** Command::session of who has given the object its velocity; kControlSession of one that stands or is gone. */
  [[nodiscard]] std::uint32_t moverOf(std::uint32_t id) const HD_RT;
  /** hd_object_pose::lease_us of what is left of its motion's lease, 0: it has none. */
  [[nodiscard]] std::uint32_t leaseOf(std::uint32_t id) const HD_RT;

  /**
   * Before the commands of a tick: it is so long [s], and of that number, which never falls. Without that it counts as
   * long as the last one: moves of vertices are those of its end.
   */
  void expect(double dt, std::uint64_t tick = 0) HD_RT {
    dt_ = dt;
    tick_ = tick;
  }
  [[nodiscard]] std::uint64_t tick() const HD_RT { return tick_; }

  /** Moves objects on by their velocities and recomputes world poses; X_WO_before is last tick's X_WO. */
  void advance(double dt) HD_RT;

  /** Slots in which objects stand, parents before their children. */
  [[nodiscard]] std::span<const std::uint16_t> used() const HD_RT { return {order_.data(), order_count_}; }
  /** Slots in which objects that can be touched stand, rising. */
  [[nodiscard]] std::span<const std::uint16_t> touchable() const HD_RT { return {touchable_.data(), touchable_count_}; }
  /**
   * What vertex commands have changed since the advance() before the last one, in their order: contact sweeps the
   * surface along. Beyond kMaxTriangleMoves in one tick the rest moves without being swept.
   */
  [[nodiscard]] std::span<const TriangleMove> triangleMoves() const HD_RT { return {moves_.data(), move_count_}; }
  /** Whether any of these is of that mesh, which is in the scene. */
  [[nodiscard]] bool movesTriangles(const MeshView& mesh) const HD_RT { return mesh.deform.noted == advances_; }
  /** Slots of objects with an effect, kMaxEffects at most. */
  [[nodiscard]] std::span<const std::uint16_t> effects() const HD_RT { return {effecting_.data(), effecting_count_}; }
  [[nodiscard]] const EffectParameters& effect(std::uint32_t i) const HD_RT { return effects_[i]; }
  /** Grows whenever an effect may be another than a motion of its object made it: set, removed, shaped anew or jumped.
   */
  [[nodiscard]] std::uint64_t effectChanges() const HD_RT { return effect_changes_; }
  /** If in this tick a pose has put one where its motion does not bring it: the time since its last pose, at most
   * kPoseHold; else 0 [s]. */
  [[nodiscard]] double putOver() const HD_RT { return put_over_; }
  /** Where the object in that slot, moving as it does now, would have been a tick ago: X_WO_before, but for what has
   * been put. */
  [[nodiscard]] Pose onItsWayBefore(std::uint32_t i) const HD_RT;
  /** Grows whenever something may stand where it has not come by a motion: added, enabled, shaped anew or jumped. */
  [[nodiscard]] std::uint64_t arrivals() const HD_RT { return arrivals_; }
  [[nodiscard]] const SceneObject& slot(std::uint32_t i) const HD_RT { return objects_[i]; }
  /** By those who move it, each tick. */
  void setLoose(std::uint32_t i, bool loose) HD_RT { objects_[i].loose = loose; }
  /** The next step of what is in slot i is a teleport, however short. */
  void leaps(std::uint32_t i) HD_RT {
    motion_[i].jump = true;
    settled_ = false;
  }
  /** Tick in which the object in that slot was added or last jumped. */
  [[nodiscard]] std::uint64_t arrivedIn(std::uint32_t i) const HD_RT {
    return motion_[i].jump ? tick_ : motion_[i].arrived;
  }
  /**
   * Since it may have come to be about something that is there, or within it, unmet: it arrived, came to be felt, got
   * another shape, or made a step that neither its velocity tells nor contacts foresee [s].
   */
  [[nodiscard]] double sinceUnmet(std::uint32_t i) const HD_RT {
    return motion_[i].jump ? 0 : time_ - motion_[i].unmet;
  }
  /** Velocity of the surface at x_W, in W; `feature`, as in SweepHit, is the triangle of a mesh that may deform. */
  [[nodiscard]] Vec3 velocityAt(const SceneObject& object, std::uint32_t feature, const Vec3& x_W) const HD_RT;
  /** The object of that id, or null when it is gone. */
  [[nodiscard]] const SceneObject* find(std::uint32_t id) const HD_RT;

 private:
  /** What advance() needs beside the object itself. */
  struct Motion {
    /** Command::session of who has set the pose and velocity last. */
    std::uint32_t mover = kControlSession;
    double lease = 0;                ///< So long the velocity lasts [s]; 0: without end.
    Pose X_PO_before;                ///< At the last advance().
    double pose_time = 0;            ///< Of the last pose command, on the scene's clock [s].
    bool pose_set = false;           ///< A pose command came since the last advance().
    bool jump = false;               ///< The next advance() is no motion.
    bool reshaped = false;           ///< Nor is a pose in it: a change of shape came since the last one.
    bool hidden = true;              ///< It could not be touched at the last advance(),
    const MeshView* mesh = nullptr;  ///< and this was its mesh; not to be followed.
    bool teleported = false;         ///< In the last advance(): children were carried along.
    std::uint64_t arrived = 0;       ///< As arrivedIn().
    double unmet = 0;                ///< As sinceUnmet(), on the scene's clock [s].
    bool posed = false;              ///< In the last advance() a pose came, of it or of what is above,
    Pose X_WF;                       ///< and there its velocity and theirs would have brought it.
    Pose X_WB;                       ///< From here it came, moving as it does now,
    double posed_after = 0;          ///< so long after the pose before [s].
    std::uint64_t put = 0;           ///< The advance() in which it was put, as for putOver().
    bool world_moved = false;        ///< In the last advance(): children follow.
    Twist V_told;                    ///< By poses alone, in the parent's frame,
    double told_for = 0;             ///< so much longer [s].
    bool told = false;  ///< It, a given one or that of an object above is or was just not zero: children follow.
  };

  ErrorCode change(const Command& command) HD_RT;
  static void halt(SceneObject& object) HD_RT;
  [[nodiscard]] static double lasting(const Motion& motion, double dt) HD_RT;
  SceneObject* findMutable(std::uint32_t id) HD_RT;
  ErrorCode add(const AddObject& order) HD_RT;
  ErrorCode remove(std::uint32_t id) HD_RT;
  ErrorCode setPose(const hd_object_pose& pose) HD_RT;
  ErrorCode setShape(const SetShape& order) HD_RT;
  ErrorCode setMaterial(const hd_object_material& order) HD_RT;
  ErrorCode setSurface(const SetSurface& order) HD_RT;
  ErrorCode setFlags(const hd_object_flags& order) HD_RT;
  ErrorCode setEffect(const SetEffect& order) HD_RT;
  void noteEffect(std::uint32_t slot) HD_RT;
  ErrorCode moveVertices(const hd_object_vertices& order) HD_RT;
  void noteTriangles(const MeshView& mesh, const hd_vertex_move& move) HD_RT;
  ErrorCode makeShape(const ShapeParameters& parameters, Shape& shape) const HD_RT;
  bool advanceObject(std::uint32_t slot, double dt) HD_RT;
  [[nodiscard]] Pose foreseenIn(const SceneObject& object, const Motion& motion, double dt) const HD_RT;
  void notePosed(std::uint32_t slot, const Twist& V_PO, double since) HD_RT;
  void noteFelt(std::uint32_t slot, bool before) HD_RT;
  void rebuildTouchable() HD_RT;

  const MeshTable* meshes_;
  std::array<SceneObject, kMaxObjects> objects_{};
  std::array<Motion, kMaxObjects> motion_{};
  std::array<std::uint16_t, kMaxObjects> order_{};  ///< Used slots, parents first.
  std::uint32_t order_count_ = 0;
  std::array<std::uint16_t, kMaxObjects> touchable_{};
  std::uint32_t touchable_count_ = 0;
  std::uint64_t arrivals_ = 0;
  std::array<EffectParameters, kMaxObjects> effects_{};
  std::array<std::uint16_t, kMaxEffects> effecting_{};  ///< Slots of those that are one, in the order they became it.
  std::uint32_t effecting_count_ = 0;
  std::uint64_t effect_changes_ = 0;
  double put_over_ = 0;
  std::array<TriangleMove, kMaxTriangleMoves> moves_{};
  std::uint32_t move_count_ = 0;
  bool moves_are_new_ = false;  ///< The next advance() keeps them,
  std::uint64_t advances_ = 0;  ///< of which there were so many.
  double time_ = 0;             ///< Sum of all dt [s],
  double dt_ = 0;               ///< and the last of them, or that of the tick that comes.
  std::uint64_t tick_ = 0;      ///< Of the servo.
  bool settled_ = true;         ///< Nothing moves and nothing moved last tick: advance() has nothing to do.
};

}  // namespace hapticd
