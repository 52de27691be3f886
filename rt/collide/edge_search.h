/** @file
 * Where an edge of the scene touches a tool.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rt/base/math.h"
#include "rt/body/contact_model.h"
#include "rt/collide/line_search.h"
#include "rt/collide/scene_contacts.h"

namespace hapticd {

// What tells whether a normal belongs to an edge, of a box as of a mesh.
inline constexpr double kAside = 0.1;       ///< Sine of the angle by which it may look into a face of the edge,
inline constexpr double kAlong = 0.3;       ///< and along it: farther on it is nearer.
inline constexpr double kOffMantle = 1e-3;  ///< Cosine of a cylinder's axis with a normal that is none of its mantle.
/** How far within an edge the tool is asked for, at most a quarter of what the edge is of [m]. */
inline constexpr double kInset = 2e-4;

inline constexpr double kOnBorder = 1e-6;  ///< Of a shape: a tool's points are floats.

/** Whether x, on a box's surface, is so on axis i. */
[[nodiscard]] inline bool isAtBorder(const Shape& box, const Vec3& x, int i) HD_RT {
  return box.size[i] - std::abs(x[i]) <= kOnBorder * box.size[i];
}

/** Whether what touches a box or cylinder at x, on its surface, along n may lean there: n is outward on all faces that
 * meet there, and hardly looks along them, or will be when it has turned so far [rad]. True of every other shape. */
[[nodiscard]] bool leansOut(const Shape& shape, const Vec3& x, const Vec3& n, double turn = 0) HD_RT;

/** Whether a touch of a cylinder or capsule along n, in its frame, is its mantle's: not an end's, nor a rim's. */
[[nodiscard]] inline bool isOnMantle(const Shape& shape, const Vec3& point, const Vec3& n) HD_RT {
  if (std::abs(point.z()) < shape.size.y()) return true;
  return shape.kind == ShapeKind::kCylinder && !(std::abs(n.z()) > kOffMantle);
}

inline constexpr double kAslant = 1e-4;  ///< By so much the gap may at least grow along what lies along [m].
inline constexpr double kToSide = 2e-5;  ///< Of a place on an edge [m].
inline constexpr double kSlanted = 0.3;  ///< Length of a sum of normals below which the faces are those of a plate.

/** How two edges lie that cross deep in each other. */
struct Crossing {
  Vec3 n_A = Vec3::Zero();  ///< Across both.
  double gap = 0;           ///< Along it [m].
  bool found = false;
};

/**
 * Of an edge of B in A, at x, where A's nearest faces look along it: the normal that is of those of A's faces to both
 * sides, so across A's edge between them, and across B's. `look(shift, n_A, p_A)` tells of the place so far aside along
 * the edge [m] the gap, and the nearest point of A and its normal. In A's frame; `along` is unit.
 */
template <class Look>
Crossing crossingAt(const Vec3& x, const Vec3& along, const Look& look) HD_RT {
  Crossing crossing;
  Vec3 n[2], p[2];
  for (const int side : {0, 1}) {
    if (!(look(side == 0 ? -kToSide : kToSide, n[side], p[side]) < 0)) return crossing;
  }
  const double slope = n[0].dot(along), other = n[1].dot(along);
  if (!(slope * other < 0)) return crossing;
  const double weight = std::abs(slope / other);
  const Vec3 sum = n[0] + weight * n[1];
  const double norm = sum.norm();
  if (!(norm > kSlanted)) return crossing;
  crossing.n_A = sum / norm;
  crossing.gap = (n[0].dot(p[0] - x) + weight * n[1].dot(p[1] - x)) / norm;
  crossing.found = true;
  return crossing;
}

/** The nearest place about t, as seen from a little farther within the edge. */
template <class Gap>
double nearestBeside(double t, double length, const Gap& gapAt) HD_RT {
  const double beside = kInset / length;
  return leastOf(std::max(0.0, t - beside), std::min(1.0, t + beside), gapAt);
}

