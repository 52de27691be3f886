/** @file
 * falcon:// for the registry.
 */
#pragma once

#include "drivers/driver.h"

namespace hapticd {

extern const Driver kFalconDriver;

}  // namespace hapticd
