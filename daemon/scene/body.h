/** @file
 * What an object needs to move by itself, in a user's terms, and the mass properties of shapes.
 */
#pragma once

#include <string>

#include "daemon/scene/mesh/mesh_store.h"
#include "daemon/scene/object.h"
#include "rt/body/rigid_body.h"

namespace hapticd {

inline constexpr double kLightestBody = 0.005, kHeaviestBody = 100;  ///< [kg]
inline constexpr double kMostBodyDamping = 1000;                     ///< [1/s]

/** Whether an object of that shape and place in the tree can be a rigid body; `where` is for the refusal. */
[[nodiscard]] Result<void> checkMovable(const ObjectSpec& spec, const MeshStore& meshes, const std::string& where);
[[nodiscard]] Result<void> checkBody(const BodySpec& body, const std::string& where);

/** Of the solid itself where it has a volume; else of a ball or of a box as heavy and large. `shape` has been checked.
 */
[[nodiscard]] MassProperties massOf(const ShapeSpec& shape, const MeshStore& meshes, double mass);

/** The mesh's volume, or null. */
[[nodiscard]] const VolumeView* volumeOf(const ShapeSpec& shape, const MeshStore& meshes);

/**
 * Why a mesh that is held or moves freely meets things by its vertices alone, and the remedy; "": by its field where
 * there are fields, or it is no mesh. `most_patches`: of SceneContacts, for tools or for bodies.
 */
[[nodiscard]] std::string withoutField(const std::string& name, const ShapeSpec& shape, const MeshStore& meshes,
                                       std::uint32_t most_patches);

/** xx yy zz xy xz yz, as orders have it. */
void storeInertia(const Mat3& inertia, double (&out)[6]);

}  // namespace hapticd
