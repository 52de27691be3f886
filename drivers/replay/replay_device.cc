#include "drivers/replay/replay_device.h"

#include <algorithm>

#include "drivers/resident.h"

namespace hapticd {

Result<void> ReplayDevice::open() {
  started_ = false;
  const std::vector<PoseRow>& rows = setup_.track->rows();
  keepResident(rows.data(), rows.size() * sizeof(PoseRow));
  return {};
}

void ReplayDevice::read(std::int64_t now_ns, DeviceSample& sample) HD_RT {
  sample.fresh = !started_ || now_ns > last_ns_;
  if (!sample.fresh) return;
  if (!started_) start_ns_ = now_ns;
  started_ = true;
  last_ns_ = now_ns;
  const double played_s = static_cast<double>(now_ns - start_ns_) * 1e-9 - setup_.parameters.wait;
  const PoseOnTrack pose = setup_.track->at(std::max(0.0, played_s) * setup_.parameters.speed, setup_.parameters.loop);
  sample.t_ns = now_ns;
  sample.p = pose.p;
  sample.q = pose.q;
  sample.v.setZero();
  sample.w.setZero();
  sample.gripper_rad = pose.gripper_rad;
  sample.buttons = pose.buttons;
  sample.status = kDeviceOk;
  sample.has_velocity = false;
}

}  // namespace hapticd
