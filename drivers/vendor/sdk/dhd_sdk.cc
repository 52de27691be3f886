#include "drivers/vendor/sdk/dhd_sdk.h"

#include <fmt/format.h>

namespace hapticd {

Result<DhdSdk> DhdSdk::load(const std::string& name) {
  constexpr std::string_view kWanted = "Force Dimension's SDK 3 (forcedimension.com/software/sdk)";
  auto library = SdkLibrary::open(name, fmt::format("install {}, or name its library by sdk=", kWanted));
  if (!library) return library.error();
  DhdSdk sdk;
  library->need(sdk.getSdkVersion, "dhdGetSDKVersion");
  library->need(sdk.open, "dhdOpen");
  library->need(sdk.openId, "dhdOpenID");
  library->need(sdk.openSerial, "dhdOpenSerial");
  library->need(sdk.close, "dhdClose");
  library->need(sdk.stop, "dhdStop");
  library->need(sdk.getSystemType, "dhdGetSystemType");
  library->need(sdk.getSystemName, "dhdGetSystemName");
  library->need(sdk.getSerialNumber, "dhdGetSerialNumber");
  library->need(sdk.getStatus, "dhdGetStatus");
  library->need(sdk.hasWrist, "dhdHasWrist");
  library->need(sdk.hasActiveWrist, "dhdHasActiveWrist");
  library->need(sdk.hasGripper, "dhdHasGripper");
  library->need(sdk.hasActiveGripper, "dhdHasActiveGripper");
  library->need(sdk.isLeftHanded, "dhdIsLeftHanded");
  library->need(sdk.enableForce, "dhdEnableForce");
  library->need(sdk.setGravityCompensation, "dhdSetGravityCompensation");
  library->need(sdk.getPosition, "dhdGetPosition");
  library->need(sdk.getOrientationFrame, "dhdGetOrientationFrame");
  library->need(sdk.getGripperAngleRad, "dhdGetGripperAngleRad");
  library->need(sdk.getButtonMask, "dhdGetButtonMask");
  library->need(sdk.setForceAndTorqueAndGripperForce, "dhdSetForceAndTorqueAndGripperForce");
  library->need(sdk.errorGetLastStr, "dhdErrorGetLastStr");
  if (auto whole = library->complete(kWanted); !whole) return whole.error();
  int major = 0, minor = 0, release = 0, revision = 0;
  sdk.getSdkVersion(&major, &minor, &release, &revision);
  if (major == 3) return sdk;
  return Error{ErrorCode::kVersionMismatch, name, fmt::format("it is version {}.{}, hapticd knows 3", major, minor),
               fmt::format("install {}", kWanted)};
}

}  // namespace hapticd
