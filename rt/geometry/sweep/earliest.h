/** @file
 * The first of the triangles that a sweep meets, whatever the order in which they are tried.
 */
#pragma once

#include "rt/geometry/sweep/sweep.h"

namespace hapticd {

/** Earliest hit so far: of one mesh, and of what was met before it, which wins if the times are equal. */
class Earliest {
 public:
  explicit Earliest(SweepHit& hit) noexcept : hit_(hit) {}

  [[nodiscard]] bool found() const HD_RT { return found_; }
  /** Later than this nothing counts. */
  [[nodiscard]] double time() const HD_RT { return hit_.t; }
  /** Whether a triangle that is met at t, or not before t, may come first. */
  [[nodiscard]] bool isBeatenBy(double t, std::uint32_t triangle) const HD_RT {
    return t < hit_.t || (found_ && t == hit_.t && triangle < hit_.feature);
  }
  void set(const SweepHit& hit) HD_RT {
    hit_ = hit;
    found_ = true;
  }

 private:
  SweepHit& hit_;
  bool found_ = false;
};

}  // namespace hapticd
