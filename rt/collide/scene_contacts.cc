#include "rt/collide/scene_contacts.h"

#include <algorithm>
#include <cmath>

#include "rt/base/rotation.h"
#include "rt/contact/field_query.h"
#include "rt/geometry/nearest.h"
#include "rt/volume/distance.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kClockEvery = 16;  ///< Points between two looks at the clock.

/** Whatever has moved farther between two questions was put there [m]. */
constexpr double kTeleport = Scene::kTeleportSpeed * 2e-3;

constexpr std::uint32_t kFieldUnits = 60'000;  ///< For one obstacle: a million points, some 2 ms.

bool spent(const WorkBudget& budget, const DetectorReport& report, std::uint32_t points) HD_RT {
  if (report.work >= budget.units) return true;
  return budget.clock != nullptr && budget.deadline_ns != 0 && points % kClockEvery == 0 &&
         budget.clock->now() >= budget.deadline_ns;
}

}  // namespace

void SceneContacts::keep(const Contact& contact, std::uint8_t body) HD_RT {
  std::uint32_t at = found_.count;
  if (found_.count == kMaxContacts) {
    at = 0;
    for (std::uint32_t i = 1; i < kMaxContacts; ++i) {
      if (found_.contact[i].depth < found_.contact[at].depth) at = i;
    }
    if (found_.contact[at].depth >= contact.depth) return;
  } else {
    ++found_.count;
  }
  found_.contact[at] = contact;
  body_of_[at] = body;
}

const VolumeView* SceneContacts::volumeOf(const Shape& shape) const HD_RT {
  return volumes_ != nullptr && shape.kind == ShapeKind::kMesh ? volumes_->get(shape.mesh_entry) : nullptr;
}

Pose SceneContacts::before(const Stood& now) const HD_RT {
  for (const Stood& then : std::span(last_).first(last_count_)) {
    if (then.slot != now.slot || then.number != now.number) continue;
    const bool elsewhere = (then.X_WO.p - now.X_WO.p).norm() > kTeleport ||
                           then.X_WO.q.angularDistance(now.X_WO.q) > Scene::kTeleportAngle;
    return elsewhere ? now.X_WO : then.X_WO;
  }
  return now.X_WO;
}

void SceneContacts::remember(const CollideRequest::Held& held) HD_RT {
  last_count_ = 0;
  last_[last_count_++] = stoodOf(held);
  for (std::uint32_t k = 0; k < held.count; ++k) last_[last_count_++] = stoodOf(held.obstacle[k]);
}

bool SceneContacts::tryVolume(std::uint32_t k, const CollideRequest::Held& held, double ahead, const WorkBudget& budget,
                              DetectorReport& report) HD_RT {
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  DetectorQuery query;
  query.a.volume = volumeOf(held.shape);
  query.b.volume = volumeOf(obstacle.shape);
  if (query.a.volume == nullptr || query.b.volume == nullptr) return false;
  query.a.X_WO = held.X_WO;
  query.a.X_WO_before = before(stoodOf(held));
  query.b.X_WO = obstacle.X_WO;
  query.b.X_WO_before = before(stoodOf(obstacle));
  query.margin = kMargin + ahead * held.speed;
  query.budget = budget;
  query.budget.units = kFieldUnits;
  field_.find(query, field_found_);
  keepFound(k, report);
  if (ahead * held.speed > usableMargin(query.margin, *query.b.volume)) lookAhead(k, held, ahead, query, report);
  return true;
}

void SceneContacts::keepFound(std::uint32_t k, DetectorReport& report) HD_RT {
  for (const Contact& contact : field_found_.contacts()) {
    if (isFinite(contact.n_W) && isFinite(contact.p_WA) && isFinite(contact.p_WB)) {
      keep(contact, static_cast<std::uint8_t>(k));
    }
  }
  report.touching += field_found_.report.touching;
  report.dropped += field_found_.report.dropped;
  report.exhausted = report.exhausted || field_found_.report.exhausted;
}

/** What the field's margin does not reach: the same question where both will be, swept from where they are. */
void SceneContacts::lookAhead(std::uint32_t k, const CollideRequest::Held& held, double ahead, DetectorQuery& query,
                              DetectorReport& report) HD_RT {
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  const auto later = [ahead](const Pose& X, const Twist& V) HD_RT {
    return Pose{X.p + ahead * V.v, (fromRotationVector(ahead * V.w) * X.q).normalized()};
  };
  query.a.X_WO_before = held.X_WO;
  query.b.X_WO_before = obstacle.X_WO;
  query.a.X_WO = later(held.X_WO, held.V_WO);
  query.b.X_WO = later(obstacle.X_WO, obstacle.V_WO);
  field_.find(query, field_found_);
  field_found_.report.touching = 0;  // Not yet.
  // A contact is a point of the tool and a plane of the obstacle: both are taken back to where their bodies are.
  const Pose back_A = held.X_WO * query.a.X_WO.inverse(), back_B = obstacle.X_WO * query.b.X_WO.inverse();
  const std::uint32_t found = found_.count;
  std::uint32_t met = 0;
  for (Contact c : field_found_.contacts()) {
    bool known = false;  // There already: what is seen where they are now is nearer the truth.
    for (std::uint32_t i = 0; i < found && !known; ++i) {
      known = body_of_[i] == k && found_.contact[i].feature_a == c.feature_a;
    }
    if (known) continue;
    c.p_WA = back_A * c.p_WA;
    c.p_WB = back_B * c.p_WB;
    c.n_W = back_B.q * c.n_W;
    c.depth = c.n_W.dot(c.p_WB - c.p_WA);
    field_found_.contact[met++] = c;
  }
  field_found_.count = met;
  keepFound(k, report);
}

