/** @file
 * How a guide pulls: by its distance alone, so that no closed way past a guide that rests gives energy.
 */
#pragma once

#include <algorithm>

#include "rt/command.h"

namespace hapticd {

/** Outer part of the reach over which an effect fades to nothing. */
inline constexpr double kEffectEdge = 0.2;

/** 1 up to where the edge begins, 0 from `reach` on. Needs reach > 0. */
[[nodiscard]] inline double withinReach(double distance, double reach) HD_RT {
  return std::clamp((1 - distance / reach) / kEffectEdge, 0.0, 1.0);
}

/** A spring that holds its force once that is `most`, and lets go over the edge of its reach. */
class Well {
 public:
  /** All at least 0; `reach` above. A spring that would not come to `most` before the edge is as strong as it is there.
   */
  Well(double stiffness, double most, double reach) HD_RT : stiffness_(stiffness),
                                                            edge_((1 - kEffectEdge) * reach),
                                                            reach_(reach),
                                                            most_(std::min(most, stiffness* edge_)) {}

  /** Toward the guide [N]. */
  [[nodiscard]] double pull(double distance) const HD_RT {
    return std::min(stiffness_ * distance, most_) * withinReach(distance, reach_);
  }
  /** What it takes to go from there out of reach, never negative [J]. */
  [[nodiscard]] double depth(double distance) const HD_RT {
    const double d = std::min(distance, reach_);
    const double left = std::min(reach_ - d, reach_ - edge_);
    double work = most_ * left * left / (2 * (reach_ - edge_));
    const double soft = stiffness_ > 0 ? most_ / stiffness_ : edge_;  // From here on it pulls as it can.
    work += most_ * std::max(0.0, edge_ - std::max(d, soft));
    if (d < soft) work += 0.5 * stiffness_ * (soft * soft - d * d);
    return work;
  }

 private:
  double stiffness_, edge_, reach_, most_;
};

}  // namespace hapticd
