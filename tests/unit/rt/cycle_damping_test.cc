// What a contact damps and what the passivity controller adds to it, together, by way of the cycle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "rt/cycle/cycle.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

/** The most that the guard damps [N s/m] while a hand shakes in a wall so stiff that it makes energy. */
double mostAddedIn(double wall_damping, double device_can) {
  CycleConfig config;
  config.guard[0].limits = {100, 1, 1e6, 1e3, 1, 10, 50, 50};
  config.guard[0].ramp_ns = kMs;
  config.guard[0].energy_limit = 100;
  config.guard[0].max_damping = device_can;
  const MeshTable meshes;
  const auto cycle = std::make_unique<Cycle>(config, meshes);
  const auto input = std::make_unique<CycleInput>();
  const auto output = std::make_unique<CycleOutput>();
  AddObject wall{};
  wall.object = makeObjectId(1, 1);
  wall.flags = HD_OBJECT_ENABLED;
  wall.shape.kind = static_cast<std::uint32_t>(ShapeKind::kPlane);
  wall.material = {20'000, wall_damping, 0, 0};
  wall.q[0] = 1;
  input->command[0].kind = CommandKind::kAddObject;
  input->command[0].as<AddObject>() = wall;
  input->command[1].kind = CommandKind::kArm;
  input->command[1].as<DeviceRef>() = {0};
  input->command_count = 2;
  double most = 0;
  for (int i = 0; i < 3000; ++i) {
    const double z = i < 100 ? 0.001 : -0.5e-3 - 0.3e-3 * std::sin(2 * std::numbers::pi * 0.02 * (i - 100));
    ++input->tick;
    input->now_ns += kMs;
    DeviceSample& sample = input->device[0];
    sample.t_ns = input->now_ns;
    sample.p = Vec3(0, 0, z);
    sample.fresh = true;
    cycle->step(*input, *output);
    input->command_count = 0;
    const DeviceOutput& out = output->device[0];
    EXPECT_EQ(out.guard.fault, HD_FAULT_NONE);
    const double v = out.velocity.v.z();
    if (i > 2000 && std::abs(v) > 0.02) most = std::max(most, (out.contact.force.z() - out.command.force.z()) / v);
  }
  return most;
}

// Together no more than one and a half times what the device can show, and the controller alone no more than once.
TEST(CycleDamping, TheControllerAddsWhatTheContactLeaves) {
  for (const double can : {2.0, 4.0}) {
    const double alone = mostAddedIn(0, can);
    EXPECT_GT(alone, can / 2);
    for (const double wall : {0.25, 0.5, 0.6, 0.75, 1.0, 1.25, 1.4, 1.5, 2.0, 3.0}) {  // Of what it can.
      EXPECT_NEAR(mostAddedIn(wall * can, can) / alone, std::clamp(1.5 - wall, 0.0, 1.0), 1e-9)
          << wall << " of " << can;
    }
  }
}

}  // namespace
}  // namespace hapticd