bool SceneContacts::lookAt(const CollideRequest::Obstacle& obstacle, const Vec3& x_B, double reach,
                           DetectorReport& report, PointTouch& out) const HD_RT {
  NearestQuery query;
  query.x = x_B;
  query.reach = reach;
  query.limit = kWorkOfOne;
  Nearest nearest;
  const NearestResult result = nearestOnShape(obstacle.shape, query, nearest);
  report.work += query.work;
  if (result == NearestResult::kExhausted) ++report.dropped;
  if (result == NearestResult::kFound) {
    const double distance = std::sqrt(nearest.squared_distance);
    const bool inside = nearest.isInside(x_B);
    out.surface = nearest.point;
    out.gap = inside ? -distance : distance;
    // From the surface toward the point, or out by the feature's normal where they coincide.
    out.out = distance > 1e-7 ? Vec3((x_B - nearest.point) / out.gap) : nearest.pseudo_normal.normalized();
    return true;
  }
  const VolumeView* volume = volumeOf(obstacle.shape);
  if (volume == nullptr) return false;
  const DistanceSample sample = distanceAt(*volume, x_B);
  const double slope = sample.gradient.norm();
  if (!(sample.value < 0) || !(slope > 0)) return false;
  out.out = sample.gradient / slope;
  out.gap = sample.value;
  out.surface = x_B - out.gap * out.out;
  return true;
}

void SceneContacts::tryPoint(std::uint32_t i, const CollideRequest::Held& held, double margin,
                             DetectorReport& report) HD_RT {
  const Vec3 p_W = held.X_WO * points_.at(i);
  bool hot = false;
  float deepest = 0;
  for (std::uint32_t k = 0; k < held.count; ++k) {
    const CollideRequest::Obstacle& obstacle = held.obstacle[k];
    if (!isFirm(obstacle.shape) || (by_field_ >> k & 1) != 0) continue;
    PointTouch at;
    const double reach = std::max(kReach, margin) + points_.radius() + static_cast<double>(depth_[i]);
    if (!lookAt(obstacle, obstacle.X_WO.inverse() * p_W, reach, report, at)) continue;
    const double gap = at.gap - points_.radius();
    if (gap > margin) continue;
    Contact contact;
    contact.n_W = obstacle.X_WO.q * at.out;
    contact.p_WB = obstacle.X_WO * at.surface;
    contact.p_WA = p_W - points_.radius() * contact.n_W;
    contact.depth = -gap;
    contact.feature_a = i;
    if (!isFinite(contact.n_W) || !isFinite(contact.p_WA)) continue;
    keep(contact, static_cast<std::uint8_t>(k));
    hot = true;
    deepest = std::max(deepest, static_cast<float>(-at.gap));
    report.touching += gap <= 0 ? 1 : 0;
  }
  hot_[i] = hot;
  depth_[i] = deepest;
}

void SceneContacts::find(const CollideRequest::Held& held, double ahead, const WorkBudget& budget, ContactModel& model,
                         DetectorReport& report) HD_RT {
  report = DetectorReport{};
  if (held.object != made_for_ || held.shape.kind != made_of_.kind || held.shape.size != made_of_.size ||
      held.shape.mesh != made_of_.mesh || held.shape.number != made_of_.number) {
    points_.make(held.shape);
    made_for_ = held.object;
    made_of_ = held.shape;
    model.count = 0;
    hot_.fill(false);
    depth_.fill(0);
    cursor_ = 0;
    last_count_ = 0;
    field_.reset();
  }
  found_.count = 0;
  const double margin = kMargin + ahead * held.speed;
  by_field_ = 0;
  for (std::uint32_t k = 0; k < held.count; ++k) {
    if (tryVolume(k, held, ahead, budget, report)) by_field_ |= 1u << k;
  }
  remember(held);
  const bool all_by_field = by_field_ == (std::uint64_t{1} << held.count) - 1;
  const std::uint32_t n = all_by_field ? 0 : points_.count();
  std::uint32_t tried = 0;
  bool out_of_budget = false;
  std::array<bool, ToolPoints::kMost> was_hot;
  std::copy_n(hot_.begin(), n, was_hot.begin());
  for (std::uint32_t i = 0; i < n && !out_of_budget; ++i) {
    if (!was_hot[i]) continue;
    if ((out_of_budget = spent(budget, report, tried))) break;
    tryPoint(i, held, margin, report);
    ++tried;
  }
  const std::uint32_t first = n > 0 ? cursor_ % n : 0;
  for (std::uint32_t k = 0; k < n && !out_of_budget; ++k) {
    const std::uint32_t i = (first + k) % n;
    if (was_hot[i]) continue;
    if ((out_of_budget = spent(budget, report, tried))) {
      cursor_ = i;
      break;
    }
    tryPoint(i, held, margin, report);
    ++tried;
  }
  report.exhausted = report.exhausted || out_of_budget;
  report.dropped += n - tried;

  std::array<ContactBody, CollideRequest::kMostObstacles> bodies;
  for (std::uint32_t k = 0; k < held.count; ++k) bodies[k] = {held.obstacle[k].slot, held.obstacle[k].X_WO};
  model.build(found_, held.X_WO, {bodies.data(), held.count}, ahead * held.speed, {body_of_.data(), found_.count});
}

}  // namespace hapticd
