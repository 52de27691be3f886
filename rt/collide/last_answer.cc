// What the answer before still says: where all stood, and contacts for which there is no time now.
#include <algorithm>
#include <array>
#include <span>

#include "rt/collide/feature.h"
#include "rt/collide/scene_contacts.h"

namespace hapticd {
namespace {

/** Whatever has moved farther between two questions was put there [m]. */
constexpr double kTeleport = Scene::kTeleportSpeed * 2e-3;

constexpr std::uint32_t kMostCut = 50;  ///< Answers: as long as the servo goes on without any (HeldTool::kStale).

}  // namespace

const SceneContacts::Stood* SceneContacts::then(const Stood& now) const HD_RT {
  for (const Stood& then : std::span(last_).first(last_count_)) {
    if (then.slot != now.slot || then.number != now.number) continue;
    const bool elsewhere = then.arrived != now.arrived || (then.X_WO.p - now.X_WO.p).norm() > kTeleport ||
                           then.X_WO.q.angularDistance(now.X_WO.q) > Scene::kTeleportAngle;
    return elsewhere ? nullptr : &then;
  }
  return nullptr;
}

Pose SceneContacts::before(const Stood& now) const HD_RT {
  const Stood* const stood = then(now);
  return stood != nullptr ? stood->X_WO : now.X_WO;
}

void SceneContacts::remember(const CollideRequest::Held& held) HD_RT {
  std::array<Stood, CollideRequest::kMostObstacles + 1> now;
  std::uint32_t count = 0;
  now[count++] = stoodOf(held);
  for (std::uint32_t k = 0; k < held.count; ++k) {
    Stood stood = stoodOf(held.obstacle[k]);
    const Stood* const last = then(stood);
    if ((cut_ >> k & 1) != 0) stood.cut = last != nullptr ? last->cut + 1 : 1;
    now[count++] = stood;
  }
  last_ = now;
  last_count_ = count;
}

/** On which side of a sheet a point stood says nothing once either was put elsewhere, or another sheet in its place. */
void SceneContacts::forgetSides(const CollideRequest::Held& held) HD_RT {
  const auto isAsThen = [this](const Stood& now) HD_RT {  // However fast it moved.
    const auto is = [&](const Stood& then) HD_RT {
      return then.slot == now.slot && then.number == now.number && then.arrived == now.arrived;
    };
    return std::any_of(last_.begin(), last_.begin() + last_count_, is);
  };
  const bool stays = isAsThen(stoodOf(held));
  for (std::uint32_t k = 0; k < held.count; ++k) {
    const CollideRequest::Obstacle& obstacle = held.obstacle[k];
    if (!isFirm(obstacle.shape) || !isSheet(obstacle.shape)) continue;
    if (stays && isAsThen(stoodOf(obstacle))) continue;
    for (Sided& at : side_) {
      if (at.slot == obstacle.slot) at = {};
    }
  }
}

/** Whose turn it is: that which has been cut short for the longest. */
std::uint32_t SceneContacts::firstOf(const CollideRequest::Held& held) const HD_RT {
  std::uint32_t first = 0, most = 0;
  for (std::uint32_t k = 0; k < held.count; ++k) {
    const Stood* const last = then(stoodOf(held.obstacle[k]));
    if (last == nullptr || last->cut <= most) continue;
    most = last->cut;
    first = k;
  }
  return first;
}

/** Contacts of the last answer with obstacles for which there was no time, where they are now. */
void SceneContacts::carryOver(const CollideRequest::Held& held, double margin, const ContactModel& model,
                              const Tries& tries) HD_RT {
  if (cut_ == 0 || then(stoodOf(held)) == nullptr) return;
  const std::uint32_t found = found_.count;
  for (std::uint32_t i = 0; i < model.count; ++i) {
    for (std::uint32_t k = 0; k < held.count; ++k) {
      const CollideRequest::Obstacle& obstacle = held.obstacle[k];
      if ((cut_ >> k & 1) == 0 || obstacle.slot != model.point[i].body()) continue;
      const Stood* const last = then(stoodOf(obstacle));
      if (last == nullptr || last->cut >= kMostCut) continue;
      const Touch touch = model.touch(i, held.X_WO, Vec3::Zero(), obstacle.X_WO, Twist{});
      Contact contact;
      contact.p_WA = touch.r_a;
      contact.n_W = touch.n;
      contact.depth = -touch.gap;
      contact.p_WB = contact.p_WA + contact.depth * contact.n_W;
      contact.feature_a = model.point[i].feature();
      const bool known = isKnown(k, contact.feature_a, held, tries) || isFound(k, contact.feature_a, found);
      if (touch.gap <= margin && !known) keep(contact, held, k);
    }
  }
}

/** Its point has had its turn, and stands apart from obstacle k if it is not among what was found. */
bool SceneContacts::isKnown(std::uint32_t k, std::uint32_t feature, const CollideRequest::Held& held,
                            const Tries& tries) const HD_RT {
  if ((whole_ >> k & 1) != 0) return false;  // Points of its own.
  if (feature < ToolPoints::kMost) return tries.known[feature];
  return held.shape.kind == ShapeKind::kSphere && feature >= kFirstMeshEdge && feature != kWayOut && tries.known[0];
}

bool SceneContacts::isFound(std::uint32_t k, std::uint32_t feature, std::uint32_t among) const HD_RT {
  for (std::uint32_t i = 0; i < among; ++i) {
    if (body_of_[i] == k && found_.contact[i].feature_a == feature) return true;
  }
  return false;
}

}  // namespace hapticd
