/** @file
 * The drivers that haptic-bench device measures, each with its played device behind.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/link/io_device.h"
#include "rt/base/clock.h"

namespace haptic_bench {

/** Nanoseconds spent in the played device and its wire, which are not the driver's. */
struct PlayedCost {
  std::int64_t inside_ns = 0;
};

/** One driver on one played device; both live here. */
class PlayedDevice {
 public:
  virtual ~PlayedDevice() = default;
  [[nodiscard]] virtual hapticd::IoDevice& device() = 0;
  /** What the motors push with now, past the driver [N]. */
  [[nodiscard]] virtual hapticd::Vec3 force() const = 0;
  PlayedCost cost;
};

struct PlayedCase {
  std::string name;
  /** Its thread, or none; on that clock, which outlives it. */
  std::function<std::unique_ptr<PlayedDevice>(hapticd::Clock&, bool thread)> make;
};
[[nodiscard]] const std::vector<PlayedCase>& playedCases();

}  // namespace haptic_bench
