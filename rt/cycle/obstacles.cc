#include "rt/cycle/obstacles.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hapticd {
namespace {

constexpr double kNearObstacle = 0.02;      ///< Beyond touching [m] ...
constexpr double kNearObstacleTime = 0.01;  ///< ... and as far as both move in this time [s].

/** From a point to an object's ball, or to a plane: no surface is nearer [m]. Negative: in there. */
double apartFrom(const SceneObject& object, const Vec3& x) HD_RT {
  if (std::isfinite(object.radius)) return (object.center_W - x).norm() - object.radius;
  return (object.X_WO.q * Vec3::UnitZ()).dot(x - object.X_WO.p);
}

}  // namespace

bool isPartOf(const Scene& scene, std::uint32_t slot, std::uint32_t of) HD_RT {
  for (std::uint32_t depth = 0; slot != 0 && depth < kMaxObjects; ++depth) {
    if (slot == of) return true;
    slot = scene.slot(slot).parent;
  }
  return false;
}

double speedBound(const RigidBody& body, const SceneObject& object) HD_RT {
  // The ball's middle from the body's centre of mass: as the scene has it, which may be a tick behind.
  const Vec3 middle = object.toLocal(object.center_W) - body.comInO();
  return body.twist().v.norm() + body.twist().w.norm() * (middle.norm() + object.radius);
}

void findObstacles(const Scene& scene, const SceneObject& self, std::span<const std::uint32_t> but,
                   CollideRequest::Held& held) HD_RT {
  held.count = 0;
  const Vec3 center = self.center_W + (held.X_WO.p - self.X_WO.p);
  const double own_speed = held.speed;
  std::array<double, CollideRequest::kMostObstacles> apart_of;
  double fastest = 0;
  for (const std::uint16_t slot : scene.touchable()) {
    const SceneObject& object = scene.slot(slot);
    if (!isFelt(object) || !isFirm(object.shape) || isPartOf(scene, slot, objectSlot(self.id))) continue;
    if (std::any_of(but.begin(), but.end(), [&](std::uint32_t id) { return isPartOf(scene, slot, objectSlot(id)); })) {
      continue;
    }
    const double speed = object.velocityAt(center).norm() + object.V_WO.w.norm() * self.radius;
    const double apart = apartFrom(object, center) - self.radius;
    if (apart > kNearObstacle + kNearObstacleTime * (own_speed + speed)) continue;
    std::uint32_t at = held.count;
    if (at == CollideRequest::kMostObstacles) {
      at = static_cast<std::uint32_t>(std::max_element(apart_of.begin(), apart_of.end()) - apart_of.begin());
      if (apart_of[at] <= apart) continue;
    } else {
      ++held.count;
    }
    apart_of[at] = apart;
    held.obstacle[at] = {slot, object.shape, object.X_WO, object.V_WO};
    fastest = std::max(fastest, speed);
  }
  held.speed += fastest;
}

}  // namespace hapticd
