#include "rt/collide/scene_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/base/rotation.h"
#include "rt/collide/edge_search.h"
#include "rt/collide/feature.h"
#include "rt/collide/purse.h"
#include "rt/collide/sheet.h"
#include "rt/contact/field_query.h"
#include "rt/geometry/nearest/nearest.h"
#include "rt/volume/distance.h"

namespace hapticd {
namespace {

bool isLate(const WorkBudget& budget) HD_RT {
  return budget.clock != nullptr && budget.deadline_ns != 0 && budget.clock->now() >= budget.deadline_ns;
}

constexpr double kTilted = 0.3176;             ///< So far aside of outward a mesh's point may touch [rad], ...
constexpr double kMostTilted = 1.5;            ///< ... and at most so far where a hit may turn the tool.
constexpr double kPutDeep = 0.2;               ///< How deep a body may have been put, for few of its points [m].
constexpr std::uint32_t kFieldUnits = 60'000;  ///< For one obstacle: a million points, some 2 ms.

}  // namespace

void SceneContacts::noteHeld(const CollideRequest::Held& held, const ContactModel& model) HD_RT {
  named_count_ = 0;
  for (std::uint32_t i = 0; i < model.count; ++i) {
    std::uint32_t k = 0;
    while (k < held.count && held.obstacle[k].slot != model.point[i].body()) ++k;
    if (k < held.count) named_[named_count_++] = {k, model.point[i].feature()};
  }
}

/**
 * What cannot touch before the next answer makes room for what can. Then whichever side has most of it does, where
 * another comes: a box between two has as many points on its lid as on its bottom, all as deep, and neither may be
 * forgotten for the other. Within a side those found first stay but for deeper ones; a box's corner that may touch
 * before the next answer counts as deep as that, for whatever is between corners is held by them.
 */
std::uint32_t SceneContacts::roomFor(const Kept& kept) const HD_RT {
  if (found_.count < room_) return found_.count;
  std::uint8_t from = kFar;
  if (many_[kFar] == 0) {
    if (kept.side == kFar) return kMaxContacts;
    from = kept.side;
    const auto own = static_cast<std::uint32_t>(many_[from] + 1);
    for (std::uint32_t i = 0, most = own; i < room_ && own < room_ / 2; ++i) {
      if (many_[kept_[i].side] <= most) continue;
      from = kept_[i].side;
      most = many_[from];
    }
  }
  std::uint32_t at = kMaxContacts;
  for (std::uint32_t i = 0; i < room_; ++i) {
    if (kept_[i].side == from && (at == kMaxContacts || kept_[i].depth < kept_[at].depth)) at = i;
  }
  if (at == kMaxContacts) return at;
  const double lead = from == kFar ? 0 : ContactModel::kLeastReach;
  return from == kept.side && !(kept_[at].depth + lead < kept.depth) ? kMaxContacts : at;
}

/**
 * What the fastest point of anything near could do was once what every gap could close: of a capsule that fell in a
 * heap, walls beside it and the floor below its bin had all the places, and its end came 3.5 mm into the bin.
 */
double SceneContacts::reachOf(const Contact& contact, const CollideRequest::Held& held, std::uint32_t k) const HD_RT {
  return std::min(reach_, kMargin + closingOf(contact, held, k));
}

double SceneContacts::closingOf(const Contact& contact, const CollideRequest::Held& held, std::uint32_t k) const HD_RT {
  const CollideRequest::Obstacle& its = held.obstacle[k];
  const Vec3 v = velocityAt(held.V_WO, contact.p_WA - held.X_WO.p) - velocityAt(its.V_WO, contact.p_WA - its.X_WO.p);
  return ahead_ * std::max(0.0, -contact.n_W.dot(v));
}

void SceneContacts::keep(const Contact& contact, const CollideRequest::Held& held, std::uint32_t k) HD_RT {
  const auto body = static_cast<std::uint8_t>(k);
  const double reach = std::max(reachOf(contact, held, k), ContactModel::kLeastReach);
  const bool far = contact.depth < -reach;
  if (far && found_.count == room_ && many_[kFar] == 0) return;
  const auto named = [&](const Named& n) HD_RT { return n.body == body && n.feature == contact.feature_a; };
  const bool stays = std::any_of(named_.begin(), named_.begin() + named_count_, named);
  Eigen::Index axis = 0;
  contact.n_W.cwiseAbs().maxCoeff(&axis);
  const auto side = static_cast<std::uint8_t>(1 + 6 * body + 2 * axis + (contact.n_W[axis] < 0 ? 1 : 0));
  const bool corner = made_of_.kind == ShapeKind::kBox && contact.feature_a < kBoxCorners;
  const double depth = contact.depth + reach + (stays ? ContactModel::kLeastReach : 0) + (corner ? reach_ : 0);
  // A face's points are often all as deep as the way out of it, and hundreds.
  const bool first = contact.feature_a == kWayOut;
  const Kept kept{far ? kFar : side, first ? std::numeric_limits<double>::infinity() : depth, reach};
  const std::uint32_t at = roomFor(kept);
  if (at == kMaxContacts) return;
  if (at == found_.count) {
    ++found_.count;
  } else {
    --many_[kept_[at].side];
  }
  ++many_[kept.side];
  found_.contact[at] = contact;
  body_of_[at] = body;
  kept_[at] = kept;
}

void SceneContacts::drop(std::uint32_t i) HD_RT {
  --many_[kept_[i].side];
  const std::uint32_t last = --found_.count;
  found_.contact[i] = found_.contact[last];
  body_of_[i] = body_of_[last];
  kept_[i] = kept_[last];
}

const VolumeView* SceneContacts::volumeOf(const Shape& shape) const HD_RT {
  return volumes_ != nullptr && shape.kind == ShapeKind::kMesh ? volumes_->get(shape.mesh_entry) : nullptr;
}

bool SceneContacts::tryVolume(std::uint32_t k, const CollideRequest::Held& held, double ahead, const WorkBudget& budget,
                              DetectorReport& report) HD_RT {
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  DetectorQuery query;
  query.a.volume = volumeOf(held.shape);
  query.b.volume = volumeOf(obstacle.shape);
  if (query.a.volume == nullptr || query.b.volume == nullptr || query.a.volume->patches.size() > patches_) return false;
  query.a.X_WO = held.X_WO;
  query.a.X_WO_before = before(stoodOf(held));
  query.b.X_WO = obstacle.X_WO;
  query.b.X_WO_before = before(stoodOf(obstacle));
  query.margin = kMargin + ahead * held.speed;
  query.budget = budget;
  query.budget.units = kFieldUnits;
  findIn(k, query);
  keepFound(k, held, report);
  if ((cut_ >> k & 1) == 0 && ahead * held.speed > usableMargin(query.margin, *query.b.volume))
    lookAhead(k, held, ahead, query, report);
  return true;
}

void SceneContacts::findIn(std::uint32_t k, const DetectorQuery& query) HD_RT {
  field_.find(query, field_found_);
  if (field_found_.report.exhausted && isLate(query.budget)) cut_ |= 1u << k;
}

void SceneContacts::keepFound(std::uint32_t k, const CollideRequest::Held& held, DetectorReport& report) HD_RT {
  for (const Contact& contact : field_found_.contacts()) {
    if (isFinite(contact.n_W) && isFinite(contact.p_WA) && isFinite(contact.p_WB)) {
      keep(contact, held, k);
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
  findIn(k, query);
  field_found_.report.touching = 0;  // Not yet.
  // Found where the bodies will be: its point goes back with the tool, its plane with the obstacle.
  const Pose back_A = held.X_WO * query.a.X_WO.inverse(), back_B = obstacle.X_WO * query.b.X_WO.inverse();
  const std::uint32_t found = found_.count;
  std::uint32_t met = 0;
  for (Contact c : field_found_.contacts()) {
    if (isFound(k, c.feature_a, found)) continue;  // What is seen where they are now is nearer the truth.
    c.p_WA = back_A * c.p_WA;
    c.p_WB = back_B * c.p_WB;
    c.n_W = back_B.q * c.n_W;
    c.depth = c.n_W.dot(c.p_WB - c.p_WA);
    field_found_.contact[met++] = c;
  }
  field_found_.count = met;
  keepFound(k, held, report);
}

SceneContacts::Looked SceneContacts::lookAt(const CollideRequest::Obstacle& obstacle, const Vec3& x_B, double reach,
                                            Purse& purse, int& side, PointTouch& out) const HD_RT {
  NearestQuery query;
  query.x = x_B;
  query.reach = reach;
  query.limit = purse.left();
  Nearest nearest;
  const NearestResult result = nearestOnShape(obstacle.shape, query, nearest);
  purse.report.work += query.work;
  if (result == NearestResult::kFound) {
    const double distance = std::sqrt(nearest.squared_distance);
    const Vec3 way = x_B - nearest.point;
    bool inside = nearest.isInside(x_B);
    if (obstacle.shape.kind == ShapeKind::kMesh) out.triangle = nearest.feature;
    if (!isSheet(obstacle.shape)) {
      side = 0;
    } else {
      // A sheet has no inside: it is a wall seen from the side the point came from, and nothing beside its rim.
      const bool beside =
          nearest.kind != FeatureKind::kFace && std::abs(way.dot(nearest.pseudo_normal)) < 0.5 * distance;
      if (side == 0 || beside) side = inside ? -1 : 1;
      inside = !beside && inside != (side < 0);
      out.border = isOnBorder(*obstacle.shape.mesh, nearest);
    }
    out.surface = nearest.point;
    out.gap = inside ? -distance : distance;
    // From the surface toward the point, or out by the feature's normal where they coincide; a sheet's rim has none.
    out.out = distance > 1e-7 ? Vec3(way / out.gap) : nearest.pseudo_normal;
    if (out.out.isZero(0)) out.out = nearest.normal;
    if (distance <= 1e-7 && side < 0) out.out = -out.out;
    return Looked::kNear;
  }
  const Looked otherwise = result == NearestResult::kExhausted ? Looked::kUnknown : Looked::kFar;
  const VolumeView* volume = volumeOf(obstacle.shape);
  if (volume == nullptr) return otherwise;
  const DistanceSample sample = distanceAt(*volume, x_B);
  const double slope = sample.gradient.norm();
  if (!(sample.value < 0) || !(slope > 0)) return otherwise;
  out.out = sample.gradient / slope;
  out.gap = sample.value;
  out.surface = x_B - out.gap * out.out;
  return Looked::kNear;
}

bool SceneContacts::isOutermost(const Vec3& x, const CollideRequest::Held& held, const Vec3& n, double turn,
                                Purse& purse) const HD_RT {
  if (held.shape.kind != ShapeKind::kMesh || isSheet(held.shape)) return true;
  const double step = 1e-3 * points_.reach();
  NearestQuery query;
  query.x = x + step * n;
  query.reach = step * std::cos(kTilted + turn);
  query.limit = purse.left();
  Nearest nearest;
  const NearestResult result = nearestOnShape(held.shape, query, nearest);
  purse.report.work += query.work;
  return result != NearestResult::kFound;
}

bool SceneContacts::isToldAsPoint(const Vec3& x, const CollideRequest::Held& held,
                                  const CollideRequest::Obstacle& obstacle, Purse& purse) const HD_RT {
  if (held.shape.mesh->vertex_count > ToolPoints::kMost) return false;  // It may be none of them.
  const Pose X_BA = obstacle.X_WO.inverse() * held.X_WO;
  int side = 0;
  PointTouch at;
  constexpr double kHardly = 1e-3;  // Tilted by more, an edge beside the vertex may be deeper [rad].
  return lookAt(obstacle, X_BA * x, kReach, purse, side, at) == Looked::kNear &&
         isOutermost(x, held, X_BA.q.conjugate() * -at.out, kHardly - kTilted, purse);
}

bool SceneContacts::mayLean(std::uint32_t i, const CollideRequest::Held& held, std::uint32_t k, const Contact& contact,
                            Purse& purse) const HD_RT {
  const Vec3 n = held.X_WO.q.conjugate() * -contact.n_W;
  const double turns = closingOf(contact, held, k) / points_.extent();
  const double turn = contact.depth < 0 ? std::clamp(turns - kTilted, 0.0, kMostTilted - kTilted) : 0;
  return leansOut(held.shape, points_.at(i), n, turn) && isOutermost(points_.at(i), held, n, turn, purse);
}

bool SceneContacts::tryPoint(std::uint32_t i, const CollideRequest::Held& held, double margin, Purse& purse) HD_RT {
  const Vec3 middle_W = held.X_WO * points_.at(i);
  const bool disc = held.shape.kind == ShapeKind::kCylinder && ToolPoints::isDisc(i);
  bool hot = false, finished = true, unknown = false;
  Sided sided;
  float deepest = 0;
  for (std::uint32_t k = 0; k < held.count && finished; ++k) {
    const CollideRequest::Obstacle& obstacle = held.obstacle[k];
    if (!isFirm(obstacle.shape) || (whole_ >> k & 1) != 0) continue;
    finished = !purse.empty();
    if (!finished) break;
    PointTouch at;
    const double radius = disc ? held.shape.size.x() : points_.radius();
    const double reach = std::max(kReach, margin) + radius + static_cast<double>(depth_[i]);
    const Sided was = side_[i].slot == obstacle.slot ? side_[i] : Sided{};
    int side = was.side;
    Vec3 x_W = middle_W;
    const auto look = [&]() HD_RT {
      return disc ? lookFromDisc(i, held, obstacle, reach, purse, side, x_W, at)
                  : lookAt(obstacle, obstacle.X_WO.inverse() * x_W, reach, purse, side, at);
    };
    Looked looked = look();
    // A point that went around the border since the last question has changed sides, not gone through the sheet.
    if (looked == Looked::kNear && side != 0 && !was.in && at.gap < 0 &&
        hasGoneRound(points_.at(i), held, obstacle, at.out, purse)) {
      side = 0;
      looked = look();
    }
    unknown = unknown || looked == Looked::kUnknown;
    if (looked != Looked::kNear) continue;
    if (at.gap - radius > margin) continue;
    Contact contact;
    contact.n_W = obstacle.X_WO.q * at.out;
    contact.p_WB = obstacle.X_WO * at.surface;
    const bool on_mesh = held.shape.kind == ShapeKind::kSphere && at.triangle != HD_NO_INDEX;
    const std::uint32_t of_mesh = on_mesh ? ballFeature(at.triangle, side) : 0;
    contact.feature_a = of_mesh > 0 ? of_mesh : i;
    if (!(contact.n_W.squaredNorm() > 0.9) || !isFinite(x_W)) continue;
    hot = true;
    if (side != 0) sided = {obstacle.slot, side, at.gap < 0};
    deepest = std::max(deepest, static_cast<float>(-at.gap));
    tryFurtherWalls(i, k, held, at, side, margin, purse);
    if (!lowest(i, held, x_W, contact.n_W, contact.p_WA)) continue;
    contact.depth = contact.n_W.dot(contact.p_WB - contact.p_WA);
    if (disc && !isThere(contact, held, obstacle, reach, side, purse)) continue;
    if (contact.depth < -margin) continue;
    if (!disc && !mayLean(i, held, k, contact, purse)) continue;
    keep(contact, held, k);
    purse.report.touching += contact.depth >= 0 ? 1 : 0;
  }
  // A point's depth is kept until it is known to have left: the search reaches only as deep as it says.
  const bool known = finished && !unknown;
  hot_[i] = hot || (!known && hot_[i]);
  if (known || sided.side != 0) side_[i] = sided;
  depth_[i] = known ? deepest : std::max(deepest, depth_[i]);
  return known;
}

void SceneContacts::tryPoints(bool hot, std::uint32_t& cursor, Tries& tries, const CollideRequest::Held& held,
                              double margin, Purse& purse) HD_RT {
  const std::uint32_t n = points_.count();
  const std::uint32_t first = cursor % n;
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t i = (first + k) % n;
    if (tries.was_hot[i] != hot || tries.tried[i]) continue;
    tries.tried[i] = !purse.empty();
    tries.known[i] = tries.tried[i] && tryPoint(i, held, margin, purse);
    if (tries.known[i]) --purse.report.dropped;
    if (!purse.over) continue;
    cursor = i;
    return;
  }
}

void SceneContacts::find(const CollideRequest::Held& held, double ahead, const WorkBudget& budget, ContactModel& model,
                         DetectorReport& report) HD_RT {
  report = DetectorReport{};
  if (held.object != made_for_ || held.shape.kind != made_of_.kind || held.shape.size != made_of_.size ||
      held.shape.mesh != made_of_.mesh || held.shape.number != made_of_.number) {
    points_.make(held.shape);
    made_for_ = held.object;
    made_of_ = held.shape;
    room_ = held.shape.kind == ShapeKind::kBox ? kBoxRoom : kMaxContacts;
    model.count = 0;
    hot_.fill(false);
    depth_.fill(0);
    side_.fill({});
    cursor_ = hot_cursor_ = 0;
    last_count_ = 0;
    field_.reset();
  }
  for (std::uint32_t i = 0; held.put && i < std::min(ToolPoints::kFew, points_.count()); ++i) {
    depth_[points_.few(i)] = static_cast<float>(kPutDeep);
  }
  found_.count = 0;
  many_.fill(0);
  noteHeld(held, model);
  ahead_ = ahead;
  reach_ = ahead * held.speed;
  const double margin = kMargin + reach_;
  whole_ = cut_ = 0;
  forgetSides(held);
  const std::uint32_t first = firstOf(held);
  for (std::uint32_t i = 0; i < held.count; ++i) {
    const std::uint32_t k = (first + i) % held.count;
    if (tryVolume(k, held, ahead, budget, report)) whole_ |= 1u << k;
  }
  Purse most(budget, report), all(budget, report), last(budget, report);
  most.spare(3);
  all.spare(1);
  for (std::uint32_t k = 0; k < held.count; ++k) {
    if (tryRound(k, held, margin, most)) whole_ |= 1u << k;
    tryEdges(k, held, margin, most);
    tryMantle(k, held, margin, most);
  }
  const bool all_whole = whole_ == (std::uint64_t{1} << held.count) - 1;
  const std::uint32_t of_points = ~whole_ & ((1u << held.count) - 1);
  Tries tries;
  if (!all_whole && points_.count() > 0) {
    tries.was_hot = hot_;
    report.dropped += points_.count();
    tryPoints(true, hot_cursor_, tries, held, margin, most);
    for (std::uint32_t k = 0; k < held.count; ++k) tryRidges(k, held, most);
    tryPoints(false, cursor_, tries, held, margin, all);
    // What the others left is for those that touched. Edges and ridges are not tried again.
    tryPoints(true, hot_cursor_, tries, held, margin, all);
    report.exhausted = report.exhausted || most.over || all.over;
    if (most.over && all.over && isLate(budget)) cut_ |= of_points;
  }
  dropToldTwice(held);
  dropHidden(held, last);
  if (most.over) cut_ |= of_points;  // Not before: an edge for which there was no time hides seams as well.
  for (std::uint32_t k = 0; held.put && k < held.count; ++k) tryWayOut(k, held, last);
  carryOver(held, margin, model, tries);
  remember(held);

  std::array<ContactBody, CollideRequest::kMostObstacles> bodies;
  for (std::uint32_t k = 0; k < held.count; ++k) bodies[k] = {held.obstacle[k].slot, held.obstacle[k].X_WO};
  std::array<double, kMaxContacts> reach_of;
  for (std::uint32_t i = 0; i < found_.count; ++i) reach_of[i] = kept_[i].reach;
  model.build(found_, held.X_WO, {bodies.data(), held.count}, reach_, {body_of_.data(), found_.count},
              {reach_of.data(), found_.count}, kWayOut);
}

}  // namespace hapticd
