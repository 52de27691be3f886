// When bodies fall asleep, and what wakes them.
#include <algorithm>
#include <array>

#include "rt/cycle/free_bodies.h"

namespace hapticd {
namespace {

constexpr double kSupport = 5e-4;   ///< What lies has something this near below it [m] ...
constexpr double kUpward = 0.05;    ///< ... that faces its weight by this cosine or more.
constexpr double kUnturned = 1e-4;  ///< What has turned less is where it was [rad].
constexpr double kStirring = 1e-5;  ///< An obstacle that moves faster wakes what it touches [m/s].

}  // namespace

FreeBodies::Support FreeBodies::supportOf(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT {
  const SceneObject &self = scene.slot(objectSlot(entry_[k].object)), &other = scene.slot(slot);
  const std::uint64_t mesh = other.shape.kind == ShapeKind::kMesh ? other.shape.number : 0;
  return {slot, other.shape.kind, other.shape.size, mesh, other.X_WO, frictionOf(self, other)};
}

void FreeBodies::noteSupports(const Scene& scene, std::uint8_t k) HD_RT {
  Entry& entry = entry_[k];
  entry.supports = 0;
  for (std::uint32_t i = 0; i < entry.model.count; ++i) {
    const std::uint32_t slot = entry.model.point[i].body();
    const auto begin = entry.support.begin(), end = begin + entry.supports;
    const auto isIt = [&](const Support& s) HD_RT { return s.slot == slot; };
    if (std::any_of(begin, end, isIt) || !meets(scene, k, i) || touchOf(scene, k, i).gap > kTouching) continue;
    entry.support[entry.supports++] = supportOf(scene, k, slot);
  }
}

/**
 * Whatever else it touches: a plank on two blocks would hang in the air on one of them. Another that is there instead,
 * as like as that, holds as well.
 */
bool FreeBodies::isHeldAsBefore(const Scene& scene, std::uint8_t k) const HD_RT {
  const Entry& entry = entry_[k];
  const auto isAsBefore = [&](const Support& then) HD_RT {
    if (!feels(scene, k, then.slot)) return false;
    const Support now = supportOf(scene, k, then.slot);
    return now.kind == then.kind && now.size == then.size && now.mesh == then.mesh &&
           (now.X_WO.p - then.X_WO.p).norm() <= kTouching && now.X_WO.q.angularDistance(then.X_WO.q) <= kUnturned &&
           !(now.friction < then.friction);
  };
  return std::all_of(entry.support.begin(), entry.support.begin() + entry.supports, isAsBefore);
}

/**
 * What lies stays asleep until something that held it goes or holds it less, or something that moves touches it. Of two
 * bodies only one may know of the contact: whichever is awake wakes the other. It does not keep it awake: see
 * watchRest().
 */
void FreeBodies::wakeTouched(const Scene& scene, std::uint8_t k) HD_RT {
  Entry& entry = entry_[k];
  bool lies = false;  // What is beside it or on it does not carry it: two would hold each other in the air.
  const Vec3 weight = entry.body.weightOf(gravity_);
  for (std::uint32_t i = 0; i < entry.model.count; ++i) {
    const std::uint32_t slot = entry.model.point[i].body();
    if (!meets(scene, k, i)) continue;
    const Touch touch = touchOf(scene, k, i);
    lies = lies || (touch.gap < kSupport && -touch.n.dot(weight) > kUpward * weight.norm());
    if (touch.gap > kTouching) continue;
    if (touch.moving.norm() > kStirring) entry.body.wake();
    const std::uint8_t other = find(slot);
    if (other == kNone) continue;
    const auto moves = [](const Entry& e) HD_RT { return !e.body.asleep() && e.age < kStale; };
    if (entry_[other].body.asleep() && moves(entry)) entry_[other].body.wake();
    if (entry.body.asleep() && moves(entry_[other])) entry.body.wake();
  }
  if (entry.body.asleep() && !lies && !weight.isZero(0)) entry.body.wake();
  if (entry.body.asleep() && !isHeldAsBefore(scene, k)) entry.body.wake();
  if (!entry.body.asleep()) noteSupports(scene, k);
}

/** What touches falls asleep together: one of a pile that slept by itself would be woken by the next, and so on. */
void FreeBodies::watchRest(double dt) HD_RT {
  std::array<bool, JointStep::kMaxMovers> stirs{};
  for (Entry& entry : entry_) {
    if (entry.mover == kNone) continue;
    if (!entry.body.watchRest(dt)) stirs[joint_.island(entry.mover)] = true;
  }
  for (Entry& entry : entry_) {
    if (entry.mover != kNone && !stirs[joint_.island(entry.mover)]) entry.body.sleep();
  }
}

}  // namespace hapticd
