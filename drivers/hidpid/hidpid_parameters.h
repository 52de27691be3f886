/** @file
 * Keys of a hidpid:// URI, and the device they make.
 */
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/hid/enumerate.h"
#include "drivers/hid/transport.h"
#include "drivers/parameters.h"
#include "drivers/registry.h"

namespace hapticd {

struct HidPidParameters {
  double max_force = 5;
  double travel = 0.05;
  bool invert = false;
  double fallback = 0.2;
  bool fixed_direction = false;
  std::string path;
};
[[nodiscard]] const std::vector<Parameter<HidPidParameters>>& hidPidParameterTable();

struct HidPidSetup {
  HidPidParameters parameters;
  DeviceInfo info;
  std::function<std::unique_ptr<HidTransport>()> hid;
};

/** The setup of a URI for one of `plugged`, which need not be there yet. */
[[nodiscard]] Result<HidPidSetup> resolveHidPid(const DeviceUri& uri, const std::vector<HidFound>& plugged);

}  // namespace hapticd
