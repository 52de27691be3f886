/** @file
 * What a servo writes to a device that shall push.
 */
#pragma once

#include "rt/device.h"

namespace hapticd::test {

inline DeviceCommand push(const Vec3& force) {
  DeviceCommand command;
  command.enabled = true;
  command.force = force;
  return command;
}

}  // namespace hapticd::test
