#include "rt/render/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

constexpr std::uint32_t kFew = 16;   // Triangles: a vicinity of fewer is made larger,
constexpr std::uint32_t kMany = 32;  // and one of more is made smaller,
constexpr std::uint32_t kMostDeep =
    192;                                // Of more, those that the look for a nearer surface needs are left to the tree.
constexpr double kChange = 2;           // by this factor of its margin.
constexpr double kTicks = 3;            // That a margin lasts at least, at the speed of the hand.
constexpr double kLead = 0.75;          // Of the margin: so far ahead of the hand.
constexpr double kFirstMargin = 0.125;  // Of what is needed.
constexpr std::uint32_t kMaxGather = 2048;  // Nodes and triangles visited for one vicinity.
constexpr std::uint32_t kRest = 32;         // Ticks.
constexpr double kShallower = 0.75, kDeeper = 1.05;

/** What must be kept, and what is kept with the look for a nearer surface. */
double needed(const ProxyPlace& place, bool nearest) HD_RT {
  const double depth = (place.hip - place.proxy).norm();
  return nearest ? std::max(depth, place.radius) : place.radius;
}

bool covers(const Vicinity& vicinity, const ProxyPlace& place, const Vec3& step, bool nearest) HD_RT {
  if (vicinity.room(place.proxy) < place.radius || vicinity.room(place.proxy + step) < place.radius) return false;
  return !nearest || vicinity.room(place.hip) >= (place.hip - place.proxy).norm() - place.radius;
}

}  // namespace

void Surroundings::clear() HD_RT {
  for (Kept& kept : kept_) kept.number = 0;
}

/** The entry of that object, or the one not used for longest, made new. */
Surroundings::Kept& Surroundings::keptFor(std::uint32_t slot, const Shape& shape, const Vec3& hip) HD_RT {
  Kept* oldest = &kept_[0];
  for (Kept& kept : kept_) {
    if (kept.number == shape.number && kept.slot == slot) return kept;
    if (kept.number == 0 || kept.used < oldest->used) oldest = &kept;
  }
  Kept& kept = *oldest;
  kept.slot = slot;
  kept.number = shape.number;
  kept.moves = shape.mesh->deform.moves;
  kept.hip = hip;
  kept.margin = 0;
  kept.deepest = std::numeric_limits<double>::infinity();
  kept.rest = 0;
  kept.vicinity.clear();
  return kept;
}

const Vicinity* Surroundings::about(std::uint32_t slot, const Shape& shape, const ProxyPlace& place,
                                    std::uint32_t& work) HD_RT {
  if (shape.kind != ShapeKind::kMesh || shape.mesh == nullptr || shape.number == 0) return nullptr;
  Kept& kept = keptFor(slot, shape, place.hip);
  kept.used = ++clock_;
  const Vec3 step = place.hip - kept.hip;
  kept.hip = place.hip;
  if (kept.moves != shape.mesh->deform.moves) {
    kept.moves = shape.mesh->deform.moves;
    kept.vicinity.clear();
  }
  const bool nearest = (place.hip - place.proxy).norm() <= kept.deepest;
  if (covers(kept.vicinity, place, step, nearest)) return &kept.vicinity;
  if (kept.rest > 0) {
    --kept.rest;
    return nullptr;
  }
  gather(kept, *shape.mesh, place, step, work);
  return kept.vicinity.count() > 0 || kept.vicinity.radius() > 0 ? &kept.vicinity : nullptr;
}

void Surroundings::gather(Kept& kept, const MeshView& mesh, const ProxyPlace& place, const Vec3& step,
                          std::uint32_t& work) HD_RT {
  const double depth = (place.hip - place.proxy).norm(), speed = step.norm();
  kept.deepest *= kDeeper;
  bool nearest = depth <= kept.deepest;
  if (kept.margin == 0) kept.margin = std::max(kFirstMargin * needed(place, nearest), kTicks * speed);
  for (int attempt = 0; attempt < 2; ++attempt) {
    const double need = needed(place, nearest), margin = std::max(kept.margin, kTicks * speed);
    VicinityQuery query;
    query.center = place.proxy;
    if (nearest && depth > place.radius) query.center += (1 - place.radius / depth) * (place.hip - place.proxy);
    if (speed > 0) query.center += std::min(kLead * margin / speed, kTicks) * step;
    query.radius = need + margin;
    query.limit = kMaxGather;
    const bool fits = kept.vicinity.fill(mesh, query);
    work += query.work;
    if (nearest && kept.vicinity.count() > kMostDeep) kept.deepest = kShallower * depth;
    if (fits) {
      if (kept.vicinity.count() <= kFew) kept.margin = kChange * margin;
      if (kept.vicinity.count() > kMany) kept.margin /= kChange;
      return;
    }
    kept.margin /= kChange;
    if (nearest) kept.deepest = kShallower * depth;
    nearest = false;
  }
  kept.rest = kRest;
}

}  // namespace hapticd
