/** @file
 * The device URIs of a configuration, looked at before anything is opened.
 */
#pragma once

#include "daemon/main/options.h"
#include "rt/base/error.h"

namespace hapticd {

/**
 * Brings the URIs of the [[device]] entries to the form by which open devices are known: another spelling of a device
 * must not lose its limits. Refuses a URI that no driver takes, and a second entry of a device as far as URIs tell;
 * serial numbers and schemes that this build cannot open stay as they are.
 */
[[nodiscard]] Result<void> resolveDeviceLimits(LoadedConfig& loaded);

/**
 * Refuses a URI of a group, or of --device, that could not be opened whatever is attached, or that names a device for
 * the second time. Serial numbers are not looked for.
 */
[[nodiscard]] Result<void> checkGroupUris(const Options& options);

}  // namespace hapticd
