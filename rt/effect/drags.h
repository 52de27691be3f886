/** @file
 * All that damps a hand in free space, together no more than its device can show.
 *
 * A loop damps by a velocity that is late. Beyond some damping each tick's force overshoots the last, and the hand is
 * thrown to and fro at the servo's rate (docs/stability.md); no passivity controller looks at what is active anyway. So
 * the damping is bounded, not the force: a bath too thick for a device is as thick as it can be.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "rt/base/math.h"
#include "rt/command.h"

namespace hapticd {

/** Those of one tick. Servo-safe. */
class Drags {
 public:
  /**
   * Against v [m/s] with `damping` [N s/m], and no more than `most` [N]: what is too weak for its damping damps by as
   * much less, and takes no more than that from the others. At most as many as there are effects.
   */
  void add(const Vec3& v, double damping, double most) HD_RT {
    const double full = damping * v.norm();
    const double shown = full > most ? damping * (most / full) : damping;
    if (count_ == kMaxEffects || !(shown > 0 && most > 0)) return;  // At rest, too.
    all_[count_++] = {v, shown};
    sum_ += shown;
  }
  /** Their sum [N]; where they would damp by more than `most_damping` [N s/m], each by as much less. */
  [[nodiscard]] Vec3 force(double most_damping) const HD_RT {
    const double share = sum_ > most_damping ? most_damping / sum_ : 1.0;
    Vec3 force = Vec3::Zero();
    for (std::size_t i = 0; i < count_; ++i) force -= share * all_[i].damping * all_[i].v;
    return force;
  }
  /** By which that is made, at most `most_damping` [N s/m]. */
  [[nodiscard]] double damping(double most_damping) const HD_RT { return std::min(sum_, most_damping); }

 private:
  struct Drag {
    Vec3 v;
    double damping;
  };

  std::array<Drag, kMaxEffects> all_;
  std::size_t count_ = 0;
  double sum_ = 0;
};

}  // namespace hapticd
