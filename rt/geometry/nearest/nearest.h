/** @file
 * The point of a shape's surface nearest to a point. All in the shape's frame. Servo-safe; the work is bounded by the
 * caller.
 */
#pragma once

#include <cstdint>
#include <limits>

#include "rt/base/math.h"
#include "rt/geometry/feature.h"
#include "rt/scene/scene.h"

namespace hapticd {

class Vicinity;

/** What is asked. */
struct NearestQuery {
  Vec3 x = Vec3::Zero();
  double reach = std::numeric_limits<double>::infinity();  ///< Only what is nearer than this [m].
  /** With `turned`: only surface whose outward normal n has n . axis > cosine. Axis unit. */
  bool turned = false;
  Vec3 axis = Vec3::Zero();
  double cosine = 0;
  /** Of a mesh, with `way_count`: only points than which none beside them is nearer, from where the way to x leads
   * elsewhere than these, unit: its cosine with each is less than `cosine`. */
  const Vec3* ways = nullptr;
  std::uint32_t way_count = 0;
  Vicinity* vicinity = nullptr;  ///< As in Sweep.
  std::uint32_t work = 0;        ///< In and out: tree nodes and triangles visited, primitives too.
  std::uint32_t limit = 0;       ///< Of `work`.
  bool nearly = false;           ///< Where the limit is met, the nearest of what was visited will do.
};

/** Where. */
struct Nearest {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();         ///< Outward, unit; of the face the point was found on.
  Vec3 pseudo_normal = Vec3::Zero();  ///< Outward, unit; of the feature: see pseudoNormal(). Tells the side.
  double squared_distance = 0;        ///< [m^2]
  std::uint32_t feature = 0;          ///< Triangle, or face of the primitive as in SweepHit.
  FeatureKind kind = FeatureKind::kFace;
  std::uint32_t corner = 0;  ///< Of a triangle: which edge (01, 12, 20) or vertex, if it is one.

  /** Whether x, whose nearest point without `turned` this is, is inside. True of closed meshes and of primitives. */
  [[nodiscard]] bool isInside(const Vec3& x) const HD_RT { return (x - point).dot(pseudo_normal) < 0; }
};

enum class NearestResult : std::uint8_t { kNone, kFound, kExhausted };

/**
 * The surface point nearest to x, from inside too. Where several are (x in a sphere's centre), one of them, the same
 * each time (the triangle of the lowest number). A curved surface is turned as its nearest point is: no other point of
 * it is looked for. kNone: nothing in reach, `nearest` untouched, as with kExhausted: the work limit was met, nothing
 * is known; with `nearly`: nothing in reach has been found until then.
 */
[[nodiscard]] NearestResult nearestOnShape(const Shape& shape, NearestQuery& query, Nearest& nearest) HD_RT;
[[nodiscard]] NearestResult nearestOnMesh(const MeshView& mesh, NearestQuery& query, Nearest& nearest) HD_RT;

}  // namespace hapticd
