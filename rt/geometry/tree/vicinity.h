/** @file
 * The triangles about a place, gathered once and asked many times: a proxy stays for many ticks where it is.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rt/base/math.h"
#include "rt/geometry/tree/boxes.h"
#include "rt/geometry/tree/prisms.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/**
 * All triangles of one mesh that a ball touches which goes straight from one place to another, and some more. It does
 * not know when the mesh changes: its owner does. Filled at once or bit by bit; until it is full nothing may be asked
 * of it. Servo-safe.
 */
class Vicinity {
 public:
  /** Leaves of the tree, each of them eight triangles at most. */
  static constexpr std::uint32_t kMaxLeaves = 64;
  /** Nodes and triangles visited for one vicinity. */
  static constexpr std::uint32_t kMaxVisits = 2048;

  enum class State : std::uint8_t {
    kEmpty,  ///< Nothing was begun, or it did not fit: more than kMaxLeaves, or kMaxVisits were met.
    kFilling,
    kFull,
  };

  /**
   * Forgets what it holds; the triangles about a ball that goes from `from` to `to` are to be gathered next. Nothing if
   * radius <= 0.
   */
  void begin(const MeshView& mesh, const Vec3& from, const Vec3& to, double radius) HD_RT;
  /**
   * Looks into nodes of the tree until `visits` of nodes and triangles are reached; those of later calls are asked for
   * from memory meanwhile. `work` grows by what was visited. The mesh must be there as long as anything is asked.
   */
  State proceed(const MeshView& mesh, std::uint32_t visits, std::uint32_t& work) HD_RT;
  void clear() HD_RT {
    state_ = State::kEmpty;
    count_ = blocks_ = 0;
  }
  [[nodiscard]] State state() const HD_RT { return state_; }
  /** Triangles taken so far. */
  [[nodiscard]] std::uint32_t count() const HD_RT { return count_; }
  [[nodiscard]] const Vec3& center() const HD_RT { return center_; }
  [[nodiscard]] double radius() const HD_RT { return radius_; }
  /** Radius of the largest ball about x whose triangles are all here, with a hair to spare; negative if there is none.
   */
  [[nodiscard]] double room(const Vec3& x) const HD_RT {
    return state_ == State::kFull ? radius_ - kSlack * size_ - std::sqrt(squaredDistance(x)) : -1.0;
  }

  /** Whether room(x) is at least `reach`. */
  [[nodiscard, gnu::always_inline]] inline bool holds(const Vec3& x, double reach) const HD_RT {
    const double left = radius_ - kSlack * size_ - reach;
    return state_ == State::kFull && left >= 0 && squaredDistance(x) <= left * left;
  }

  /** Numbers of triangles, as reach() lists them. */
  struct Reached {
    std::uint32_t blocks;  ///< That were looked at.
    std::uint32_t count;
    std::uint32_t triangle[kMaxLeaves * kPrismWidth];
  };
  /**
   * Lists each triangle that a ball may meet whose centre goes from a to b, which must be in the vicinity, and few
   * others. Those behind which the centre stays by more than `behind` are left out. Eights are made of their triangles
   * when they are looked at first.
   */
  void reach(const Vec3& a, const Vec3& b, double radius, double behind, Reached& reached) HD_RT;

 private:
  /** Of the size: beyond what single precision makes of planes and points in it, and exact tests of a hit. */
  static constexpr double kSlack = 0x1p-15;

  static constexpr std::uint32_t kBlocks = kMaxLeaves;
  static_assert(kBlocks <= kPrismBlocks, "asked at once");
  static_assert(HD_BVH_LEAF_TRIANGLES <= kPrismWidth, "a leaf is a block");
  static constexpr std::uint32_t kMaxNodes = 768;

  /** The sweep as the blocks see it. */
  [[nodiscard]] PrismSweep rounded(const Vec3& a, const Vec3& b, double radius, double behind) const HD_RT;
  /** Of x from the way of the ball's centre. */
  [[nodiscard, gnu::always_inline]] inline double squaredDistance(const Vec3& x) const HD_RT {
    const Vec3 away = x - center_;
    const double along = std::clamp(inverse_half2_ * away.dot(half_), -1.0, 1.0);
    return (away - along * half_).squaredNorm();
  }
  bool look(const MeshView& mesh, std::uint32_t number) HD_RT;
  bool take(const hd_bvh_node& node, std::uint32_t leaf) HD_RT;
  void make(std::uint32_t number) HD_RT;
  void remake(PrismBlock& block, std::uint32_t triangle, std::uint32_t lane) const HD_RT;

  Vec3 center_ = Vec3::Zero();  ///< In single precision, exactly: differences with corners then round little.
  Vec3 half_ = Vec3::Zero();    ///< From the centre to the end of the ball's way,
  double inverse_half2_ = 0;    ///< its inverse square; 0 if there is no way.
  double radius_ = -1;
  double size_ = 0;          ///< Of a ball about all: the unit of the prisms,
  double inverse_size_ = 0;  ///< its inverse,
  PrismFrame frame_ = {};    ///< and both as they see them.
  BoxPoint way_ = {};        ///< Of the ball, as boxes see it.
  State state_ = State::kEmpty;
  std::uint32_t count_ = 0;
  std::uint32_t blocks_ = 0;  ///< One a leaf.
  std::uint32_t visited_ = 0;
  std::uint32_t first_ = 0, end_ = 0;  ///< Of the nodes not looked into yet.
  const MeshView* mesh_ = nullptr;
  std::uint64_t made_ = 0;  ///< Which blocks, by bit.
  std::uint32_t node_[kMaxNodes];
  PrismBoxes box_[kBlocks / kPrismWidth];  ///< About the blocks.
  PrismBlock block_[kBlocks];
};

}  // namespace hapticd
