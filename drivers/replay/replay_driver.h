/** @file
 * replay:// for the registry.
 */
#pragma once

#include "drivers/driver.h"

namespace hapticd {

extern const Driver kReplayDriver;

}  // namespace hapticd
