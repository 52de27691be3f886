/** @file
 * Many boxes at once: the eight children of a tree node against a sweep or a point, in single precision, rounded so
 * that no box is missed. Only the exact tests of the triangles decide anything.
 *
 * There are several implementations, chosen once for the processor. All compute the same values in the same order, so
 * they give the same bits and the same walk. This header is included by files compiled for wider instructions: it must
 * stay free of inline code, for the linker might take it from there for everyone.
 */
#pragma once

#include <cstdint>

#include "proto/snapshot.h"
#include "rt/geometry/tree/prisms.h"

namespace hapticd {

/** A sweep as boxes see it. Per axis: where it comes from, widened against the box's face of entry and of exit. */
struct BoxSweep {
  float entry[3];
  float exit[3];
  float inverse[3];         ///< Of the direction; finite.
  std::uint32_t upward[3];  ///< 1: it goes up this axis and enters through the lower face.
};

/** A point as boxes see it: widened to a small box. */
struct BoxPoint {
  float lower[3];
  float upper[3];
};

/** What a vector unit does. Servo-safe. */
struct BoxTests {
  /** Bit i: the sweep may enter child i before t_max, at key[i] or later. */
  std::uint32_t (*enter)(const hd_bvh_node& node, const BoxSweep& sweep, float t_max, float* key) noexcept;
  /** Bit i: child i may come within the root of `squared_reach`; key[i] is the squared distance or less. */
  std::uint32_t (*approach)(const hd_bvh_node& node, const BoxPoint& point, float squared_reach, float* key) noexcept;
  NearPrisms near;    ///< The blocks of a vicinity,
  ReachPrisms reach;  ///< their triangles,
  MakePrisms make;    ///< and how they are made.
};

extern const BoxTests kPortableBoxTests;
extern const BoxTests kAvx2BoxTests;  ///< Only on x86-64.

enum class VectorPath : std::uint8_t { kPortable, kAvx2 };

/** The best the processor has, unless chosen otherwise. Servo-safe. */
[[nodiscard]] const BoxTests& boxTests() noexcept;
[[nodiscard]] VectorPath vectorPath() noexcept;
/** For tests and benchmarks, before threads start. False: the processor cannot. */
bool choosePath(VectorPath path) noexcept;
[[nodiscard]] const char* nameOf(VectorPath path) noexcept;

}  // namespace hapticd
