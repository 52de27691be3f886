/** @file
 * The device interface: all that the servo knows of hardware. drivers/ implements it; nothing else crosses.
 *
 * Units are SI and the frame is the canonical one (x toward the operator, y to the operator's right, z up); the driver
 * converts, nobody else does. Where the device stands in the world is not its business (rt/cycle/mount.h).
 */
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "rt/base/error.h"
#include "rt/base/math.h"

namespace hapticd {

class Histogram;

/** Whether a device needs calibration before it may be armed. */
enum class Calibration : std::uint8_t { kNotNeeded, kNeeded, kRunning, kDone };

/** What a device is and can do. Fixed while it is open, but for the calibration and the temperature (see Device). */
struct DeviceInfo {
  std::string uri;  ///< Canonical: opens this device and no other.
  std::string model, manufacturer, serial, firmware;
  std::string driver, driver_version;
  double max_force = 0;                                                         ///< Peak [N].
  double continuous_force = 0;                                                  ///< [N]
  double max_torque = 0;                                                        ///< [N m]
  double max_gripper_force = 0;                                                 ///< [N]
  double max_stiffness = 0;                                                     ///< Closed loop at 1 kHz [N/m].
  double max_angular_stiffness = 0;                                             ///< [N m/rad]
  double max_gripper_stiffness = 0;                                             ///< [N/m]
  double max_damping = 0;                                                       ///< [N s/m]
  double max_angular_damping = 0;                                               ///< [N m s/rad]
  double workspace_radius = 0;                                                  ///< [m]
  Vec3 workspace_lower = Vec3::Zero(), workspace_upper = Vec3::Zero();          ///< Usable box [m].
  Vec3 max_workspace_lower = Vec3::Zero(), max_workspace_upper = Vec3::Zero();  ///< Reachable box [m].
  double gripper_max_angle = 0;                                                 ///< [rad]
  double position_resolution = 0;                                               ///< [m]
  double rotation_resolution = 0;                                               ///< [rad]
  double force_resolution = 0;                                                  ///< [N]
  double native_rate_hz = 0;
  double latency_s = 0;      ///< From a command to a reading of what it does, if known; the host's tick not included.
  double apparent_mass = 0;  ///< [kg]
  double viscous_friction = 0;  ///< [N s/m]
  double coulomb_friction = 0;  ///< [N]
  double max_velocity = 0;      ///< [m/s]
  bool sensed_position = true, sensed_rotation = false, sensed_gripper = false;
  bool actuated_position = true, actuated_rotation = false, actuated_gripper = false;
  bool left_hand = true, right_hand = true;
  std::uint32_t buttons = 0;  ///< How many.
  std::string calibration_style = "none";
  bool has_brakes = false, has_watchdog = false, has_deadman = false, has_velocity_limit = false;
};

/** Bits of DeviceSample.status. */
enum DeviceStatus : std::uint32_t {
  kDeviceOk = 0,
  kDeviceError = 1u << 0,        ///< The driver cannot go on.
  kDeviceGone = 1u << 1,         ///< Unplugged.
  kDeviceSaturated = 1u << 2,    ///< The last force was cut by the device's own limit.
  kDeviceDeadmanOpen = 1u << 3,  ///< The device's own dead-man switch is not held.
  kGroupDeadmanOpen = 1u << 4,   ///< This device is the dead-man switch of its whole group, and is not held.
};

/** One reading. Must be bit-for-bit what the cycle sees: it is part of CycleInput. */
struct DeviceSample {
  std::int64_t t_ns = 0;  ///< When the device measured it.
  Vec3 p = Vec3::Zero();  ///< Device point [m].
  Quat q = Quat::Identity();
  Vec3 v = Vec3::Zero();  ///< Only if has_velocity [m/s].
  Vec3 w = Vec3::Zero();  ///< Only if has_velocity [rad/s].
  double gripper_rad = 0;
  /** What carries the arm's own weight in this pose [N]; the cycle adds it as a source of its own, before the guard. */
  Vec3 gravity = Vec3::Zero();
  std::uint32_t buttons = 0;
  std::uint32_t status = kDeviceOk;
  bool fresh = false;         ///< Newer than the previous reading.
  bool has_velocity = false;  ///< v and w are measured by the device.
};

/** All that it tells is finite. Else the cycle does not look at it, and the guard latches. */
[[nodiscard]] inline bool usable(const DeviceSample& s) HD_RT {
  return isFinite(s.p) && isFinite(s.q) && std::isfinite(s.gripper_rad) &&
         (!s.has_velocity || (isFinite(s.v) && isFinite(s.w)));
}

/** What the guard lets through. */
struct DeviceCommand {
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 torque = Vec3::Zero();  ///< [N m]
  double gripper_force = 0;    ///< [N]
  bool enabled = false;        ///< Amplifiers may be on. False comes with zeros.
};

/** Where the hand of a simulated device wants to be; real devices ignore it. */
struct DeviceIntent {
  Vec3 p = Vec3::Zero();
  Quat q = Quat::Identity();
  double gripper_rad = 0;
};

/**
 * A haptic device. open, close and info are called by the control thread, never together with the rest; read, write
 * and setIntent by one real-time thread, the servo, so they neither lock, allocate nor block (drivers/link/io_device.h
 * is for those that would); safe by whoever is left.
 */
class Device {
 public:
  virtual ~Device() = default;

  [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
  [[nodiscard]] virtual Calibration calibration() const noexcept { return Calibration::kNotNeeded; }
  /** Hottest motor [deg C], NaN where not sensed. */
  [[nodiscard]] virtual double temperature() const noexcept { return std::numeric_limits<double>::quiet_NaN(); }
  /** From a command sent to the reading that answers it, of a device with an I/O thread of its own; else null. */
  [[nodiscard]] virtual Histogram* roundTrip() noexcept { return nullptr; }

  /** Takes the device. It must not move or push. */
  [[nodiscard]] virtual Result<void> open() = 0;
  /** safe(), then gives the device back. */
  virtual void close() noexcept = 0;

  /** How long a command is shown that no other follows, before the driver sends zeros; 0: until the next. */
  [[nodiscard]] virtual std::int64_t commandLife_ns() const noexcept { return 0; }

  /** Newest sample at `now_ns`; leaves fresh false and the rest as before when there is none. */
  virtual void read(std::int64_t now_ns, DeviceSample& sample) HD_RT = 0;
  /** Sends a command; takes effect as soon as the device can. */
  virtual void write(std::int64_t now_ns, const DeviceCommand& command) HD_RT = 0;
  /** Live intent for a simulated hand. */
  virtual void setIntent(const DeviceIntent&) HD_RT {}
  /**
   * Whether the last command that the device has got is one that is off: false while a thread of the driver's own has
   * one that is not behind it, and has not come back from sending zeros. From any thread.
   */
  [[nodiscard]] virtual bool isOff() const noexcept { return true; }
  /** Zeros and amplifier off. From any thread, also from a signal handler, when the servo is dead; idempotent. */
  virtual void safe() noexcept = 0;
};

}  // namespace hapticd
