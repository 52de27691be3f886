#include "drivers/vendor/sdk/hd_sdk.h"

#include <fmt/format.h>

#include <string_view>

namespace hapticd {

Result<HdSdk> HdSdk::load(const std::string& name) {
  constexpr std::string_view kWanted = "OpenHaptics 3 and its device drivers (3D Systems)";
  auto library = SdkLibrary::open(name, fmt::format("install {}, or name its library by sdk=", kWanted));
  if (!library) return library.error();
  HdSdk sdk;
  library->need(sdk.initDevice, "hdInitDevice");
  library->need(sdk.disableDevice, "hdDisableDevice");
  library->need(sdk.makeCurrentDevice, "hdMakeCurrentDevice");
  library->need(sdk.beginFrame, "hdBeginFrame");
  library->need(sdk.endFrame, "hdEndFrame");
  library->need(sdk.getError, "hdGetError");
  library->need(sdk.getErrorString, "hdGetErrorString");
  library->need(sdk.enable, "hdEnable");
  library->need(sdk.disable, "hdDisable");
  library->need(sdk.getDoublev, "hdGetDoublev");
  library->need(sdk.getIntegerv, "hdGetIntegerv");
  library->need(sdk.getString, "hdGetString");
  library->need(sdk.setDoublev, "hdSetDoublev");
  library->need(sdk.checkCalibration, "hdCheckCalibration");
  library->need(sdk.updateCalibration, "hdUpdateCalibration");
  library->need(sdk.startScheduler, "hdStartScheduler");
  library->need(sdk.stopScheduler, "hdStopScheduler");
  library->need(sdk.scheduleAsynchronous, "hdScheduleAsynchronous");
  library->need(sdk.unschedule, "hdUnschedule");
  if (auto whole = library->complete(kWanted); !whole) return whole.error();
  const char* const version = sdk.getString(kVersion);
  const std::string_view text = version == nullptr ? "" : version;
  // Some versions tell it only of a device; that is no reason to refuse.
  for (int i = 0; i < 8 && sdk.getError().code != 0; ++i) {
  }
  if (text.empty() || text.front() == '3') return sdk;
  return Error{ErrorCode::kVersionMismatch, name, fmt::format("it is version {}, hapticd knows 3", text),
               fmt::format("install {}", kWanted)};
}

}  // namespace hapticd
