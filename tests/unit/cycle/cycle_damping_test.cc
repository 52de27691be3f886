// What a contact damps and what the passivity controller adds to it, together, by way of the cycle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

/** The most that the guard damps [N s/m] while a hand shakes in a wall so stiff that it makes energy. */
double mostAddedIn(double wall_damping, double device_can) {
  CycleConfig config = test::openConfig(100);
  config.guard[0].energy_limit = 100;
  config.guard[0].max_damping = device_can;
  test::SteppedCycle hand(config);
  hand.add(test::solid(makeObjectId(1, 1), ShapeKind::kPlane, {20'000, wall_damping, 0, 0}));
  hand.arm();
  double most = 0;
  for (int i = 0; i < 3000; ++i) {
    const double z = i < 100 ? 0.001 : -0.5e-3 - 0.3e-3 * std::sin(2 * std::numbers::pi * 0.02 * (i - 100));
    const DeviceOutput& out = hand.at({0, 0, z});
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
