/** @file
 * What the servo asks the collide thread: where do the tools in the hands touch the scene? A copy of all that the
 * answer needs, so that the collide thread never looks at the servo's scene.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "rt/scene/scene.h"

namespace hapticd {

/** Whether the collide thread can say where a shape is: not of deformable meshes, which change meanwhile. */
[[nodiscard]] inline bool isFirm(const Shape& shape) HD_RT {
  return shape.kind != ShapeKind::kMesh || (shape.mesh != nullptr && shape.mesh->deform.vertices == nullptr);
}

struct CollideRequest {
  static constexpr std::uint32_t kMostObstacles = 16;

  struct Obstacle {
    std::uint32_t slot = 0;
    Shape shape;
    Pose X_WO;
    Twist V_WO;                 ///< Of the origin, in the world.
    std::uint64_t arrived = 0;  ///< Tick in which it last came there by no motion.
  };
  /** One device's tool, or a free body. */
  struct Held {
    std::uint32_t object = 0;  ///< Id, 0: there is none.
    Shape shape;
    Pose X_WO;
    Twist V_WO;                 ///< Of the origin, in the world.
    std::uint64_t arrived = 0;  ///< As Obstacle::arrived.
    double speed = 0;           ///< No point of the tool is faster relative to any obstacle [m/s].
    bool put = false;           ///< It, or what is near it, was put there: what it lies deep in is looked for, too.
    std::uint32_t count = 0;
    std::array<Obstacle, kMostObstacles> obstacle;  ///< The nearest; see findObstacles().

    Held() = default;
    Held(const Held&) = default;
    /** Of what is there alone: all of it is 45 kB, which the servo would copy in every tick. */
    Held& operator=(const Held& other) HD_RT {
      object = other.object;
      if (object == 0 || this == &other) return *this;
      shape = other.shape;
      X_WO = other.X_WO;
      V_WO = other.V_WO;
      arrived = other.arrived;
      speed = other.speed;
      put = other.put;
      count = other.count;
      std::copy_n(other.obstacle.begin(), std::min(count, kMostObstacles), obstacle.begin());
      return *this;
    }
  };

  std::uint64_t tick = 0;    ///< Of the servo: all stands as at its end.
  std::uint32_t orders = 0;  ///< Of the control thread that the servo had taken: what they dropped is not named here.
  std::array<Held, kMaxDevices + kMaxBodies> held;  ///< Tools by device, then bodies.
};

}  // namespace hapticd
