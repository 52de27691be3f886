/** @file
 * A hand that is taken off its point in the world and set down elsewhere, as a mouse is lifted ("indexing"): held, the
 * hand moves freely and its point stands still; let go, the device's mount is such that the point is where it was.
 *
 * What is felt is weight() times what the world asks. It falls to zero while the point still follows the hand, so that
 * a spring which weakens gives back less than it got; where nothing is felt it is zero at once. Then the point stands
 * still, where the surface holds it if one does: nothing is tensed there when the hand comes back. Let go, the weight
 * rises; of what springs and models hold for all that, it brings no more back than kMostPower, and that is charged to
 * who clutches, as what moving bodies bring.
 */
#pragma once

#include <algorithm>

#include "rt/base/math.h"
#include "rt/command.h"

namespace hapticd {

/** Of one device. Servo thread; plain data. */
class Clutch {
 public:
  static constexpr double kFall_s = 0.05;      ///< From all to nothing.
  static constexpr double kRise_s = 0.1;       ///< From nothing to all, at the fastest.
  static constexpr double kMostPower = 20e-3;  ///< That a rise brings into the hand [W].

  void set(const SetClutch& order) HD_RT {
    order_ = order;
    if (order.frozen == 0) return;
    freeze(vec3(order.anchor));
    weight_ = 0;
  }
  /** That gives a new one this clutch, but for a force that falls or rises. */
  [[nodiscard]] SetClutch order(std::uint32_t device) const HD_RT {
    SetClutch order{device, order_.held, order_.button, frozen_ ? 1u : 0u, {}};
    if (frozen_) store(anchor_, order.anchor);
    return order;
  }
  [[nodiscard]] static bool valid(const SetClutch& order) HD_RT {
    return order.button <= 32 && isFinite(vec3(order.anchor));
  }

  /** Begins a tick that comes `passed` after the last [s], with these buttons. */
  void begin(std::uint32_t buttons, double passed) HD_RT {
    rose_ = 0;
    if (held(buttons)) {
      weight_ = felt_ ? std::max(0.0, weight_ - passed / kFall_s) : 0.0;
    } else if (!frozen_ && weight_ < 1) {
      const double most = stored_ > 0 ? kMostPower * passed / stored_ : 1.0;
      rose_ = std::min({passed / kRise_s, most, 1 - weight_});
      weight_ += rose_;
    }
  }
  /** What ends it: felt_ says whether anything but the arm's own weight was asked for, `stored` what springs hold [J].
   */
  void end(bool felt, double stored) HD_RT {
    felt_ = felt;
    stored_ = stored;
  }
  /** The hand is off: the point has to stand still, or to come back. */
  [[nodiscard]] bool held(std::uint32_t buttons) const HD_RT {
    return order_.held != 0 || (order_.button != 0 && (buttons >> (order_.button - 1) & 1u) != 0);
  }

  /** The point stands still there, in the world. */
  void freeze(const Vec3& at) HD_RT {
    anchor_ = at;
    frozen_ = true;
  }
  void thaw() HD_RT { frozen_ = false; }
  [[nodiscard]] bool frozen() const HD_RT { return frozen_; }
  [[nodiscard]] const Vec3& anchor() const HD_RT { return anchor_; }

  [[nodiscard]] double weight() const HD_RT { return weight_; }
  /** By how much it rose in this tick. */
  [[nodiscard]] double rose() const HD_RT { return rose_; }

 private:
  SetClutch order_{};
  Vec3 anchor_ = Vec3::Zero();
  double weight_ = 1, rose_ = 0;
  double stored_ = 0;
  bool felt_ = false, frozen_ = false;
};

}  // namespace hapticd
