#include "drivers/named_file.h"

#include "drivers/pantograph/pantograph_driver.h"
#include "drivers/replay/replay_driver.h"
#include "drivers/sim/sim_driver.h"
#include "drivers/woodyhid/woodyhid_driver.h"

namespace hapticd {

std::string namedMotion(const DeviceUri& uri) {
  if (uri.scheme == kReplayDriver.scheme) return uri.authority;
  if (uri.scheme != kSimDriver.scheme) return {};
  for (const auto& [key, value] : uri.query) {
    if (key == "file") return value;
  }
  return {};
}

std::string namedLine(const DeviceUri& uri) {
  return uri.scheme == kPantographDriver.scheme ? uri.authority : std::string();
}

std::string namedModel(const DeviceUri& uri) {
  const bool usual = uri.authority.empty() || uri.authority == "default" || uri.authority == kUsualWoodyModel;
  return uri.scheme == kWoodyDriver.scheme && !usual ? uri.authority : std::string();
}

}  // namespace hapticd
