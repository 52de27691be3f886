#include "rt/render/proxy/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

constexpr std::uint32_t kFewTriangles = 24;   // Triangles: a vicinity of fewer is made larger,
constexpr std::uint32_t kManyTriangles = 48;  // and one of more is made smaller,
constexpr std::uint32_t kMostDeep =
    448;                                // Of more, those that the look for a nearer surface needs are left to the tree.
constexpr double kChange = 2;           // by this factor of its margin.
constexpr double kTicks = 1.2;          // Of the hand at its speed: a margin is this at least.
constexpr double kLong = 4.5;           // Margins: so far ahead of the hand,
constexpr double kBehind = 1;           // and so far behind it.
constexpr double kFirstMargin = 0.125;  // Of what is needed.
constexpr double kAheadOfHand = 1;      // Ticks that the proxy may go ahead of the hand.
constexpr double kAhead = 3;            // Ticks before a vicinity is left the next one is begun.
constexpr std::uint32_t kVisits = 64;   // For it in a tick.
constexpr std::uint32_t kAll = Vicinity::kMaxVisits;
constexpr std::uint32_t kRest = 32;  // Ticks.
constexpr double kShallower = 0.75, kDeeper = 1.05;

/** What must be kept, and what is kept with the look for a nearer surface. */
double needed(const ProxyPlace& place, bool nearest) HD_RT {
  const double depth = (place.hip - place.proxy).norm();
  return nearest ? std::max(depth, place.radius) : place.radius;
}

/** Whether it holds what is needed now, also if the proxy goes farther than is thought: a ball swings over a ridge. */
bool covers(const Vicinity& vicinity, const ProxyPlace& place, const Vec3& step, bool nearest) HD_RT {
  return (place.radius == 0 || vicinity.holds(place.end, place.radius)) &&
         vicinity.holds(place.proxy + kAheadOfHand * step, place.radius) &&
         (!nearest || vicinity.holds(place.hip, (place.hip - place.proxy).norm() - place.radius));
}

/** Whether it will still do so a little later; what lies deepest is left first. */
bool willCover(const Vicinity& vicinity, const ProxyPlace& place, const Vec3& step, bool nearest) HD_RT {
  const double deeper = nearest ? (place.hip - place.proxy).norm() - place.radius : 0.0;
  return deeper > place.radius ? vicinity.holds(place.hip + kAhead * step, deeper)
                               : vicinity.holds(place.proxy + (kAhead + kAheadOfHand) * step, place.radius);
}

ProxyPlace later(ProxyPlace place, const Vec3& way) HD_RT {
  place.proxy += way;
  place.end = place.proxy;
  place.hip += way;
  return place;
}

/** What must be kept lies in a ball about this point. */
Vec3 middle(const ProxyPlace& place, bool nearest, double depth) HD_RT {
  if (!nearest || !(depth > place.radius)) return place.proxy;
  return place.proxy + (1 - place.radius / depth) * (place.hip - place.proxy);
}

}  // namespace

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
  kept.rest = kept.wait = 0;
  kept.clear();
  return kept;
}

