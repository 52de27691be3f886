#include "drivers/vendor/sdk/dhd_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/link/shortened.h"

namespace hapticd {

Error DhdIo::failed(const char* what) const {
  const char* const why = sdk_->errorGetLastStr();
  return {ErrorCode::kDeviceGone, setup_.info.uri,
          fmt::format("{}: {}", what, why == nullptr ? "no reason given" : why),
          "is it plugged in and switched on, and no other program on it?"};
}

Result<void> DhdIo::open(const std::atomic<bool>&) {
  if (!sdk_) {
    auto loaded = DhdSdk::load(setup_.parameters.sdk);
    if (!loaded) return loaded.error();
    sdk_ = *loaded;
  }
  const std::uint64_t serial = setup_.parameters.serial;
  const int id = serial != 0         ? sdk_->openSerial(static_cast<int>(serial))
                 : setup_.index >= 0 ? sdk_->openId(static_cast<DhdSdk::Id>(setup_.index))
                                     : sdk_->open();
  if (id < 0) return failed("it does not open");
  id_ = static_cast<DhdSdk::Id>(id);
  open_ = true;
  asked_ = saturated_ = energised_ = switched_off_ = may_push_ = false;
  failures_ = refusals_ = 0;
  ticks_ = 0;
  check_.forget();
  setForce(Vec3::Zero(), Vec3::Zero(), 0);
  (void)sdk_->enableForce(0, id_);
  (void)sdk_->setGravityCompensation(setup_.parameters.gravity ? 1 : 0, id_);
  if (auto described = describe(); !described) return described;
  DeviceSample first;
  if (!read(first)) return failed("it tells no position");
  lookAtStatus();
  next_ns_ = clock_.now();
  return {};
}

Result<void> DhdIo::describe() {
  const int type = sdk_->getSystemType(id_);
  if (type < 0) return failed("it does not say what it is");
  if (system_type_ != 0 && type != system_type_) {
    return Error{ErrorCode::kDeviceBusy, setup_.info.uri, "another kind of device stands in its place",
                 "close it and open it again, or name yours by serial="};
  }
  wrist_ = sdk_->hasWrist(id_);
  gripper_ = sdk_->hasGripper(id_);
  const bool left = sdk_->isLeftHanded(id_);
  jaws_ = left ? -1 : 1;
  if (system_type_ != 0) return {};  // What it is was told when it was opened first.
  system_type_ = type;
  DeviceInfo& info = setup_.info;
  describeDhd(type, info);
  if (const char* const name = sdk_->getSystemName(id_)) info.model = name;
  std::uint16_t serial = 0;
  if (sdk_->getSerialNumber(&serial, id_) >= 0 && serial != 0) info.serial = fmt::format("{}", serial);
  int major = 0, minor = 0, release = 0, revision = 0;
  sdk_->getSdkVersion(&major, &minor, &release, &revision);
  info.driver_version = fmt::format("1, SDK {}.{}.{}.{}", major, minor, release, revision);
  info.sensed_rotation = wrist_;
  info.actuated_rotation = wrist_ && sdk_->hasActiveWrist(id_);
  info.sensed_gripper = gripper_;
  info.actuated_gripper = gripper_ && sdk_->hasActiveGripper(id_);
  if (!info.actuated_rotation) info.max_torque = 0;
  if (!info.actuated_gripper) info.max_gripper_force = 0;
  if (!info.sensed_gripper) info.gripper_max_angle = 0;
  info.left_hand = left;
  info.right_hand = !left;
  return {};
}

void DhdIo::close() noexcept {
  if (!open_) return;
  for (int i = 0; i < kZeros; ++i) setForce(Vec3::Zero(), Vec3::Zero(), 0);
  (void)sdk_->setGravityCompensation(0, id_);
  (void)sdk_->enableForce(0, id_);
  (void)sdk_->stop(id_);
  (void)sdk_->close(id_);
  open_ = false;
  calibration_.store(Calibration::kNeeded);
}

bool DhdIo::exchange(DeviceLink& link, std::int64_t until_ns) noexcept {
  while (clock_.now() < until_ns) {
    if (clock_.now() < next_ns_) {
      clock_.sleepUntil(std::min(until_ns, next_ns_));
      continue;
    }
    next_ns_ = std::max(next_ns_ + kPeriod_ns, clock_.now());
    DeviceSample sample;
    if (read(sample)) {
      failures_ = 0;
      take(sample, link);
    } else {
      LinkCounters::add(link.counters.lost);
      if (++failures_ >= kFailuresInARow) return false;
    }
    if (++ticks_ % kStatusEvery == 0) lookAtStatus();
    link.order(clock_.now(), [this](const DeviceCommand& command) noexcept { return send(command); });
    if (refusals_ >= kFailuresInARow) return false;
  }
  return true;
}

bool DhdIo::read(DeviceSample& sample) noexcept {
  if (sdk_->getPosition(&sample.p.x(), &sample.p.y(), &sample.p.z(), id_) < 0) return false;
  if (wrist_) {
    double rows[3][3] = {};
    if (sdk_->getOrientationFrame(rows, id_) < 0) return false;
    const auto q = rotationOf(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&rows[0][0]));
    if (q) {
      sample.q = *q;
    } else {
      sample.p.setConstant(std::nan(""));  // A pose is one thing: believed or not.
    }
  }
  if (gripper_ && sdk_->getGripperAngleRad(&sample.gripper_rad, id_) < 0) return false;
  sample.gripper_rad *= jaws_;
  if (!std::isfinite(sample.gripper_rad)) sample.p.setConstant(std::nan(""));
  sample.buttons = sdk_->getButtonMask(id_) & ((1u << DhdSdk::kMostButtons) - 1);  // What follows is the panel's.
  return true;
}

