/** @file
 * A cycle by itself, stepped by hand: no servo, device or clock.
 */
#pragma once

#include <memory>

#include "rt/cycle/cycle.h"
#include "tests/support/stepped/solid.h"

namespace hapticd::test {

/** One device, whose force alone is limited to what a test meets, armed within a tick. */
[[nodiscard]] inline CycleConfig openConfig(double force) {
  CycleConfig config;
  config.guard[0].limits = {force, 1, 1e6, 1e3, 1, 10, 50, 50};
  config.guard[0].ramp_ns = config.period_ns;
  return config;
}

struct SteppedCycle {
  explicit SteppedCycle(const CycleConfig& config = {}) : cycle(std::make_unique<Cycle>(config, meshes)) {}

  /** For the next step. */
  template <class T>
  Command& put(CommandKind kind, const T& payload, std::uint32_t session = kControlSession) {
    return input->command[input->command_count++] = makeCommand(kind, payload, session);
  }
  void add(const AddObject& object) { put(CommandKind::kAddObject, object); }
  /** The collide thread's, to what was asked in the last step. */
  void answer(ToolContacts found) {
    found.tick = input->tick;
    put(CommandKind::kToolContacts, found);
  }
  void arm() { put(CommandKind::kArm, DeviceRef{0}); }

  /** A period later. What is fresh was read then. */
  const DeviceOutput& step() {
    ++input->tick;
    input->now_ns += cycle->config().period_ns;
    for (DeviceSample& sample : input->device) {
      if (sample.fresh) sample.t_ns = input->now_ns;
    }
    cycle->step(*input, *output);
    input->command_count = 0;
    return output->device[0];
  }
  /** With the first device at p. */
  const DeviceOutput& at(const Vec3& p) {
    input->device[0].p = p;
    input->device[0].fresh = true;
    return step();
  }

  MeshTable meshes;
  std::unique_ptr<Cycle> cycle;
  std::unique_ptr<CycleInput> input = std::make_unique<CycleInput>();
  std::unique_ptr<CycleOutput> output = std::make_unique<CycleOutput>();
};

}  // namespace hapticd::test
