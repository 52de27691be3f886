/** @file
 * What an object needs to move by itself, in a user's terms, and the mass properties of shapes.
 */
#pragma once

#include <string>

#include "daemon/scene/mesh_store.h"
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

/** xx yy zz xy xz yz, as orders have it. */
void storeInertia(const Mat3& inertia, double (&out)[6]);

}  // namespace hapticd
