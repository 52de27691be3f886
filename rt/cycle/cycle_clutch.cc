// A hand that is taken off its point in the world: where the point is, and how much of it is felt.
#include <algorithm>

#include "rt/cycle/cycle.h"

namespace hapticd {

/** Before anything is done with the reading, which is usable. */
void Cycle::moveClutch(std::uint32_t d, const CycleInput& input) HD_RT {
  DeviceState& device = devices_[d];
  Clutch& clutch = device.clutch;
  const DeviceSample& read = input.device[d];
  clutch.begin(read.buttons, period() * periods_);
  const bool held = clutch.held(read.buttons);
  if (held == clutch.frozen() || (held && clutch.weight() > 0)) return;
  const Vec3 here = device.mount.toWorld(Pose{read.p, read.q}).p;
  if (held) return clutch.freeze(device.started ? device.rest : here);
  // A mount reaches only so far. Beyond, the point moves to the nearest place it can have; nothing is felt meanwhile.
  clutch.thaw();
  Pose X_WD = device.mount.pose();
  X_WD.p = (X_WD.p + (clutch.anchor() - here)).cwiseMax(-Mount::kFarthest).cwiseMin(Mount::kFarthest);
  device.mount = Mount(X_WD, device.mount.scale());
  device.moved = true;
}

/** What was rendered, as much as is felt of it; in the device's frame, without what carries the arm. */
void Cycle::weighClutch(std::uint32_t d, const SurfaceContact& contact, const Vec3& point) HD_RT {
  DeviceState& device = devices_[d];
  Energy& energy = energy_[d];
  device.rest = contact.object != 0 ? contact.proxy : point;
  const double w = device.clutch.weight(), rose = device.clutch.rose();
  const bool felt =
      std::ranges::any_of(sources_[d], [](const Wrench& s) HD_RT { return !s.force.isZero(0) || !s.torque.isZero(0); });
  device.clutch.end(felt, energy.stored);
  if (w == 1 && rose == 0) return;
  Vec3 total = Vec3::Zero();
  for (Wrench& source : sources_[d]) {
    total += source.force;
    source.force *= w;
    source.torque *= w;
  }
  const double dt = period();
  energy.carried = w * energy.carried + byAxis(rose * std::max(0.0, energy.stored) / dt, total);
  energy.local_active *= w;
  energy.relief *= w;
  energy.stored *= w;
  energy.damping *= w;
}

}  // namespace hapticd
