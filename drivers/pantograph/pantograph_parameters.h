/** @file
 * Keys of a pantograph:// URI, and the device they make.
 */
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "drivers/pantograph/pantograph_kinematics.h"
#include "drivers/parameters.h"
#include "drivers/registry.h"
#include "drivers/serial/transport.h"

namespace hapticd {

struct PantographParameters {
  double torque_scale = 0.1;
  double max_force = 2;
  double counts_per_turn = 13'824;
  double centre = 0.07;
  bool clockwise = false;
};
[[nodiscard]] const std::vector<Parameter<PantographParameters>>& pantographParameterTable();

struct PantographSetup {
  PantographParameters parameters;
  DeviceInfo info;
  std::function<std::unique_ptr<SerialTransport>()> line;
};

/** kInvalidArgument if the URI names no tty. The board need not be plugged in yet. */
[[nodiscard]] Result<PantographSetup> resolvePantograph(const DeviceUri& uri);

}  // namespace hapticd
