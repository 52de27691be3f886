/** @file
 * What a driver folder offers to the registry: one Driver, named once in the table of registry.cc.
 */
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "drivers/registry.h"

namespace hapticd {

/** A family of devices behind one URI scheme. Plain functions: a table of these is all the registry holds. */
struct Driver {
  std::string_view scheme;
  std::string_view form;  ///< How its URIs look, for error messages.
  bool real = false;      ///< Hardware; the registry prefers it when no URI is given.
  /** Appends what is attached; opens nothing. */
  void (*find)(std::vector<DeviceFound>& found) = nullptr;
  /** Makes, but does not open, the device of that URI (its scheme is this driver's). */
  Result<std::unique_ptr<Device>> (*make)(const DeviceUri& uri) = nullptr;
  /**
   * Sets the forces of that device to zero from a fresh process, when the daemon that armed it is dead: no state, less
   * than half a second, no harm to a device that is zero already. Null: dead daemon, no force.
   */
  Result<void> (*zero)(const DeviceUri& uri) = nullptr;
};

}  // namespace hapticd
