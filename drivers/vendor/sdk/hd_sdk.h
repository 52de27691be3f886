/** @file
 * The part of OpenHaptics' libHD (version 3) that hapticd calls, declared anew from its public documentation.
 */
#pragma once

#include "drivers/vendor/sdk/sdk_library.h"

namespace hapticd {

/** Units: mm, N; x to the right, y up, z toward the operator. What changes in a tick is read and set within a frame. */
struct HdSdk {
  using Handle = unsigned int;
  using Enum = unsigned int;
  using Callback = unsigned int (*)(void* user);
  /** By value, as hdGetError() returns it. */
  struct ErrorInfo {
    unsigned int code;
    int internal_code;
    Handle device;
  };

  static constexpr Handle kNoDevice = 0xFFFFFFFF;
  static constexpr unsigned int kContinue = 1;  ///< What a callback returns to be called again.
  static constexpr unsigned short kHighPriority = 0xFFFE;
  // What can be read and set.
  static constexpr Enum kButtons = 0x2000, kPosition = 0x2050, kTransform = 0x2052;
  static constexpr Enum kModel = 0x2501, kVersion = 0x2500, kSerial = 0x2504, kFirmware = 0x2505;
  static constexpr Enum kMaxWorkspace = 0x2550, kUsableWorkspace = 0x2551, kCalibrationStyle = 0x2555;
  static constexpr Enum kMaxStiffness = 0x2602, kMaxForce = 0x2603, kContinuousForce = 0x2604, kMaxDamping = 0x2609;
  static constexpr Enum kForce = 0x2700;
  static constexpr Enum kForceOutput = 0x4000;
  static constexpr Enum kCalibrated = 0x5000, kCalibrationNeedsUpdate = 0x5001;
  /** Bits of kCalibrationStyle, which tells all that a device can; updating takes one of them. */
  static constexpr Enum kByItself = 2, kInInkwell = 4;
  // Kinds of error: by the high byte of the code.
  static constexpr unsigned int kForceErrors = 0x02, kDeviceErrors = 0x03;

  Handle (*initDevice)(const char* name) = nullptr;
  void (*disableDevice)(Handle device) = nullptr;
  void (*makeCurrentDevice)(Handle device) = nullptr;
  void (*beginFrame)(Handle device) = nullptr;
  void (*endFrame)(Handle device) = nullptr;
  ErrorInfo (*getError)() = nullptr;
  const char* (*getErrorString)(unsigned int code) = nullptr;
  void (*enable)(Enum capability) = nullptr;
  void (*disable)(Enum capability) = nullptr;
  void (*getDoublev)(Enum what, double* values) = nullptr;
  void (*getIntegerv)(Enum what, int* values) = nullptr;
  const char* (*getString)(Enum what) = nullptr;
  void (*setDoublev)(Enum what, const double* values) = nullptr;
  Enum (*checkCalibration)() = nullptr;
  void (*updateCalibration)(Enum style) = nullptr;
  void (*startScheduler)() = nullptr;
  void (*stopScheduler)() = nullptr;
  unsigned long (*scheduleAsynchronous)(Callback callback, void* user, unsigned short priority) = nullptr;
  void (*unschedule)(unsigned long handle) = nullptr;

  /** kUnsupported: not there; kVersionMismatch: another version. */
  [[nodiscard]] static Result<HdSdk> load(const std::string& library);
};

}  // namespace hapticd
