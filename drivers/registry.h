/** @file
 * From device URIs to devices: scheme://authority?key=value&... (thesis section 5.2: `phantom://default?mode=direct`).
 */
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rt/base/error.h"
#include "rt/device.h"

namespace hapticd {

/** A parsed URI; query keys keep their order, values are percent-decoded. */
struct DeviceUri {
  std::string scheme;
  std::string authority;  ///< Preset, serial, or file for replay.
  std::vector<std::pair<std::string, std::string>> query;
  /** Folder in which the motions that it names must lie, whatever links lead there; "": anywhere. No part of its text.
   */
  std::string within{};
};

/**
 * kInvalidArgument names the character at fault. Scheme in lower case; authority and values percent-decoded and free of
 * control characters; keys are letters, digits, '_', '-' and '.', each at most once. At most kMaxUriBytes. Fuzzed.
 */
[[nodiscard]] Result<DeviceUri> parseDeviceUri(std::string_view text);
inline constexpr std::size_t kMaxUriBytes = 4096;

/** The text that parses to `uri` again. */
[[nodiscard]] std::string formatDeviceUri(const DeviceUri& uri);

/** A device found but not opened. */
struct DeviceFound {
  DeviceInfo info;
  bool real = false;  ///< Hardware, not a simulator.
};

/** Whether devices of that scheme are hardware, which can hurt. */
[[nodiscard]] bool isHardware(std::string_view scheme) noexcept;

/**
 * Whether the device of the canonical URI `uri` is what `asked`, another, asks for: the same; or the same hardware, if
 * `asked` says nothing of how to drive it. Several devices that keys tell apart (path, serial) are not the same.
 */
[[nodiscard]] bool isAskedFor(std::string_view uri, std::string_view asked) noexcept;

/** What this machine has: real devices first, then the simulator. Control thread. */
[[nodiscard]] std::vector<DeviceFound> findDevices();

/**
 * The URI of which of these has that serial number; of the first real one for "", else of the simulator. kNotFound
 * lists what there is.
 */
[[nodiscard]] Result<std::string> chooseDevice(std::string_view serial, const std::vector<DeviceFound>& found);

/**
 * Makes (does not open) the device of that URI or serial; of a serial it looks at the buses. Empty: the first real
 * device, else sim://default. kNotFound names the scheme or serial and lists what there is; kUnsupported says of a
 * known scheme why it cannot be opened here; kInvalidArgument names the key of the query that is wrong. Recorded
 * motions are found and judged now, kPermissionDenied where they do not lie in `within` (DeviceUri::within), and read
 * by open().
 */
[[nodiscard]] Result<std::unique_ptr<Device>> makeDevice(std::string_view uri_or_serial,
                                                         const std::string& within = {});

/**
 * Sets the forces of a device to zero from a fresh process, when the daemon that armed it is dead. Errors as
 * makeDevice, and as the driver's opening: kDeviceBusy when a living program still holds it.
 */
[[nodiscard]] Result<void> zeroDevice(std::string_view uri);

}  // namespace hapticd
