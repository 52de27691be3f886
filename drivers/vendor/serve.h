/** @file
 * The other end of a HelperDevice: what hapticd-vendor does.
 */
#pragma once

#include <atomic>

namespace hapticd {

/**
 * Serves one device over that socket until the daemon hangs up, the device is gone or `stop` turns true; the device is
 * then at zero and closed. A library that hangs ends the process with 3; while it opens the device, when the daemon has
 * been gone for `patience_ms`. The exit status: 0, or 1 if it never opened.
 */
[[nodiscard]] int serveVendor(int socket, const std::atomic<bool>& stop, int patience_ms = 15'000);

}  // namespace hapticd
