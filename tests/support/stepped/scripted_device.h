/** @file
 * A device that is where the test says and remembers what it was sent.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "rt/base/clock.h"
#include "rt/device.h"

namespace hapticd::test {

class ScriptedDevice final : public Device {
 public:
  ScriptedDevice() {
    info_.uri = "test://scripted";
    info_.max_force = 20;
  }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] Result<void> open() override { return {}; }
  void close() noexcept override { closed = true; }

  void read(std::int64_t now_ns, DeviceSample& out) noexcept override {
    reads.push_back(now_ns);
    if (clock != nullptr) clock->advance(read_cost_ns);
    read_cost_ns = 0;
    if (script) script(now_ns, sample);
    out = sample;
    out.t_ns = now_ns;
  }
  void write(std::int64_t, const DeviceCommand& command) noexcept override { sent.push_back(command); }
  void setIntent(const DeviceIntent& wish) noexcept override { intent = wish; }
  void safe() noexcept override { safed = true; }
  [[nodiscard]] Calibration calibration() const noexcept override { return calibrated; }
  [[nodiscard]] bool isOff() const noexcept override { return !hung; }
  void setUri(std::string uri) { info_.uri = std::move(uri); }
  void setButtons(std::uint32_t count) { info_.buttons = count; }
  void actuateRotation() {
    info_.actuated_rotation = true;
    info_.max_torque = 1;
  }

  DeviceSample sample = fresh();  ///< Returned by the next read.
  std::function<void(std::int64_t, DeviceSample&)> script;
  ManualClock* clock = nullptr;  ///< Moved on by read_cost_ns in the next read.
  std::int64_t read_cost_ns = 0;
  std::vector<std::int64_t> reads;
  std::vector<DeviceCommand> sent;
  DeviceIntent intent;
  Calibration calibrated = Calibration::kNotNeeded;
  bool safed = false;
  bool closed = false;
  bool hung = false;  ///< As if a thread of its own had not sent the zeros.

 private:
  static DeviceSample fresh() {
    DeviceSample s;
    s.fresh = true;
    return s;
  }
  DeviceInfo info_;
};

}  // namespace hapticd::test
