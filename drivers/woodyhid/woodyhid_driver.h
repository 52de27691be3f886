/** @file
 * woodyhid:// for the registry.
 */
#pragma once

#include "drivers/driver.h"

namespace hapticd {

extern const Driver kWoodyDriver;

}  // namespace hapticd
