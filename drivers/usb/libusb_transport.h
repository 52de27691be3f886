/** @file
 * UsbTransport over libusb's asynchronous transfers.
 */
#pragma once

#include "drivers/usb/transport.h"
#include "drivers/usb/usb_list.h"

namespace hapticd {

/**
 * Opens the device's node and claims the interface; a kernel driver on it is taken off and given back at the end.
 * Clock: CLOCK_MONOTONIC. Errors: kDeviceBusy (another program has it), kPermissionDenied, kDeviceGone, kSystem.
 */
[[nodiscard]] Result<std::unique_ptr<UsbTransport>> openLibusb(const UsbFound& device, const UsbInterface& interface);

}  // namespace hapticd
