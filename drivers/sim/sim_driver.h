/** @file
 * sim:// for the registry.
 */
#pragma once

#include "drivers/driver.h"

namespace hapticd {

extern const Driver kSimDriver;

}  // namespace hapticd
