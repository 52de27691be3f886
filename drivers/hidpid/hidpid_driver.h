/** @file
 * hidpid:// for the registry.
 */
#pragma once

#include "drivers/driver.h"

namespace hapticd {

extern const Driver kHidPidDriver;

}  // namespace hapticd
