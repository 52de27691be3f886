/** @file
 * Balls that move freely in a ToolHouse.
 */
#pragma once

#include "tests/support/stepped/tool_house.h"

namespace hapticd::test {

inline constexpr std::uint32_t kRolled = makeObjectId(10, 1), kOther = makeObjectId(11, 1);
inline constexpr double kBallRadius = 0.02;

inline SetBody body(std::uint32_t id, double mass, double damping = 0) {
  SetBody out{};
  out.object = id;
  out.falls = 1;
  out.mass = mass;
  for (int i = 0; i < 3; ++i) out.inertia[i] = 0.4 * mass * kBallRadius * kBallRadius;
  out.damping = damping;
  return out;
}

inline void addBall(ToolHouse& house, std::uint32_t id, const Vec3& at, double mass, double damping = 0) {
  house.send(CommandKind::kAddObject, object(id, ShapeKind::kSphere, {kBallRadius, 0, 0}, at));
  house.send(CommandKind::kSetBody, body(id, mass, damping));
  house.run(10);
}

inline const SceneObject& seen(const ToolHouse& house, std::uint32_t id) {
  return *house.servo->cycle().scene().find(id);
}
inline void gravity(ToolHouse& house, double g) { house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -g}}); }

}  // namespace hapticd::test
