/** @file
 * Who says again what an order left behind, when a servo comes later or a recording begins: for every kind, so that
 * none is forgotten.
 */
#pragma once

#include "rt/command.h"

namespace hapticd {

enum class Restated : std::uint8_t {
  kNever,       ///< It leaves nothing, or what it leaves must not come again (an armed device).
  kSceneAdd,    ///< The scene model, within AddObject.
  kSceneOrder,  ///< The scene model, by an order of that kind for each object that needs one (SceneModel::replay()).
  kScene,       ///< The scene model, once.
  kCycle,       ///< restate() of cycle_start.h.
  kSession,     ///< SessionShare::restate().
  kConfig,      ///< CycleConfig, with which a cycle begins.
  kMesh         ///< The memory of the mesh itself.
};

// A new kind does not compile before its place is decided here.
#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wswitch"
[[nodiscard]] constexpr Restated whoRestates(CommandKind kind) {
  switch (kind) {
    case CommandKind::kNone:
    case CommandKind::kArm:
    case CommandKind::kDisarm:
    case CommandKind::kToolContacts:
      return Restated::kNever;
    case CommandKind::kAddObject:
    case CommandKind::kRemoveObject:
    case CommandKind::kSetShape:
    case CommandKind::kObjectMaterial:
    case CommandKind::kObjectFlags:
      return Restated::kSceneAdd;
    case CommandKind::kObjectPose:  // Beyond the place: the velocity.
    case CommandKind::kSetSurface:
    case CommandKind::kSetBody:
    case CommandKind::kSetEffect:
      return Restated::kSceneOrder;
    case CommandKind::kSetGravity:
      return Restated::kScene;
    case CommandKind::kAddSession:
    case CommandKind::kLoseSession:
    case CommandKind::kReviveSession:
    case CommandKind::kFreeSession:
    case CommandKind::kStop:
    case CommandKind::kDeviceRadius:
    case CommandKind::kAttachTool:
    case CommandKind::kDetachTool:
    case CommandKind::kSetGrip:
    case CommandKind::kSetMount:
    case CommandKind::kSetFinger:
    case CommandKind::kSetClutch:
      return Restated::kCycle;
    case CommandKind::kLocalModel:
    case CommandKind::kForceField:
    case CommandKind::kClearModel:
    case CommandKind::kClientForce:
    case CommandKind::kIntent:
    case CommandKind::kLimits:
      return Restated::kSession;
    case CommandKind::kDeviceLimits:
      return Restated::kConfig;
    case CommandKind::kObjectVertices:
      return Restated::kMesh;
  }
  return Restated::kNever;
}
#pragma GCC diagnostic pop

inline constexpr std::uint32_t kMostKinds = 128;  ///< All kinds of command are below.

}  // namespace hapticd
