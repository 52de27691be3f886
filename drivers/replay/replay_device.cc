#include "drivers/replay/replay_device.h"

#include <algorithm>
#include <bit>

#include "drivers/resident.h"

namespace hapticd {
namespace {

/** What the recording itself tells of the device. */
void describe(const PoseTrack& track, const ReplayParameters& p, DeviceInfo& info) {
  const std::vector<PoseRow>& rows = track.rows();
  info.sensed_rotation = info.actuated_rotation = track.hasRotation();
  if (info.sensed_rotation) info.max_torque = p.max_torque;
  info.sensed_gripper = track.hasGripper();
  Vec3 lower = rows.front().p, upper = lower;
  double widest = 0;
  std::uint32_t buttons = 0;
  for (const PoseRow& row : rows) {
    lower = lower.cwiseMin(row.p);
    upper = upper.cwiseMax(row.p);
    widest = std::max(widest, row.gripper_rad);
    buttons |= row.buttons;
  }
  info.workspace_lower = info.max_workspace_lower = lower;
  info.workspace_upper = info.max_workspace_upper = upper;
  info.workspace_radius = (upper - lower).maxCoeff() / 2;
  info.gripper_max_angle = widest;
  info.buttons = static_cast<std::uint32_t>(std::bit_width(buttons));
  if (rows.back().t_s > 0) info.native_rate_hz = static_cast<double>(rows.size() - 1) / rows.back().t_s * p.speed;
}

}  // namespace

Result<void> ReplayDevice::open() {
  started_ = false;
  auto track = setup_.file.read(given_up_);
  if (!track) return track.error();
  track_ = std::move(*track);
  describe(*track_, setup_.parameters, setup_.info);
  keepResident(track_->rows().data(), track_->bytes());
  return {};
}

void ReplayDevice::read(std::int64_t now_ns, DeviceSample& sample) HD_RT {
  sample.fresh = track_ != nullptr && (!started_ || now_ns > last_ns_);
  if (!sample.fresh) return;
  if (!started_) start_ns_ = now_ns;
  started_ = true;
  last_ns_ = now_ns;
  const double played_s = static_cast<double>(now_ns - start_ns_) * 1e-9 - setup_.parameters.wait;
  const PoseOnTrack pose = track_->at(std::max(0.0, played_s) * setup_.parameters.speed, setup_.parameters.loop);
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
