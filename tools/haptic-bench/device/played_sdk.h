/** @file
 * Devices behind their vendors' SDKs, which tests play in a library: the driver in virtual time, and a real
 * hapticd-vendor with that library in it.
 */
#pragma once

#include <memory>
#include <string>

#include "rt/base/clock.h"
#include "rt/base/histogram.h"
#include "tools/haptic-bench/device/played_device.h"

namespace haptic_bench {

/** The played SDK that was built with this; "" if it was built without tests, or is installed. */
[[nodiscard]] std::string playedSdk();

/** Force Dimension's driver over that library, in this process; nothing else in it may hold the played device. */
[[nodiscard]] std::unique_ptr<PlayedDevice> playDhd(const std::string& sdk, hapticd::Clock& clock);

/** What a servo of this process sees of a device in hapticd-vendor's. */
struct HelperFigures {
  hapticd::Histogram::Summary round_trip;  ///< From a command to a reading after it, both by the servo's ticks.
  hapticd::Histogram::Summary age;         ///< Of a reading when the servo takes it.
  double servo_us = 0;                     ///< Time of the servo in the device's read and write, a tick.
  double helper_us = 0;                    ///< Processor time of all of hapticd-vendor, SDK and kernel too, a tick.
};
/** A servo of 1 kHz for that long on this machine's clock. Throws Failure if the device does not open. */
[[nodiscard]] HelperFigures runHelper(const std::string& scheme, const std::string& sdk, double seconds);

}  // namespace haptic_bench
