/** @file
 * The few calls of the kernel's usbfs that must work where libusb cannot: in a signal handler, and in a fresh process
 * after the daemon died.
 */
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "drivers/usb/transport.h"
#include "drivers/usb/usb_list.h"

namespace hapticd {

/** One packet to an OUT endpoint of a claimed interface, and waits for it at most timeout_ms. Async-signal-safe. */
[[nodiscard]] bool usbfsSend(int fd, std::uint8_t endpoint, std::span<const std::uint8_t> bytes,
                             std::uint32_t timeout_ms) noexcept;

/**
 * Opens the device, takes the interface, a kernel driver off it if there is one, sends the packet `times` times and
 * lets go. Needs nothing but the right to the node. kDeviceBusy when a living program holds it; kDeviceGone when it is
 * not there; kTimeout when it does not take the packet. At most times * timeout_ms.
 */
[[nodiscard]] Result<void> usbfsSendOnce(const UsbFound& device, const UsbInterface& interface,
                                         std::span<const std::uint8_t> bytes, int times, std::uint32_t timeout_ms);

/** What errno means for a device node that could not be opened or claimed. */
[[nodiscard]] Error usbOpenError(const UsbFound& device, int refused, const std::string& held_by);

}  // namespace hapticd
