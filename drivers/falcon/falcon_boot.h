/** @file
 * Brings a Falcon from the plug to run packets. Its firmware is lost with its power, so the host loads it each time.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "drivers/usb/transport.h"
#include "rt/base/clock.h"

namespace hapticd::falcon {

/**
 * Until the device answers run packets. One that answers already is left as it is: homing is not lost. Else `firmware`
 * is loaded, the whole again when an echo is wrong, ten times at most and within ten seconds; then it is kTimeout.
 * Firmware that is empty while the device needs some is kNotFound. kDeviceGone, kCancelled when `stop` turns true.
 * No force is sent.
 */
[[nodiscard]] Result<void> boot(UsbTransport& usb, Clock& clock, std::span<const std::uint8_t> firmware,
                                const std::atomic<bool>& stop);

}  // namespace hapticd::falcon
