// What surfaces add to the contact, where a hand pushes a free body or takes up a tool.
#include <gtest/gtest.h>

#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kFloor;
using test::object;
using House = test::ToolHouse;

constexpr std::uint32_t kBall = makeObjectId(7, 1);

/** A relief can take all of the force that the material makes: then there is none on the body either. */
TEST(AddedForces, ABodyIsPushedWithTheForceThatItsReliefLeaves) {
  House house("sim://default");
  const test::TestRelief black(4, 4, [](auto, auto) { return 0; });
  house.meshes.publishTexture(0, &black.view);
  house.aim({0, 0, 0.06});
  house.run(1000);
  house.send(CommandKind::kAddObject, object(kBall, ShapeKind::kSphere, {0.01, 0, 0}, {-0.04, 0.001, 0.06}));
  SetBody body{};
  body.object = kBall;
  body.mass = 0.5;
  body.inertia[0] = body.inertia[1] = body.inertia[2] = 2e-5;
  house.send(CommandKind::kSetBody, body);
  SetSurface surface{kBall, 0, {}};
  surface.surface.relief = 1;
  surface.surface.relief_depth = 0.004;
  surface.surface.relief_size[0] = surface.surface.relief_size[1] = 0.1;
  house.send(CommandKind::kSetSurface, surface);
  house.run(10);
  double deepest = 0;
  for (int i = 0; i < 330; ++i) {
    house.aim({-0.1e-3 * i, 0, 0.06});
    house.run(1);
    deepest = std::max(deepest, house.out().contact.depth);
    ASSERT_LT(house.servo->cycle().bodies().body(0).body.twist().v.norm(), 1e-12) << i;
  }
  EXPECT_GT(deepest, 1e-3);
  EXPECT_LT(deepest, 0.004) << "the hand is in the relief, and feels nothing";
}

/** An impact rings once, and not on when the hand that had taken up a tool lets it go. */
TEST(AddedForces, TakingUpAToolEndsTheRingOfAnImpact) {
  House house;
  const auto ring = [&] { return house.out().guard.by_source[HD_SOURCE_TRANSIENT].norm(); };
  house.send(CommandKind::kSetSurface, SetSurface{kFloor, 0, test::ringing(20, 50, 0.2)});
  house.send(CommandKind::kArm, DeviceRef{0});
  house.aim({0, 0, -0.02});
  double struck = 0;
  for (int i = 0; i < 1000 && struck == 0; ++i) {
    house.run(1);
    struck = ring();
  }
  ASSERT_GT(struck, 0);
  house.send(CommandKind::kAttachTool, house.tool());
  house.run(20);
  ASSERT_TRUE(house.servo->cycle().tool(0).held());
  house.aim({0, 0, 0.04});
  house.run(3000);
  house.send(CommandKind::kDetachTool, DeviceRef{0});
  for (int i = 0; i < 50; ++i) {
    house.run(1);
    ASSERT_EQ(ring(), 0) << i;
  }
  ASSERT_FALSE(house.servo->cycle().tool(0).held());
}

}  // namespace
}  // namespace hapticd
