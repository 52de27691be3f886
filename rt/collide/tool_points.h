/** @file
 * The surface of a tool as points, or balls of one radius: what is tried against the scene's shapes.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "rt/scene/scene.h"

namespace hapticd {

/** Made by the collide thread when it first sees a tool; allocates nothing. */
class ToolPoints {
 public:
  static constexpr std::uint32_t kMost = 2048, kFew = 8;

  /** A sphere is one ball, a capsule a row of them; boxes and cylinders are sampled, and of a
   * cylinder's mantle there are discs; of a mesh, vertices evenly taken.
   * Planes and groups have none. */
  void make(const Shape& shape) HD_RT;

  [[nodiscard]] std::uint32_t count() const HD_RT { return count_; }
  [[nodiscard]] Vec3 at(std::uint32_t i) const HD_RT { return {p_[i][0], p_[i][1], p_[i][2]}; }
  [[nodiscard]] double radius() const HD_RT { return radius_; }  ///< Of each ball [m].
  /** Number of one of kFew, or of all, that lie all about the tool; of a box they are its corners. */
  [[nodiscard]] std::uint32_t few(std::uint32_t i) const HD_RT {
    return corners_first_ || count_ <= kFew ? i : i * (count_ - 1) / (kFew - 1);
  }
  /** Where on its axis a capsule half as long as that has ball i; a sphere's one, of half 0, is in the middle [m]. */
  [[nodiscard]] static double alongAxis(std::uint32_t i, double half) HD_RT;
  /** Of a cylinder: whether that is no point but a disc of its mantle, at() its middle. */
  [[nodiscard]] static bool isDisc(std::uint32_t i) HD_RT { return i >= kFirstDisc && i < kFirstDisc + kRings; }
  /** Half the way from disc to disc of a cylinder half as long as that [m]. */
  [[nodiscard]] static double apart(double half) HD_RT { return half / (kRings - 1); }
  /** Of a ball about the surface: the origin, or of the box about it where that ball is smaller, for the origin may be
   * anywhere. */
  [[nodiscard]] Vec3 middle() const HD_RT {
    return extent() < reach_ ? Vec3(0.5 * (low_ + high_)) : Vec3(Vec3::Zero());
  }
  [[nodiscard]] double reach() const HD_RT { return std::min(reach_, extent()); }  ///< Farthest surface from there [m].
  /** Half the diagonal of the box about the surface, wherever the origin is [m]. */
  [[nodiscard]] double extent() const HD_RT { return 0.5 * (high_ - low_).norm() + radius_; }
  /** Whether no part of the surface is beyond a tangent plane; of a mesh of more than kMostFaces that is not known. */
  [[nodiscard]] bool isConvex() const HD_RT { return convex_; }

 private:
  static constexpr std::uint32_t kAround = 32;  ///< On a cylinder's rim.
  static constexpr std::uint32_t kRings = 9;
  static constexpr std::uint32_t kMostFaces = 512;
  static constexpr std::uint32_t kFirstDisc = kRings * kAround + 2 * (1 + kAround / 2);

  void add(const Vec3& p) HD_RT;
  void addBox(const Vec3& half) HD_RT;
  void addCylinder(double radius, double half) HD_RT;
  void addBounds(const MeshView& mesh) HD_RT;

  std::array<std::array<float, 3>, kMost> p_;
  std::uint32_t count_ = 0;
  double radius_ = 0;
  double reach_ = 0;  ///< From the origin [m].
  Vec3 low_ = Vec3::Zero(), high_ = Vec3::Zero();
  bool convex_ = false;
  bool corners_first_ = false;
};

}  // namespace hapticd
