#include "drivers/sim/sim_driver.h"

#include "drivers/sim/sim_device.h"

namespace hapticd {
namespace {

Result<std::unique_ptr<Device>> make(const DeviceUri& uri) {
  Result<SimSetup> setup = resolveSim(uri);
  if (!setup) return setup.error();
  return std::unique_ptr<Device>(std::make_unique<SimDevice>(std::move(*setup)));
}

void find(std::vector<DeviceFound>& found) {
  Result<SimSetup> setup = resolveSim({"sim", "default", {}});
  if (setup) found.push_back({std::move(setup->info), false});
}

}  // namespace

const Driver kSimDriver = {"sim", "sim://PRESET?key=value", false, &find, &make, &noForceOutlivesTheProcess};

}  // namespace hapticd
