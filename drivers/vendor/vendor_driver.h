/** @file
 * Devices that only their vendors' closed libraries can drive, each through hapticd-vendor, a process of its own.
 */
#pragma once

#include <vector>

#include "drivers/driver.h"
#include "drivers/link/device_io.h"
#include "drivers/vendor/helper_process.h"
#include "rt/base/clock.h"

namespace hapticd {

extern const Driver kDhdDriver;
extern const Driver kOpenHapticsDriver;

/** What hapticd-vendor drives: the device of a dhd:// or openhaptics:// URI, in this process. */
[[nodiscard]] Result<std::unique_ptr<DeviceIo>> makeVendorIo(const DeviceUri& uri, Clock& clock);

/** As Driver::zero, with a helper from there. */
[[nodiscard]] Result<void> zeroVendor(const DeviceUri& uri, const HelperOptions& options);

/** An SDK that hapticd can use, and where its library is; "" where it is not installed. */
struct SdkPresence {
  std::string_view name, scheme, library;
  std::string path;
};
[[nodiscard]] std::vector<SdkPresence> vendorSdks();

}  // namespace hapticd