Vicinity* Surroundings::about(std::uint32_t slot, const Shape& shape, const ProxyPlace& place,
                              std::uint32_t& work) HD_RT {
  if (shape.kind != ShapeKind::kMesh || shape.mesh == nullptr || shape.number == 0) return nullptr;
  Kept& kept = keptFor(slot, shape, place.hip);
  const Vec3 step = kept.used + 1 == tick_ ? Vec3(place.hip - kept.hip) : Vec3::Zero();
  kept.used = tick_;
  kept.hip = place.hip;
  const MeshView& mesh = *shape.mesh;
  if (kept.moves != mesh.deform.moves) {
    kept.moves = mesh.deform.moves;
    kept.clear();
  }
  const bool nearest = (place.hip - place.proxy).norm() <= kept.deepest;
  Vicinity* now = &kept.vicinity[kept.now];
  Vicinity* next = &kept.vicinity[1 - kept.now];
  if (next->state() == Vicinity::State::kFilling && next->proceed(mesh, kVisits, work) == Vicinity::State::kEmpty) {
    kept.margin /= kChange;
    kept.wait = kRest;
  }
  if (!covers(*now, place, step, nearest)) {
    if (next->proceed(mesh, kAll, work) == Vicinity::State::kFull) {
      std::swap(now, next);
      kept.now = 1 - kept.now;
      next->clear();
      ++ahead_;
    }
    if (!covers(*now, place, step, nearest)) {
      if (kept.rest > 0) {
        --kept.rest;
        return nullptr;
      }
      gather(kept, mesh, place, step, work);
      return kept.vicinity[kept.now].state() == Vicinity::State::kFull ? &kept.vicinity[kept.now] : nullptr;
    }
  }
  if (kept.wait > 0) {
    --kept.wait;
  } else if (next->state() == Vicinity::State::kEmpty && !willCover(*now, place, step, nearest)) {
    gatherAhead(kept, mesh, place, step);
  }
  return now;
}

/** To how many triangles were kept until now. */
void Surroundings::adapt(Kept& kept, const ProxyPlace& place, bool& nearest) HD_RT {
  const double depth = (place.hip - place.proxy).norm();
  const Vicinity& now = kept.vicinity[kept.now];
  if (now.state() != Vicinity::State::kFull) return;
  if (now.count() <= kFewTriangles) kept.margin *= kChange;
  if (now.count() > kManyTriangles && kept.margin > kFirstMargin * needed(place, nearest)) kept.margin /= kChange;
  kept.deepest = nearest && now.count() > kMostDeep ? kShallower * depth : kDeeper * kept.deepest;
  nearest = depth <= kept.deepest;
}

/** Begins a vicinity for the place, along the way of the hand. */
void Surroundings::begin(Kept& kept, Vicinity& vicinity, const MeshView& mesh, const ProxyPlace& place,
                         const Vec3& step, bool nearest) HD_RT {
  const double depth = (place.hip - place.proxy).norm(), speed = step.norm();
  const double margin = kept.margin = std::max(kept.margin, kTicks * speed);
  const Vec3 ahead = speed > 0 ? Vec3(margin / speed * step) : Vec3(Vec3::Zero());
  const Vec3 from = middle(place, nearest, depth), to = from + (place.end - place.proxy);
  vicinity.begin(mesh, from - kBehind * ahead, to + kLong * ahead, needed(place, nearest) + margin);
}

/** Begins the vicinity that the hand will need when it leaves the present one. */
void Surroundings::gatherAhead(Kept& kept, const MeshView& mesh, const ProxyPlace& place, const Vec3& step) HD_RT {
  bool nearest = (place.hip - place.proxy).norm() <= kept.deepest;
  adapt(kept, place, nearest);
  begin(kept, kept.vicinity[1 - kept.now], mesh, later(place, kAhead * step), step, nearest);
}

/** Gathers now what is needed now. */
void Surroundings::gather(Kept& kept, const MeshView& mesh, const ProxyPlace& place, const Vec3& step,
                          std::uint32_t& work) HD_RT {
  const double depth = (place.hip - place.proxy).norm();
  Vicinity& vicinity = kept.vicinity[kept.now];
  kept.vicinity[1 - kept.now].clear();
  ++at_once_;
  bool nearest = depth <= kept.deepest;
  adapt(kept, place, nearest);
  if (kept.margin == 0) kept.margin = std::max(kFirstMargin * needed(place, nearest), kTicks * step.norm());
  for (int attempt = 0; attempt < 2; ++attempt) {
    begin(kept, vicinity, mesh, place, step, nearest);
    if (vicinity.proceed(mesh, kAll, work) == Vicinity::State::kFull) return;
    kept.margin /= kChange;
    if (nearest) kept.deepest = kShallower * depth;
    nearest = false;
  }
  kept.rest = kRest;
}

}  // namespace hapticd
