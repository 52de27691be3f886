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

/** A real clock that begins at zero, as played devices do. */
class FromNow final : public hapticd::Clock {
 public:
  FromNow() : start_ns_(clock_.now()) {}
  [[nodiscard]] std::int64_t now() HD_RT override { return clock_.now() - start_ns_; }
  void sleepUntil(std::int64_t t_ns) HD_RT override { clock_.sleepUntil(t_ns + start_ns_); }

 private:
  hapticd::MonotonicClock clock_;
  std::int64_t start_ns_;
};

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
  double least_hz = 900;  ///< Readings that it must give.
  bool motors = true;
  bool thread = true;  ///< It can have one here; else it is measured in virtual time alone.
};
[[nodiscard]] const std::vector<PlayedCase>& playedCases();

}  // namespace haptic_bench
