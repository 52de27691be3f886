/** @file
 * A device that can be opened and nothing else: it stands at the origin and takes any force.
 */
#pragma once

#include <string>

#include "drivers/link/slow_to_open.h"
#include "rt/device.h"

namespace hapticd::test {

class StillDevice : public Device, public SlowToOpen {
 public:
  const DeviceInfo& info() const noexcept override { return info_; }
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override {
    sample.t_ns = now_ns;
    sample.fresh = true;
  }
  void write(std::int64_t, const DeviceCommand&) HD_RT override {}
  [[nodiscard]] std::int64_t commandLife_ns() const noexcept override { return 7'000'000; }
  void safe() noexcept override {}

 protected:
  StillDevice(const char* driver, std::string uri, std::string serial = {}) {
    info_.uri = std::move(uri);
    info_.serial = std::move(serial);
    info_.driver = driver;
    info_.max_force = 5;
  }
  /** For what open() refuses. */
  [[nodiscard]] Error silence() const {
    return {ErrorCode::kDeviceGone, info_.uri, "it does not answer", "plug it in"};
  }

 private:
  DeviceInfo info_;
};

}  // namespace hapticd::test
