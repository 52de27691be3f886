/** @file
 * Tight spheres of octree nodes (thesis section 3.2.4): the exact minimum enclosing ball of the occupied children, for
 * each of the 255 masks, from a table made at compile time. Servo-safe.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/math.h"

namespace hapticd {

/** A ball in units in which the node's half-side is 1, about the node's centre. */
struct TightSphere {
  float center[3];
  float radius;
};

namespace tight_sphere_internal {

/** In sixths of the half-side: every coordinate that matters is whole. */
struct Candidate {
  int x, y, z;
};

/** Squared distance from a candidate to the farthest corner of one child, which reaches from 0 to the node's corner. */
constexpr int farthest(unsigned child, const Candidate& c) {
  int sum = 0;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const int at = axis == 0 ? c.x : axis == 1 ? c.y : c.z;
    const int outer = (child >> axis & 1) != 0 ? 6 - at : -6 - at;
    sum += outer * outer > at * at ? outer * outer : at * at;
  }
  return sum;
}

constexpr double squareRoot(double x) {
  double r = x;
  for (int i = 0; i < 30; ++i) r = 0.5 * (r + x / r);
  return r;
}

/**
 * The ball's centre is the middle of an edge, of a diagonal or of a triangle of corners: by the node's symmetry it is
 * among the 27 points whose coordinates are 0 or +-1/2 and the 8 whose coordinates are +-1/3. A test compares with
 * the minimum over all pairs, triples and quadruples of corners.
 */
constexpr std::array<TightSphere, 256> make() {
  std::array<Candidate, 256> best{};
  std::array<int, 256> least{};
  const auto offer = [&](const Candidate& c) {
    int own[8] = {}, of[256] = {};
    for (unsigned child = 0; child < 8; ++child) own[child] = farthest(child, c);
    for (unsigned mask = 1; mask < 256; ++mask) {
      unsigned lowest = 0;
      while ((mask >> lowest & 1) == 0) ++lowest;
      const int rest = of[mask & (mask - 1)];
      of[mask] = rest > own[lowest] ? rest : own[lowest];
      if (least[mask] != 0 && of[mask] >= least[mask]) continue;
      least[mask] = of[mask];
      best[mask] = c;
    }
  };
  offer({0, 0, 0});
  for (int i = 0; i < 27; ++i) offer({3 * (i % 3 - 1), 3 * (i / 3 % 3 - 1), 3 * (i / 9 - 1)});
  for (int i = 0; i < 8; ++i) offer({(i & 1) != 0 ? 2 : -2, (i & 2) != 0 ? 2 : -2, (i & 4) != 0 ? 2 : -2});
  std::array<TightSphere, 256> table{};
  for (unsigned mask = 1; mask < 256; ++mask) {
    const Candidate& c = best[mask];
    table[mask] = {{static_cast<float>(c.x) / 6, static_cast<float>(c.y) / 6, static_cast<float>(c.z) / 6},
                   static_cast<float>(squareRoot(least[mask] / 36.0))};
  }
  return table;
}

inline constexpr std::array<TightSphere, 256> kTable = make();

}  // namespace tight_sphere_internal

/** Of a mask of children: bit x + 2 y + 4 z. Mask 0 has radius 0. */
[[nodiscard]] constexpr const TightSphere& tightSphere(std::uint8_t mask) HD_RT {
  return tight_sphere_internal::kTable[mask];
}

}  // namespace hapticd
