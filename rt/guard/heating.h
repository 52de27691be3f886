/** @file
 * How warm a device's motors are, from the forces sent, and how much force that leaves: peak force for a while,
 * continuous force for ever.
 *
 * One body with one time constant. A motor's loss goes with the square of its current, and so of the force: held at the
 * continuous force F_c it comes to rest at heat 1, what its maker allows. Hence h' = ((|F| / F_c)^2 - h) / tau. Above
 * kDerate the force allowed falls linearly from the peak to F_c, which it is at 1: so h never passes 1, whatever is
 * asked for, and F_c is never cut. It is an estimate: it knows nothing of the room or of a hand on the motor, and
 * starts cold.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/base/contract.h"

namespace hapticd {

class Heating {
 public:
  static constexpr double kAnnounce = 0.7;  ///< From here on warm() says what is coming ...
  static constexpr double kDerate = 0.85;   ///< ... and from here on it happens.

  /**
   * `continuous` and `peak` force [N], time constant `tau` [s]. Not all above zero, finite and peak above continuous:
   * no model, nothing is cut. Begins at `heat`.
   */
  Heating(double continuous, double peak, double tau, double heat = 0) noexcept {
    const bool usable =
        continuous > 0 && tau > 0 && std::isfinite(continuous) && std::isfinite(peak) && std::isfinite(tau);
    if (!usable || !(peak > continuous)) return;
    continuous_ = continuous;
    peak_ = peak;
    tau_ = tau;
    heat_ = heat >= 0 && heat <= 1 ? heat : 1.0;
  }

  /** Books a force of that magnitude, held for `dt` [s]. What is not finite counts as the peak. */
  void book(double force, double dt) HD_RT {
    if (tau_ == 0 || !(dt > 0)) return;
    const double share = (std::isfinite(force) ? std::min(std::abs(force), peak_) : peak_) / continuous_;
    heat_ += std::min(1.0, dt / tau_) * (share * share - heat_);
  }
  /** Most force that may be sent now [N]; infinite without a model. */
  [[nodiscard]] double allowed() const HD_RT {
    if (tau_ == 0) return std::numeric_limits<double>::infinity();
    const double over = std::clamp((heat_ - kDerate) / (1 - kDerate), 0.0, 1.0);
    return over > 0 ? peak_ + over * (continuous_ - peak_) : std::numeric_limits<double>::infinity();
  }
  /** 0 cold, 1 all that the motors stand for ever. */
  [[nodiscard]] double heat() const HD_RT { return heat_; }
  /** Announced, before anything is cut; until it has cooled well below. */
  [[nodiscard]] bool warm() HD_RT {
    warm_ = heat_ > (warm_ ? kAnnounce - 0.1 : kAnnounce);
    return warm_;
  }

 private:
  double continuous_ = 0, peak_ = 0, tau_ = 0;
  double heat_ = 0;
  bool warm_ = false;
};

}  // namespace hapticd
