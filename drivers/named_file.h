/** @file
 * What a device URI names that is not any client's to choose: files that the daemon reads or writes to, a model.
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

/** The model as which this drives hardware that cannot tell it itself: of woodyhid://; "" for the usual one, and none.
 */
[[nodiscard]] std::string namedModel(const DeviceUri& uri);

}  // namespace hapticd
