/** @file
 * Boxes of a tree whose triangles have moved.
 */
#pragma once

#include <cstdint>

#include "rt/scene/mesh_view.h"

namespace hapticd {

/**
 * Collects leaves whose triangles have moved and makes their boxes, and those above, exact again: vertices that move
 * together mostly share leaves, and all share what is above. Until finish() the boxes are old ones. Servo-safe.
 */
class Refit {
 public:
  /** Of a deformable mesh, which must outlive it. */
  explicit Refit(MeshView& mesh) noexcept : mesh_(mesh) {}

  /** The triangle has moved. Finishes what it has whenever it is full. */
  void add(std::uint32_t triangle) HD_RT;
  /** Bounded by the leaves times HD_BVH_MAX_DEPTH. */
  void finish() HD_RT;

 private:
  static constexpr std::uint32_t kMost = 256;

  void climb(std::uint32_t place) HD_RT;

  MeshView& mesh_;
  std::uint32_t
      place_[kMost];  ///< Of leaves or nodes in their parents: the number of the parent times eight, and which.
  std::uint32_t count_ = 0;
};

}  // namespace hapticd
