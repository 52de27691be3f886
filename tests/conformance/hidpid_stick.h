/** @file
 * A played joystick with force feedback behind its driver, in virtual time.
 */
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/hidpid/hidpid_io.h"
#include "drivers/link/io_device.h"
#include "tests/support/stepped/push.h"
#include "tests/support/time.h"
#include "tools/haptic-emu/hidpid/pid_model.h"
#include "tools/haptic-emu/in_process_hid.h"

namespace hapticd::test {

struct Stick {
  explicit Stick(const haptic_emu::PidVariant& variant = {},
                 std::vector<std::pair<std::string, std::string>> query = {})
      : model(variant) {
    query.emplace_back("max_force", "4");
    auto resolved = resolveHidPid({"hidpid", "default", std::move(query)}, {});
    EXPECT_TRUE(resolved.ok());
    resolved->hid = [this] { return std::make_unique<haptic_emu::InProcessHid>(model, clock); };
    auto made = std::make_unique<HidPidIo>(std::move(*resolved));
    io = made.get();
    device = std::make_unique<IoDevice>(std::move(made), IoOptions{.thread = false}, clock);
    opened = device->open();
  }
  /** A servo at 1 kHz; returns how many readings were fresh. */
  int run(int cycles, const DeviceCommand& command) {
    int fresh = 0;
    for (int i = 0; i < cycles; ++i) {
      device->read(clock.now(), sample);
      fresh += sample.fresh ? 1 : 0;
      device->write(clock.now(), command);
      advance(1);
    }
    return fresh;
  }
  /** World, wire and I/O thread, without a servo. */
  void advance(int ms) {
    for (int i = 0; i < ms; ++i) {
      if (held) model.hand.place(at);
      device->pump(clock.now() + kMs);
      model.advance(clock.now());
    }
  }
  /** The world alone: this process is dead. */
  void die(int ms) {
    clock.advance(ms * kMs);
    model.advance(clock.now());
  }
  void hold(const Vec3& p) {
    held = true;
    at = p;
  }

  haptic_emu::PidModel model;
  ManualClock clock;
  HidPidIo* io = nullptr;
  std::unique_ptr<IoDevice> device;
  Result<void> opened;
  DeviceSample sample;
  bool held = false;
  Vec3 at = Vec3::Zero();
};

}  // namespace hapticd::test
