// A body that was put into something, or about which something has come to be, is led out of it.
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "rt/collide/feature.h"
#include "rt/cycle/free_bodies.h"
#include "rt/cycle/obstacles.h"

namespace hapticd {
namespace {

constexpr double kLeastLead = 1e-5;  ///< What would be led more slowly is out [m/s].
constexpr double kOnward = 0.5;      ///< Cosine of ways that lead the same way.
constexpr double kAgainst = 0.3;     ///< Of a way: it goes so much against what it must not press.

}  // namespace

/** It may have been put into something, whichever way it was led out of another. */
void FreeBodies::leadAnew(Entry& entry) HD_RT {
  entry.leading = kLeadOut;
  entry.way.setZero();
  entry.led = false;
  entry.missed = 0;
  entry.missed_in = 0;
}

/** An answer may have had no time for what the body is in, or have found no point in there. */
bool FreeBodies::isOut(Entry& entry) HD_RT {
  if (entry.asked != entry.missed_in) ++entry.missed;
  entry.missed_in = entry.asked;
  return entry.missed > kMostMissed;
}

/** What body k touches as it knows itself, and what other bodies know of it: either finds the other. */
void FreeBodies::findNear(const Scene& scene, std::uint8_t k, Near& near) const HD_RT {
  const auto add = [&](const Touch& touch, std::uint32_t slot, std::uint32_t part, std::uint32_t my_part, bool moves,
                       bool mine, Knows knows) HD_RT {
    near.touch[near.count] = touch;
    near.parts[near.count] = part << 8 | my_part;
    near.knows[near.count] = knows;
    near.mine[near.count] = mine;
    near.slot[near.count] = slot;
    near.moves[near.count++] = moves;
  };
  const auto isMesh = [&](std::uint32_t slot) HD_RT { return scene.slot(slot).shape.kind == ShapeKind::kMesh; };
  const auto knows = [&](const Entry& finder, std::uint32_t i) HD_RT {
    const ContactModel::Point& point = finder.model.point[i];
    if (point.feature() != kWayOut) return Knows::kPoint;
    return isMesh(objectSlot(finder.object)) || isMesh(point.body()) ? Knows::kBox : Knows::kWhole;
  };
  for (std::uint32_t i = 0; i < entry_[k].model.count && near.count < Near::kMost; ++i) {
    const std::uint32_t slot = entry_[k].model.point[i].body();
    if (!meets(scene, k, i)) continue;
    const std::uint8_t other = find(slot);
    Touch touch = touchOf(scene, k, i);
    touch.r_b -= touch.gap * touch.n;  // On the other: both were of this body's point.
    add(touch, other != kNone ? objectSlot(entry_[other].object) : slot, slot, objectSlot(entry_[k].object),
        other != kNone, false, knows(entry_[k], i));
  }
  for (std::uint8_t other = 0; other < kMaxBodies; ++other) {
    const Entry& its = entry_[other];
    if (other == k || its.object == 0 || its.held) continue;
    for (std::uint32_t i = 0; i < its.model.count && near.count < Near::kMost; ++i) {
      const std::uint32_t slot = its.model.point[i].body();
      if (find(slot) != k || !meets(scene, other, i)) continue;
      Touch touch = touchOf(scene, other, i);
      std::swap(touch.r_a, touch.r_b);
      touch.n = -touch.n;
      touch.r_a += touch.gap * touch.n;  // On this body: both were of the other's point.
      add(touch, objectSlot(its.object), objectSlot(its.object), slot, true, true, knows(its, i));
    }
  }
}

/**
 * The least way out of each thing that it overlaps: along one of the planes that it touches it by, until no point that
 * is known to be in there is below that plane; where all of both is known, by that alone, and of a mesh's box as `most`
 * says. Parts of bodies meet by twos, each pair for itself. Of several the one that takes the longest, and once it goes
 * one way none that leads back.
 */
FreeBodies::Way FreeBodies::findWayOut(const Entry& entry, const Near& near, double dt, Knows most, Touch& out,
                                       std::uint32_t& of) HD_RT {
  const bool begun = !entry.way.isZero(0);
  // Load presses bodies into each other, too, in the first ticks of a pile.
  const auto overlaps = [&](std::uint32_t i) HD_RT {
    return -near.touch[i].gap > (near.moves[i] && !begun ? kTouching : Tool::kSlop + Tool::kRecoverTime * kLeastLead);
  };
  // Below a plane of the other lie points of this body, below one of its own those of the other.
  const auto below = [&](std::uint32_t plane, std::uint32_t point) HD_RT {
    const Touch &of = near.touch[plane], &at = near.touch[point];
    return -of.gap + (near.mine[plane] ? of.n.dot(at.r_b - of.r_b) : of.n.dot(of.r_a - at.r_a));
  };
  const auto wayAlong = [&](std::uint32_t i) HD_RT {
    double way = -near.touch[i].gap;
    for (std::uint32_t j = 0; j < near.count; ++j) {
      const bool in_there = near.knows[j] == Knows::kPoint && near.parts[j] == near.parts[i] && near.touch[j].gap < 0;
      if (in_there) way = std::max(way, below(i, j));
    }
    return way;
  };
  // Of what is known as a whole points tell nothing more: those of what is round look all about.
  std::array<bool, Near::kMost> counts;
  for (std::uint32_t i = 0; i < near.count; ++i) {
    Knows best = Knows::kPoint;
    for (std::uint32_t j = 0; j < near.count; ++j) {
      if (near.parts[j] == near.parts[i] && near.knows[j] <= most) best = std::max(best, near.knows[j]);
    }
    counts[i] = near.knows[i] == best;
  }
  struct Best {
    std::uint32_t plane = Near::kMost;
    double way = std::numeric_limits<double>::infinity();
    bool onward = false;
  };
  std::array<Best, Near::kMost> best;  // Of each pair of parts, by its first touch.
  for (std::uint32_t i = 0; i < near.count; ++i) {
    if (!overlaps(i) || !counts[i]) continue;
    const auto first = near.parts.begin();
    const auto its = static_cast<std::size_t>(std::find(first, first + i, near.parts[i]) - first);
    const Best now{i, wayAlong(i), begun && near.touch[i].n.dot(entry.way) > kOnward};
    if (now.onward > best[its].onward || (now.onward == best[its].onward && now.way < best[its].way)) best[its] = now;
  }
  // Of the parts of one body those first that lead on: what leads back would lead into these again.
  const auto leadsBack = [&](std::uint32_t i)
                             HD_RT { return begun && near.touch[best[i].plane].n.dot(entry.way) < -kOnward; };
  for (std::uint32_t i = 0; i < near.count; ++i) {
    if (best[i].plane == Near::kMost || leadsBack(i)) continue;
    for (std::uint32_t j = 0; j < near.count; ++j) {
      const bool leads = best[j].plane != Near::kMost && near.slot[j] == near.slot[i];
      if (leads && leadsBack(j)) best[j].plane = Near::kMost;
    }
  }
  std::uint32_t chosen = near.count;
  double longest = 0;
  for (std::uint32_t i = 0; i < near.count; ++i) {
    if (best[i].plane == Near::kMost || !(best[i].way > longest)) continue;
    longest = best[i].way;
    chosen = best[i].plane;
  }
  if (chosen == near.count) return Way::kNone;
  out = near.touch[chosen];
  of = near.slot[chosen];
  Way way = begun && out.n.dot(entry.way) < -kOnward ? Way::kBarred : Way::kOut;
  // Of two that are led, both may come nearer in a tick.
  const double next = kTouching + 2 * dt * Tool::kRecoverSpeed;
  for (std::uint32_t j = 0; j < near.count; ++j) {
    if (!counts[j]) continue;
    const Touch& touch = near.touch[j];
    const bool whole = near.knows[chosen] > Knows::kPoint, same = near.parts[j] == near.parts[chosen];
    const bool behind = near.slot[j] == near.slot[chosen] && (whole || (same && below(chosen, j) >= 0));
    const double from = near.moves[j] ? next : kTouching;
    if (behind || !(touch.gap < from && touch.n.dot(out.n) < -kAgainst)) continue;
    if (near.slot[j] != near.slot[chosen]) return Way::kWaits;
    way = Way::kBarred;
  }
  out.gap = -longest;
  return way;
}

/** Of two that were led the same way both would go on so, in each other: the one in the lower slot goes. */
bool FreeBodies::goesAhead(std::uint8_t other, std::uint8_t k, const Vec3& n) const HD_RT {
  if (other == kNone || !(objectSlot(entry_[other].object) < objectSlot(entry_[k].object))) return false;
  return entry_[other].led && entry_[other].way.dot(n) > kOnward;
}

/**
 * Nothing that happens to a body gives the energy to lift it out of what it was put into, or what came to be about
 * it. Whoever did that is taken to go on until it is out: the least way, as slowly as tools leave an overlap, and with
 * no motion left to it. Not while a hand or tool touches it, nor against other bodies: it would push them. It waits
 * for these; as long as they like for hands and tools, if it stays in there.
 */
void FreeBodies::leadOut(const Scene& scene, std::uint8_t k, double dt) HD_RT {
  Entry& entry = entry_[k];
  if (!entry.pushed) entry.leading -= dt;
  Near near;
  findNear(scene, k, near);
  Touch overlap;
  std::uint32_t of = 0;
  Way way = findWayOut(entry, near, dt, Knows::kWhole, overlap, of);
  const auto known_to = near.knows.begin() + near.count;
  const bool box = std::find(near.knows.begin(), known_to, Knows::kBox) != known_to;
  if ((way == Way::kNone || way == Way::kBarred) && box) way = findWayOut(entry, near, dt, Knows::kBox, overlap, of);
  if (way == Way::kBarred && box) entry.way.setZero();
  if (way == Way::kOut && goesAhead(find(of), k, overlap.n)) way = Way::kWaits;
  entry.led = way == Way::kOut && !entry.pushed;
  if (way != Way::kNone) {
    entry.missed = 0;
  } else if (isOut(entry)) {
    entry.leading = 0;
    entry.way.setZero();
    entry.missed = 0;
  }
  if (way != Way::kOut || entry.pushed) return;
  settleTouches({&overlap, 1}, dt);
  entry.way = overlap.n;
  RigidBody& body = entry.body.body;
  const Twist V = body.twist();
  Pose X = body.pose();
  X.p += dt * overlap.separate * entry.way;
  body.place(X);
  body.setTwist(V);
  entry.body.wake();
}

bool FreeBodies::mayLead(const Scene& scene, Entry& entry) HD_RT {
  const auto isUnmet = [&](std::uint32_t slot) HD_RT { return scene.sinceUnmet(slot) < kStale; };
  bool unmet = isUnmet(objectSlot(entry.object));
  for (std::uint32_t i = 0; i < entry.model.count && !unmet; ++i) unmet = isUnmet(entry.model.point[i].body());
  if (unmet && !(entry.leading > 0)) entry.way.setZero();  // That of another time.
  if (unmet) entry.leading = kLeadOut;
  return entry.leading > 0 && !(entry.asked < entry.arrived) && entry.age < kStale;
}

/** In turns: of more than kMostLooks each goes the slower, and has the longer for it. */
void FreeBodies::leadAllOut(const Scene& scene, double dt) HD_RT {
  looks_ = 0;
  const std::uint8_t first = next_look_;
  for (std::uint8_t i = 0; i < kMaxBodies; ++i) {
    const auto k = static_cast<std::uint8_t>((first + i) % kMaxBodies);
    Entry& entry = entry_[k];
    if (entry.object == 0 || entry.held || !mayLead(scene, entry)) {
      entry.led = false;
      continue;
    }
    if (looks_ == kMostLooks) continue;
    ++looks_;
    leadOut(scene, k, dt);
    next_look_ = static_cast<std::uint8_t>((k + 1) % kMaxBodies);
  }
}

}  // namespace hapticd
