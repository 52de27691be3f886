/** @file
 * A played device before the kernel itself: by vhci_hcd, a host controller without hardware. Programs then find it as
 * any USB device, through udev, usbfs and libusb. Needs root and the module vhci_hcd.
 */
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "tools/haptic-emu/usb_model.h"

namespace haptic_emu {

struct VhciOptions {
  std::string folder = "/sys/devices/platform/vhci_hcd.0";
  int port = 0;
};

/**
 * Plugs `model` in and plays it in real time until `stop`, or until the kernel lets it go. `each` is called every
 * 250 us of it. When the model unplugs itself it is plugged out of the kernel, and in again when it is back.
 */
[[nodiscard]] hapticd::Result<void> playToKernel(UsbModel& model, const VhciOptions& options,
                                                 const std::atomic<bool>& stop,
                                                 const std::function<void(std::int64_t now_ns)>& each);

}  // namespace haptic_emu
