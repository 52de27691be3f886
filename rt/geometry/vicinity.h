/** @file
 * The triangles about a place, gathered once and asked many times: a proxy stays for many ticks where it is.
 */
#pragma once

#include <bit>
#include <cstdint>

#include "rt/base/math.h"
#include "rt/geometry/boxes.h"
#include "rt/geometry/prisms.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/** A ball to be filled. */
struct VicinityQuery {
  Vec3 center = Vec3::Zero();
  double radius = 0;        ///< [m]
  std::uint32_t work = 0;   ///< In and out: tree nodes and triangles visited.
  std::uint32_t limit = 0;  ///< Of `work`.
};

/**
 * All triangles of one mesh that touch a ball, and some more. It does not know when the mesh changes: its owner
 * does. Servo-safe.
 */
class Vicinity {
 public:
  static constexpr std::uint32_t kMaxTriangles = 512;

  /** False, and empty: there are more than kMaxTriangles, or the work limit was met. */
  bool fill(const MeshView& mesh, VicinityQuery& query) HD_RT;
  void clear() HD_RT {
    radius_ = -1;
    count_ = 0;
  }
  [[nodiscard]] std::uint32_t count() const HD_RT { return count_; }
  [[nodiscard]] const Vec3& center() const HD_RT { return center_; }
  [[nodiscard]] double radius() const HD_RT { return radius_; }
  /** Radius of the largest ball about x whose triangles are all here, with a hair to spare; negative if there is none.
   */
  [[nodiscard]] double room(const Vec3& x) const HD_RT {
    return radius_ > 0 ? (1 - kSlack) * radius_ - (x - center_).norm() : -1.0;
  }

  /**
   * Calls take(triangle) for each triangle that a ball may meet whose centre goes from a to b, which must be in the
   * vicinity, and for few others. Those that the centre stays behind are left out unless `behind` is asked for. The
   * number of eights looked at.
   */
  template <class Take>
  std::uint32_t reach(const Vec3& a, const Vec3& b, double radius, bool behind, Take&& take) const HD_RT {
    const PrismSweep sweep = rounded(a, b, radius, behind);
    const std::uint32_t blocks = (count_ + kPrismWidth - 1) / kPrismWidth;
    std::uint8_t mask[kMaxTriangles / kPrismWidth];
    boxTests().reach(block_, blocks, sweep, mask);
    for (std::uint32_t k = 0; k < blocks; ++k) {
      for (std::uint32_t bits = mask[k]; bits != 0; bits &= bits - 1) take(block_[k].triangle[std::countr_zero(bits)]);
    }
    return blocks;
  }

 private:
  /** Of the radius: beyond what single precision makes of planes and points in the ball, and exact tests of a hit. */
  static constexpr double kSlack = 0x1p-15;

  [[nodiscard]] PrismSweep rounded(const Vec3& a, const Vec3& b, double radius, bool behind) const HD_RT;
  void make(const MeshView& mesh) HD_RT;
  void remake(const MeshView& mesh, PrismBlock& block, std::uint32_t lane) const HD_RT;

  Vec3 center_ = Vec3::Zero();  ///< In single precision, exactly: differences with corners then round little.
  float origin_[3] = {};        ///< The same.
  double radius_ = -1;
  std::uint32_t count_ = 0;
  PrismBlock block_[kMaxTriangles / kPrismWidth];
};

}  // namespace hapticd
