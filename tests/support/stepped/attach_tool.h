/** @file
 * The order that puts a box of 100 g into a device's hand.
 */
#pragma once

#include "rt/body/coupling.h"
#include "rt/body/rigid_body.h"
#include "rt/command.h"

namespace hapticd::test {

/** Full sides [m]; gains for the device at 1 kHz, `wanted` as CouplingNeeds has it. */
inline AttachTool attachBox(std::uint32_t object, const Vec3& sides, const DeviceInfo& device, double wanted = 0) {
  constexpr double kMass = 0.1;
  const MassProperties mass = MassProperties::ofBox(kMass, sides);
  const CouplingGains g = chooseGains(device, {kMass, mass.inertia_O.trace() / 3, 1e-3, wanted});
  AttachTool out{};
  out.object = object;
  out.shows_torque = device.actuated_rotation ? 1 : 0;
  out.mass = kMass;
  for (int i = 0; i < 3; ++i) out.inertia[i] = mass.inertia_O(i, i);
  out.outer = g.outer;
  out.stiffness = g.stiffness;
  out.damping = g.damping;
  out.angular_outer = g.angular_outer;
  out.angular_stiffness = g.angular_stiffness;
  out.angular_damping = g.angular_damping;
  return out;
}

}  // namespace hapticd::test
