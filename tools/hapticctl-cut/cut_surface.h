/** @file
 * Where a solid is cut: a plane or a ball's shell, made rough by noise, such that the fragment comes out along `pull`.
 */
#pragma once

#include <cstdint>
#include <vector>

#include "tools/hapticctl-cut/lattice.h"

namespace hapticctl_cut {

struct CutShape {
  bool shell = false;         ///< A ball's shell about `at`, the fragment inside; else the plane through it.
  Vec3 at = Vec3::Zero();     ///< [mm], as all lengths here.
  double radius = 0;          ///< Of the shell.
  Vec3 pull = Vec3::UnitZ();  ///< The way the fragment comes out: the plane's normal. Made unit.
  double noise = 0;           ///< Root mean square of the roughness.
  double wavelength = 1;      ///< The shortest; the longest is twice that.
  std::uint64_t seed = 1;
};

/**
 * The roughness moves the cut along its normal by a sum of waves that run across `pull` and are constant along it. So
 * the fragment's side of a plane is a height field, and that of a shell is one wherever it lies below the ball's
 * equator, seen against `pull`: there the fragment comes out along `pull` without catching.
 */
class CutSurface {
 public:
  explicit CutSurface(const CutShape& shape);
  /**
   * Distance to the cut, positive on the fragment's side: exact where it is 0, elsewhere to first order (the value by
   * its gradient). Farther than reach() from the smooth cut it is that one's.
   */
  [[nodiscard]] double at(const Vec3& x) const;
  /** No more than so far is the rough cut from the smooth one. */
  [[nodiscard]] double reach() const { return reach_; }
  /** What holds the cut; without an end for a plane. */
  [[nodiscard]] Box box() const;

 private:
  struct Wave {
    Vec3 k;  ///< [rad/mm], across the pull.
    double phase;
  };
  CutShape shape_;
  std::vector<Wave> wave_;
  double amplitude_ = 0;  ///< Of each.
  double reach_ = 0;
};

}  // namespace hapticctl_cut
