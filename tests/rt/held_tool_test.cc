// Contract 1 with a tool in the hand: servo and collide thread's work, in contact, with objects that come and go.
#include <gtest/gtest.h>

#include <iostream>
#include <thread>

#include "rt/collide/collider.h"
#include "rt/cycle/realtime.h"
#include "tests/support/detectors.h"
#include "tests/support/stepped/attach_tool.h"
#include "tests/support/stepped/house.h"

namespace hapticd {
namespace {

AttachTool box(std::uint32_t object) {
  DeviceInfo info;
  info.max_stiffness = 2000;
  info.actuated_rotation = true;
  return test::attachBox(object, {0.02, 0.04, 0.02}, info, 500);
}

TEST(HeldTool, ServoAndColliderAreClean) {
  test::House house("sim://default?dof=6&motion=tap&centre=0,0,0.02&depth=0.04&period=0.5&sway=0.3,0.2,0");
  Collider collider;
  house.servo->collider = &collider;
  const std::uint32_t tool = makeObjectId(30, 1), coming = makeObjectId(31, 1);
  AddObject order =
      test::solid(tool, ShapeKind::kBox, {500, 0, 0.5, 0.4}, {{0.5, 0, 0}, Quat::Identity()}, {0.01, 0.02, 0.01});
  house.order(CommandKind::kAddObject, order);
  house.order(CommandKind::kAttachTool, box(tool));
  // A brick that lies in the way, is pushed, and falls on whatever comes.
  order.object = makeObjectId(32, 1);
  order.p[0] = 0.02;
  order.p[2] = 0.03;
  house.order(CommandKind::kAddObject, order);
  SetBody brick{order.object, 1, 0.2, {}, {1e-4, 1e-4, 1e-4}, 1};
  house.order(CommandKind::kSetBody, brick);
  house.order(CommandKind::kSetGravity, SetGravity{{0, 0, -3}});
  order.p[2] = 0;
  test::RtViolations seen;
  bool trapped = false, came = false;
  std::uint64_t touching = 0, together = 0;
  const auto tick = [&](int i) {
    house.step();
    if (i % 2 == 0) collider.step(&house.clock);
    touching += house.servo->cycle().tool(0).last().touching;
    together += house.servo->cycle().bodies().joint().movers() > 1 ? 1 : 0;
  };
  std::thread([&] {
    disableDenormals();
    prefaultStack(128 * 1024);
    for (int i = 0; i < 1000; ++i) tick(i);
    const auto locked = lockMemory();
    if (!locked) std::cout << "memory is not locked: " << toString(locked.error()) << '\n';
    trapped = test::trapSystemCalls();
    for (int i = 0; i < 5000 && seen == test::RtViolations{}; i += 100) {
      order.object = coming;
      order.p[0] = 0.01;
      if (came) {
        house.order(CommandKind::kRemoveObject, ObjectRef{coming});
      } else {
        house.order(CommandKind::kAddObject, order);
      }
      came = !came;
      if (i % 500 == 0) {  // Orders that make bodies: their principal axes are found in the tick.
        house.order(CommandKind::kAttachTool, box(tool));
        brick.inertia[3] = 1e-5 * (i % 3);
        house.order(CommandKind::kSetBody, brick);
      }
      // It falls on the tool, which throws it off.
      const Vec3 above = house.servo->cycle().tool(0).tool().body().com() + Vec3(0.005, 0, 0.025);
      house.order(CommandKind::kObjectPose,
                  hd_object_pose{brick.object, 0, {above.x(), above.y(), above.z()}, {1}, {}, {}});
      test::RtScope scope;
      for (int k = 0; k < 100; ++k) tick(k);
      seen = scope.finish();
    }
  }).join();
  EXPECT_TRUE(trapped);
  EXPECT_EQ(seen, test::RtViolations{});
  EXPECT_GT(touching, 1000u) << "the test must press on something";
  EXPECT_GT(together, 100u) << "and push the brick";
  EXPECT_GT(collider.counters.queries.load(), 2000u);
}

}  // namespace
}  // namespace hapticd
