#include "rt/cycle/obstacles.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

constexpr double kReach = 0.02;      ///< Beyond touching [m] ...
constexpr double kReachTime = 0.01;  ///< ... and as far as it moves in this time [s].

}  // namespace

bool isPartOf(const Scene& scene, std::uint32_t slot, std::uint32_t of) HD_RT {
  for (std::uint32_t depth = 0; slot != 0 && depth < kMaxObjects; ++depth) {
    if (slot == of) return true;
    slot = scene.slot(slot).parent;
  }
  return false;
}

void findObstacles(const Scene& scene, const SceneObject& self, std::span<const std::uint32_t> but,
                   CollideRequest::Held& held) HD_RT {
  held.count = 0;
  const Vec3 center = self.center_W + (held.X_WO.p - self.X_WO.p);
  double fastest = 0;
  for (const std::uint16_t slot : scene.touchable()) {
    const SceneObject& object = scene.slot(slot);
    if (held.count == CollideRequest::kMostObstacles) break;
    if (isPartOf(scene, slot, objectSlot(self.id))) continue;
    if (std::any_of(but.begin(), but.end(), [&](std::uint32_t id) { return isPartOf(scene, slot, objectSlot(id)); })) {
      continue;
    }
    const double reach = object.radius + self.radius + kReach + kReachTime * held.speed;
    const bool endless = !std::isfinite(object.radius);  // a plane
    if (!endless && (object.center_W - center).squaredNorm() > reach * reach) continue;
    CollideRequest::Obstacle& out = held.obstacle[held.count++];
    out.slot = slot;
    out.shape = object.shape;
    out.X_WO = object.X_WO;
    out.V_WO = object.V_WO;
    fastest = std::max(fastest, object.velocityAt(center).norm() + object.V_WO.w.norm() * self.radius);
  }
  held.speed += fastest;
}

}  // namespace hapticd
