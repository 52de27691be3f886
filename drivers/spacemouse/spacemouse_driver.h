/** @file
 * spacemouse:// for the registry.
 */
#pragma once

#include "drivers/driver.h"

namespace hapticd {

extern const Driver kSpaceMouseDriver;

}  // namespace hapticd
