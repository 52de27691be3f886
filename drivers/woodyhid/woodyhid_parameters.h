/** @file
 * Keys of a woodyhid:// URI, and the device they make.
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
#include "drivers/woodyhid/woody_model.h"
#include "drivers/woodyhid/woodyhid_counters.h"

namespace hapticd {

struct WoodyParameters {
  double gravity = 1;
  double max_current = 3;
  bool calibrated = false;
  std::string path;
  std::string serial;
};
[[nodiscard]] const std::vector<Parameter<WoodyParameters>>& woodyParameterTable();

/** All that an arm needs to run. */
struct WoodySetup {
  const WoodyModel* model = nullptr;
  WoodyParameters parameters;
  DeviceInfo info;
  std::function<std::unique_ptr<HidTransport>()> hid;
  std::shared_ptr<WoodyCounters> counters;  ///< The process's.
};

/** The setup of a URI; the device need not be plugged in yet. kInvalidArgument lists the models. */
[[nodiscard]] Result<WoodySetup> resolveWoody(const DeviceUri& uri);
/** Whether it can be one: the firmware shares its IDs with whatever else is made of the same boards. */
[[nodiscard]] bool mayBeWoody(const HidFound& found);

}  // namespace hapticd
