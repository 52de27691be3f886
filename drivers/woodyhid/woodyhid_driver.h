/** @file
 * woodyhid:// for the registry.
 */
#pragma once

#include <string_view>

#include "drivers/driver.h"

namespace hapticd {

extern const Driver kWoodyDriver;
/** Of a URI that names none. Boards do not tell what arm hangs on them. */
inline constexpr std::string_view kUsualWoodyModel = "woodenhaptics_v2015";

}  // namespace hapticd