/** Into how many parts an edge goes that are asked one by one: to a convex tool it has one nearest place only. */
[[nodiscard]] inline std::uint32_t partsFor(const ToolPoints& tool, double length) HD_RT {
  constexpr double kPart = 1.0 / 4;  // Of the tool.
  constexpr double kMost = 64;
  return tool.isConvex()
             ? 1
             : static_cast<std::uint32_t>(std::clamp(std::ceil(length / (kPart * tool.reach())), 1.0, kMost));
}

/** Places on an edge, as parts of its way. */
struct EdgeSpan {
  /** The nearest, and both ends of what touches, which hold the rotation of what lies along. */
  double place[3] = {};
  double least = INFINITY;  ///< Gap at the nearest [m].
  bool near = false;

  /** Whether place j is there, and none before it. */
  [[nodiscard]] bool has(int j) const HD_RT { return near && (j == 0 || place[j] != place[0]); }
};

/**
 * Of an edge of that length where gapAt(t), for t from 0 to 1, is at most `margin`; normalOf(gap) is the normal where
 * it was asked last, and `within` leads from the edge to where it is asked, in the frame of the normals. The gap
 * changes by no more than the way along the edge. The ends are those of what lies along the tool though aslant, by up
 * to `aslant` or within it: held at its nearest place alone it would sink in at the other end. Farther on another face
 * of the tool is nearest. Some 10 gaps where the tool lies flat along it, else 90 at most.
 */
template <class Gap, class Normal>
EdgeSpan touchingSpan(double margin, double aslant, double length, const Vec3& within, const Gap& gapAt,
                      const Normal& normalOf) HD_RT {
  constexpr int kTries = 4;       // Parts of the edge, from which the nearest place is looked for.
  constexpr double kStep = 1e-3;  // Of the edge,
  constexpr double kFlat = 1e-9;  // and by how much a gap grows there that does not [m].
  constexpr double kPart = 1.0 / kTries;
  EdgeSpan span;
  if (!(gapAt(0.5) <= margin + 0.5 * length)) return span;
  double best = 0;
  for (int j = 0; j <= kTries; ++j) {
    const double t = kPart * j, gap = gapAt(t);
    if (!(gap < span.least)) continue;
    span.least = gap;
    best = t;
  }
  if (!(span.least <= margin + 0.5 * length * kPart)) return span;
  // At an end, or where the tool lies flat along it, nothing is nearer between two places.
  const double before = best > 0 ? gapAt(best - kStep) : INFINITY, behind = best < 1 ? gapAt(best + kStep) : INFINITY;
  if (std::min(before, behind) < span.least ||
      (best > 0 && best < 1 && std::max(before, behind) > span.least + kFlat)) {
    const double near = leastOf(std::max(0.0, best - kPart), std::min(1.0, best + kPart), gapAt);
    const double there = gapAt(near);
    if (there < span.least) {
      best = near;
      span.least = there;
    }
  }
  const Vec3 n = normalOf(gapAt(best));
  const double flat = span.least + ContactModel::kLeastReach;
  const auto isAlike = [&](double gap) HD_RT { return normalOf(gap).dot(n) > SceneContacts::kSameWay; };
  const auto alike = [&](double t) HD_RT {
    const double gap = gapAt(t);
    return isAlike(gap) ? gap : static_cast<double>(INFINITY);
  };
  const auto flatOrAlike = [&](double t) HD_RT {
    const double gap = gapAt(t);
    return gap <= flat || isAlike(gap) ? gap : static_cast<double>(INFINITY);
  };
  const double touching = std::max(0.0, -n.dot(within));  // The edge itself is so much nearer.
  const double most = std::max(touching, span.least + aslant);
  span.near = true;
  span.place[0] = best;
  for (const int end : {0, 1}) {
    const double t = lastOf(best, end, most, flatOrAlike);
    // Hardly beyond the tool's own edge, where no normal is one of what the edge lies on.
    const bool beyond = t != end && !isAlike(gapAt(t));
    const double place = beyond ? lastOf(best, t, most, alike) : t;
    // Where edges cross it is the same place, its normal a little turned.
    span.place[1 + end] = std::abs(place - best) * length < kInset ? best : place;
  }
  return span;
}

}  // namespace hapticd
