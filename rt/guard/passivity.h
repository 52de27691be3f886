/** @file
 * Passivity observer and controller (Hannaford and Ryu, IEEE Trans. Robotics and Automation 18(1), 2002, pp. 1-10), one
 * port per Cartesian axis, in the impedance form: the observer integrates -f v of the force actually sent; when it says
 * that the virtual world has given more energy than it received, the controller adds damping that dissipates the
 * difference, bounded by the largest damping the device can show.
 */
#pragma once

#include <array>

#include "rt/base/math.h"

namespace hapticd {

class Passivity {
 public:
  explicit Passivity(double max_damping = 0) noexcept : max_damping_(max_damping) {}

  void reset() HD_RT;
  /** Force after the controller, for passive force `f` at velocity `v`; both finite. */
  [[nodiscard]] Vec3 control(const Vec3& f, const Vec3& v, double dt) HD_RT;
  /** Books the passive part of what was really sent over this tick. `active` sources are booked apart by the guard. */
  void observe(const Vec3& sent, const Vec3& v, double dt) HD_RT;
  /** Least energy of the three axes [J]. */
  [[nodiscard]] double energy() const HD_RT;
  [[nodiscard]] bool acting() const HD_RT { return acting_; }
  void setMaxDamping(double b) HD_RT { max_damping_ = b; }

 private:
  double max_damping_;  ///< [N s/m]
  std::array<double, 3> energy_{};
  bool acting_ = false;
};

}  // namespace hapticd
