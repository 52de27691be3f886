/** @file
 * Which USB devices are plugged in, as the kernel tells in sysfs. Opens no device and needs no rights.
 */
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

/** One device on the bus. */
struct UsbFound {
  std::uint16_t vendor = 0, product = 0;
  std::uint32_t bus = 0, address = 0;  ///< Change with each plugging.
  std::string path;                    ///< "1-2.3": bus and ports; stays while it is plugged there.
  std::string serial, manufacturer, name;

  /** /dev/bus/usb/BBB/DDD */
  [[nodiscard]] std::string node() const;
};

inline constexpr std::string_view kUsbDevicesFolder = "/sys/bus/usb/devices";

/** All of that vendor and product, by path. */
[[nodiscard]] std::vector<UsbFound> findUsb(std::uint16_t vendor, std::uint16_t product,
                                            std::string_view folder = kUsbDevicesFolder);

/**
 * The one that `which` names: its serial number or its path; "default" or "" the first. kNotFound lists what there is;
 * `what` is the kind of device, for the message.
 */
[[nodiscard]] Result<UsbFound> chooseUsb(const std::vector<UsbFound>& found, std::string_view which,
                                         std::string_view what);

/** The driver that holds interface `number`: "usbfs" is another program, "ftdi_sio" and the like the kernel's; or "".
 */
[[nodiscard]] std::string usbInterfaceDriver(const UsbFound& device, std::uint8_t number,
                                             std::string_view folder = kUsbDevicesFolder);

}  // namespace hapticd
