/** @file
 * An object as clients describe it, in the control thread's terms.
 */
#pragma once

#include <cstdint>
#include <string>

#include "daemon/scene/effect.h"
#include "daemon/scene/surface.h"
#include "proto/shm_layout.h"
#include "rt/base/error.h"
#include "rt/base/math.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Who is at the other end of a connection. */
struct Client {
  std::uint64_t connection = 0;  ///< Number of the connection, never reused.
  std::string name;              ///< As it calls itself; empty before hello.
  std::int32_t pid = 0;
  std::uint32_t uid = 0;
  bool administration = false;  ///< It came by the administration socket.
  bool stop_only = false;       ///< Beyond the connections of its user, or of all: it may stop devices, and no more.
  bool left = false;            ///< It has gone, but not yet all that it had.
};

/** Geometry with the mesh by its id. */
struct ShapeSpec {
  ShapeKind kind = ShapeKind::kGroup;
  Vec3 size = Vec3::Zero();  ///< As Shape in control.capnp [m].
  std::uint64_t mesh = 0;    ///< For kMesh.
};

/** How an object moves by itself (docs/tool.md). */
struct BodySpec {
  double mass = 0;     ///< [kg]; 0: it stays where it is put.
  double damping = 1;  ///< Share of its motion that it loses [1/s].
  bool falls = true;   ///< The scene's gravity acts on it.
};

/** What a client asks for. */
struct ObjectFlags {
  bool enabled = true;
  bool visible = true;
  bool two_sided = false;
};

struct ObjectSpec {
  std::string name;
  std::string parent;  ///< Name of the parent, empty for the root.
  Pose X_PO;
  ShapeSpec shape;
  hd_material material{};
  SurfaceSpec surface;
  BodySpec body;
  EffectSpec effect;
  ObjectFlags flags;
  bool keep = false;  ///< Stays when its maker leaves.
};

/** A surface that every device class can render: 500 N/m, light damping, skin on plastic. */
inline constexpr hd_material kDefaultMaterial{500.0, 0.5, 0.4, 0.3};

// The bounds are those of the rings (rt/ingest/limits.h). Each names the field at fault under `where`. They never
// change their argument but for normalising a quaternion that is unit to 1e-3.
[[nodiscard]] Result<void> checkName(const std::string& name, const std::string& where);
[[nodiscard]] Result<void> checkPose(Pose& pose, const std::string& where);
[[nodiscard]] Result<void> checkMaterial(const hd_material& material, const std::string& where);
/** Sizes of a primitive; a mesh is checked by who knows meshes. */
[[nodiscard]] Result<void> checkShape(const ShapeSpec& shape, const std::string& where);

/** The word of control.capnp and of resource names: group, plane, sphere, ... */
[[nodiscard]] const char* shapeName(ShapeKind kind) noexcept;

/** Bits for the servo. */
[[nodiscard]] std::uint32_t objectFlags(const ObjectSpec& spec) noexcept;

}  // namespace hapticd
