#include "rt/body/coupling.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/** k_c over k_o: the softer it is, the more of the swing the damper sees; 1 gives a loss of 0.35 at best. */
constexpr double kInnerShare = 1;
constexpr double kUnknownDeviceStiffness = 500;  ///< [N/m] Borne by every device in docs/devices.md at 1 kHz.
/** Where no torque is shown the rotation is as stiff as the translation at this lever [m]: a pen in the hand. */
constexpr double kLever = 0.03;

/**
 * b_c that damps the swing of `mass` best. The solid is E(w) = k_o (k_c + i w b) / (k_o + k_c + i w b), whose loss
 * tan = w b k_o / (k_c (k_o + k_c) + w^2 b^2) is greatest, k_o / (2 sqrt(k_c (k_o + k_c))), at w b = sqrt(k_c (k_o +
 * k_c)). The mass swings between the stiffness in the end and k_o: at their geometric mean.
 */
double bestDamping(double outer, double inner, double mass) {
  if (!(outer > 0) || !(inner > 0)) return 0;
  const double in_the_end = outer * inner / (outer + inner);
  const double swing = std::sqrt(std::sqrt(in_the_end * outer) / mass);
  return std::sqrt(inner * (outer + inner)) / swing;
}

}  // namespace

CouplingGains chooseGains(const DeviceInfo& device, const CouplingNeeds& needs) noexcept {
  const double lag = 0.5 * needs.dt + std::max(0.0, device.latency_s);
  const double borne = device.max_stiffness > 0 ? device.max_stiffness : kUnknownDeviceStiffness;
  CouplingGains out;
  out.outer = device.viscous_friction > 0 ? std::min(borne, device.viscous_friction / lag) : 0.5 * borne;
  if (needs.wanted > 0) out.outer = std::min(borne, needs.wanted * (1 + kInnerShare) / kInnerShare);
  out.stiffness = kInnerShare * out.outer;
  out.damping = bestDamping(out.outer, out.stiffness, needs.mass);

  out.angular_outer = out.outer * kLever * kLever;
  if (device.actuated_rotation && device.max_angular_stiffness > 0) {
    out.angular_outer = std::min(out.angular_outer, 0.5 * device.max_angular_stiffness);
  }
  out.angular_stiffness = kInnerShare * out.angular_outer;
  out.angular_damping = bestDamping(out.angular_outer, out.angular_stiffness, needs.inertia);
  return out;
}

}  // namespace hapticd
