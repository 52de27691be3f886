// Friction of a local model while damping takes from the force of a hand that withdraws.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/model_rig.h"

namespace hapticd {
namespace {

/** By so little as one at rest, though damping has narrowed its cone; and not while what that leaves goes up and down.
 */
TEST(ModelFriction, AWithdrawingHandThatTurnsBackSticks) {
  constexpr double kStiff = 1000, kMu = 0.4, kOut = 0.05, kStep = 1e-3;
  for (const double back : {0.0, 0.05}) {
    hd_local_model m = modelOf(HD_MODEL_PLANE, kStiff, 80);  // It takes 4 of 10 N.
    m.material.friction_static = 1.5 * kMu;
    m.material.friction_dynamic = kMu;
    LoneModel plane(m);
    Vec3 hip(0, 0, -10 / kStiff), force;
    for (int i = 0; i < 200; ++i) force = plane.at(hip += Vec3(1e-4, 0, 0), Vec3(0.1, 0, 0));
    for (int i = 0; i < 20; ++i) {
      force = plane.at(hip += Vec3(1e-4, 0, kStep * kOut), Vec3(0.1, 0, (1 + 0.1 * (i % 2)) * kOut));
      ASSERT_TRUE(plane.model.slips()) << i;
    }
    const double r = std::abs(force.x()) / kStiff;
    (void)plane.at(hip += Vec3(back > 0 ? -back * r : 1e-4, 0, kStep * kOut), Vec3(0, 0, kOut));
    EXPECT_EQ(plane.model.slips(), back == 0);
  }
}

}  // namespace
}  // namespace hapticd