void DhdIo::take(DeviceSample& sample, DeviceLink& link) noexcept {
  const std::int64_t now_ns = clock_.now();
  LinkCounters::add(link.counters.exchanges);
  if (asked_) link.round_trip.record(now_ns - asked_ns_);
  asked_ = false;
  if (calibration_.load() != Calibration::kDone) return;
  switch (check_.judge(sample.p, now_ns, setup_.info)) {
    case PoseCheck::Verdict::kBelieved:
      break;
    case PoseCheck::Verdict::kBroken:
      link.publishStatus(kDeviceError);
      [[fallthrough]];
    case PoseCheck::Verdict::kDropped:
      LinkCounters::add(link.counters.rejected);
      return;
  }
  sample.t_ns = now_ns;
  sample.status = (saturated_ ? kDeviceSaturated : kDeviceOk) | (switched_off_ ? kDeviceDeadmanOpen : kDeviceOk);
  link.publish(sample);
}

bool DhdIo::send(const DeviceCommand& command) noexcept {
  may_push_ = may_push_ || command.enabled;
  saturated_ = false;
  asked_ns_ = clock_.now();
  asked_ = true;
  if (command.enabled != energised_) {
    if (!command.enabled) setForce(Vec3::Zero(), Vec3::Zero(), 0);
    const bool switched = sdk_->enableForce(command.enabled ? 1 : 0, id_) >= 0;
    if (switched) may_push_ = command.enabled;
    energised_ = command.enabled;
    switched_off_ = false;
    energised_ticks_ = ticks_;
  }
  const bool trusted = calibration_.load() == Calibration::kDone && check_.trusted(asked_ns_, kTrust_ns);
  if (!command.enabled || !trusted || switched_off_ || !command.force.allFinite() || !command.torque.allFinite() ||
      !std::isfinite(command.gripper_force)) {
    const bool taken = setForce(Vec3::Zero(), Vec3::Zero(), 0);
    if (taken) may_push_ = command.enabled;
    return !may_push_ || taken;
  }
  const DeviceInfo& info = setup_.info;
  const double gripper = std::clamp(command.gripper_force, -info.max_gripper_force, info.max_gripper_force);
  return setForce(shortened(command.force, info.max_force, saturated_),
                  shortened(command.torque, info.max_torque, saturated_), gripper);
}

bool DhdIo::setForce(const Vec3& force, const Vec3& torque, double gripper) noexcept {
  const int done = sdk_->setForceAndTorqueAndGripperForce(force.x(), force.y(), force.z(), torque.x(), torque.y(),
                                                          torque.z(), jaws_ * gripper, id_);
  if (done == DhdSdk::kMotorSaturated) saturated_ = true;
  refusals_ = may_push_ && done < 0 ? refusals_ + 1 : 0;
  return done >= 0;
}

void DhdIo::lookAtStatus() noexcept {
  std::array<int, DhdSdk::kMostStatus> status{};
  if (sdk_->getStatus(status.data(), id_) < 0) return;
  const bool calibrated = status[DhdSdk::kCalibrated] != 0;
  if (calibrated != (calibration_.load() == Calibration::kDone)) check_.forget();  // The origin jumps then.
  calibration_.store(calibrated ? Calibration::kDone : Calibration::kNeeded);
  // It takes a moment until it says that forces are on.
  if (energised_ && ticks_ - energised_ticks_ > kStatusEvery && status[DhdSdk::kForceOn] == 0) switched_off_ = true;
}

}  // namespace hapticd
