/** @file
 * The HID devices of this machine, as hidapi lists them.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

/** A device node; nothing is opened for it. */
struct HidFound {
  std::string path;  ///< /dev/hidrawN
  std::uint16_t vendor = 0, product = 0;
  std::string serial, manufacturer, name;  ///< UTF-8; empty where the device has none.
  std::uint16_t usage_page = 0;
  std::string instance;  ///< The kernel's name for what is plugged in, "0003:16C0:0486.0007", which it uses once.
  std::string socket;    ///< Where, in sysfs: "/sys/.../1-2/1-2:1.0". Both empty where that cannot be read.
  std::vector<std::uint8_t> descriptor;  ///< Of its reports, from sysfs; empty if it cannot be read.
};

/** Which of them is meant. All that is set must fit. */
struct HidWanted {
  std::function<bool(const HidFound&)> fits;  ///< The driver's own condition.
  std::string path;                           ///< "" for any.
  std::string serial;                         ///< "" for any.
  std::string what;                           ///< For errors: "a SpaceMouse".
  std::optional<HidFound> same{};             ///< This one, plugged in again.
};

/** hidapi keeps its last error in one place for all threads: held around every call that lists or opens. */
[[nodiscard]] std::mutex& hidapiLock();

/** Each node once, with its first usage. Not for the servo: it reads sysfs and allocates. */
[[nodiscard]] std::vector<HidFound> findHid();

/**
 * The first of `found` that is meant; kNotFound lists those that the driver could serve. The same is of the same kind
 * and serial number; without one it stands in the same socket, for nothing else tells two of a kind apart. In its
 * socket it is found whatever number its node has got.
 */
[[nodiscard]] Result<HidFound> choose(const std::vector<HidFound>& found, const HidWanted& wanted);

/** The serial number that a URI's authority asks for; "" for any. */
[[nodiscard]] inline std::string serialNamed(const std::string& authority) {
  return authority == "default" ? std::string() : authority;
}
/** The authority of a URI for that serial number: "default" where there is none. */
[[nodiscard]] inline std::string authorityOf(const std::string& serial) { return serial.empty() ? "default" : serial; }

}  // namespace hapticd
