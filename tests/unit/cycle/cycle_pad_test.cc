// What a soft fingertip feels of a surface with a relief.
#include <gtest/gtest.h>

#include <algorithm>

#include "rt/finger/fingerpad.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/solid.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

/** A fingertip that lies on a floor of one grey and turns by a twentieth of a radian. */
struct TurnedPad {
  double moment = 0, ground = 0, relief = 0;

  TurnedPad(double grey, double depth, double pressed = 0.003) {
    test::SteppedCycle hand(test::openConfig(20));
    const test::TestRelief picture(4, 4, [&](auto, auto) { return grey; });
    hand.meshes.publishTexture(0, &picture.view);
    const std::uint32_t floor = makeObjectId(1, 1);
    hand.add(test::solid(floor, ShapeKind::kPlane, {1000, 0, 2, 2}));
    if (depth > 0) {
      SetSurface surface{floor, 0, {}};
      surface.surface.relief = 1;
      surface.surface.relief_depth = depth;
      surface.surface.relief_size[0] = surface.surface.relief_size[1] = 0.02;
      hand.put(CommandKind::kSetSurface, surface);
    }
    SetFinger finger{};
    finger.law = static_cast<std::uint32_t>(PadLaw::kLinear);
    finger.radius = finger.arm = 5e-3;
    finger.stiffness = 0.1;
    finger.shows_moment = 1;
    hand.put(CommandKind::kSetFinger, finger);
    hand.at({0, 0, 0.005});
    hand.arm();
    for (int i = 0; i <= 300; ++i) {
      const double angle = 5e-4 * std::clamp(i - 150, 0, 100);
      hand.input->device[0].q = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
      const DeviceOutput& out = hand.at({0, 0, std::max(-pressed, 0.005 - 1e-4 * i)});
      moment = out.command.torque.z();
      ground = out.guard.by_source[HD_SOURCE_SURFACE].z();
      relief = out.guard.by_source[HD_SOURCE_TEXTURE].z();
    }
  }
};

TEST(CyclePad, AReliefThatTakesPartOfThePressureTakesThatOfTheMoment) {
  const TurnedPad smooth(1, 0);
  ASSERT_NEAR(smooth.moment, -0.1 * 0.05, 1e-6);
  ASSERT_NEAR(smooth.ground, 3, 1e-6);
  int less = 0;
  for (const double grey : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const TurnedPad pad(grey, 1e-3);
    less += pad.relief < -0.2 ? 1 : 0;
    EXPECT_NEAR(pad.moment / smooth.moment, std::min(1.0, 1 + pad.relief / pad.ground), 1e-9) << grey;
  }
  EXPECT_GE(less, 2);
}

/** Also of one that hardly presses. */
TEST(CyclePad, ATouchOfLessThanANewtonTurnsTheHandToo) {
  const TurnedPad smooth(1, 0, 8e-4), low(0, 8e-4, 8e-4);
  ASSERT_NEAR(low.ground, 0.8, 1e-9);
  EXPECT_LT(low.relief, -0.2);
  EXPECT_NEAR(low.moment / smooth.moment, 1 + low.relief / low.ground, 1e-9);
}

}  // namespace
}  // namespace hapticd
