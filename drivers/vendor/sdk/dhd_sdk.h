/** @file
 * The part of Force Dimension's libdhd (SDK 3) that hapticd calls, declared anew from its public documentation.
 */
#pragma once

#include <cstdint>

#include "drivers/vendor/sdk/sdk_library.h"

namespace hapticd {

/**
 * Units: m, N, N m, rad; x toward the operator, y to the right, z up, as ours. Functions return less than 0 on error
 * but for those that count or ask. `id` is what the opening function returned.
 */
struct DhdSdk {
  using Id = char;
  static constexpr int kTimeGuard = 1;       ///< Told again sooner than the device's own period: no error.
  static constexpr int kMotorSaturated = 2;  ///< Of the functions that set a force: no error.
  /** Places in the array of dhdGetStatus(); it has 16 or more by version. */
  static constexpr int kCalibrated = 3, kForceOn = 5, kMostStatus = 64;

  void (*getSdkVersion)(int* major, int* minor, int* release, int* revision) = nullptr;
  int (*open)() = nullptr;
  int (*openId)(Id index) = nullptr;
  int (*openSerial)(int serial) = nullptr;
  int (*close)(Id id) = nullptr;
  int (*stop)(Id id) = nullptr;
  int (*getSystemType)(Id id) = nullptr;
  const char* (*getSystemName)(Id id) = nullptr;
  int (*getSerialNumber)(std::uint16_t* serial, Id id) = nullptr;
  int (*getStatus)(int* status, Id id) = nullptr;
  bool (*hasWrist)(Id id) = nullptr;
  bool (*hasActiveWrist)(Id id) = nullptr;
  bool (*hasGripper)(Id id) = nullptr;
  bool (*hasActiveGripper)(Id id) = nullptr;
  bool (*isLeftHanded)(Id id) = nullptr;
  int (*enableForce)(unsigned char on, Id id) = nullptr;
  int (*setGravityCompensation)(int on, Id id) = nullptr;
  int (*getPosition)(double* x, double* y, double* z, Id id) = nullptr;
  int (*getOrientationFrame)(double (*rows)[3], Id id) = nullptr;
  int (*getGripperAngleRad)(double* angle, Id id) = nullptr;
  static constexpr std::uint32_t kMostButtons = 16;  ///< The SDK tells no device's own number.
  unsigned int (*getButtonMask)(Id id) = nullptr;
  int (*setForceAndTorqueAndGripperForce)(double fx, double fy, double fz, double tx, double ty, double tz, double fg,
                                          Id id) = nullptr;
  const char* (*errorGetLastStr)() = nullptr;

  /** kUnsupported: not there; kVersionMismatch: another version. */
  [[nodiscard]] static Result<DhdSdk> load(const std::string& library);
};

}  // namespace hapticd
