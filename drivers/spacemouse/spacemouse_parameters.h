/** @file
 * Keys of a spacemouse:// URI, and the device they make.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/hid/enumerate.h"
#include "drivers/hid/transport.h"
#include "drivers/parameters.h"
#include "drivers/registry.h"

namespace hapticd {

struct SpaceMouseParameters {
  std::string mode = "displacement";
  double travel = 0.05, turn = 0.5;
  double speed = 0.1, turn_speed = 1;
  double dead_zone = 0.05;
  double box = 0.1;
  std::uint64_t deadman = 0;
  std::string path;
};
[[nodiscard]] const std::vector<Parameter<SpaceMouseParameters>>& spaceMouseParameterTable();

struct SpaceMouseSetup {
  SpaceMouseParameters parameters;
  DeviceInfo info;
  std::function<std::unique_ptr<HidTransport>()> hid;
};

/** The setup of a URI for one of `plugged`, which need not be there yet. */
[[nodiscard]] Result<SpaceMouseSetup> resolveSpaceMouse(const DeviceUri& uri, const std::vector<HidFound>& plugged);
[[nodiscard]] bool isSpaceMouse(const HidFound& found);

}  // namespace hapticd
