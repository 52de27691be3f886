/** @file
 * Files that a device URI makes the daemon read, or write to.
 */
#pragma once

#include <string>

#include "drivers/registry.h"

namespace hapticd {

/**
 * The recorded motion that making this device would read: the path of replay://, or `file` of sim://; "" for none. An
 * error of the reader tells of the file's lines, so whoever may name one may read it.
 */
[[nodiscard]] std::string namedMotion(const DeviceUri& uri);

/**
 * The serial line that opening this device would write to, whatever hangs on it: the tty of pantograph://; "" for none.
 */
[[nodiscard]] std::string namedLine(const DeviceUri& uri);

}  // namespace hapticd
