/** @file
 * pantograph:// for the registry.
 */
#pragma once

#include "drivers/driver.h"

namespace hapticd {

extern const Driver kPantographDriver;

}  // namespace hapticd
