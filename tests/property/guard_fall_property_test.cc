// What nobody asks for any more goes, whatever the slew limit.
#include <gtest/gtest.h>

#include "tests/support/for_seeds.h"
#include "tests/unit/guard/guard_rig.h"

namespace hapticd {
namespace {

/** What was sent, and what may become of it in one tick: by the slew, or smaller by what goes in kFall_s. */
void expectFall(const Vec3& from, const Vec3& to, double slew) {
  const double change = (to - from).norm();
  if (change <= slew + 1e-12) return;
  ASSERT_LT(to.norm(), from.norm()) << "more than the slew, and not smaller";
  ASSERT_LE(change, from.norm() * 1e-3 / Guard::kFall_s * (1 + 1e-9));
}

/** How far x still is along what it was. */
double stillAlong(const Vec3& x, const Vec3& was) { return x.dot(was) / was.squaredNorm(); }

/** A slew limit is for what rises. Set while the hand is pushed, however low, it keeps nobody pushed. */
TEST(GuardProperty, HoweverSlowTheSlewWhatIsNotAskedForFalls) {
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    GuardConfig config = rigConfig();
    config.ramp_ns = 0;
    GuardRig rig(config);
    Wrench& client = rig.in.source[HD_SOURCE_CLIENT];
    client = {random.vector(4.5), random.vector(0.17)};
    rig.armFully();
    rig.in.gripper_force = random.in(-4, 4);
    rig.step(50);
    const DeviceCommand full = rig.out.command;
    GuardLimits slow = rig.guard.limits();
    slow.force_slew = random.once(2) ? 0 : random.in(0, 2);
    slow.torque_slew = random.once(2) ? 0 : random.in(0, 0.1);
    ASSERT_EQ(rig.guard.setLimits(slow), ErrorCode::kOk);
    const double share = random.in(-1, 0.3);  // Less the same way, or the other way.
    client.force *= share;
    client.torque *= share;
    rig.in.gripper_force *= share;
    for (int i = 0; i < 1000; ++i) {
      const DeviceCommand last = rig.out.command;
      const DeviceCommand& now = rig.step().command;
      expectFall(last.force, now.force, slow.force_slew * 1e-3);
      expectFall(last.torque, now.torque, slow.torque_slew * 1e-3);
      expectFall({last.gripper_force, 0, 0}, {now.gripper_force, 0, 0}, slow.force_slew * 1e-3);
      if (testing::Test::HasFatalFailure()) return;
    }
    const DeviceCommand& now = rig.out.command;
    const double most = std::max(share, 0.0) + 0.02;
    EXPECT_LT(stillAlong(now.force, full.force), most);
    EXPECT_LT(stillAlong(now.torque, full.torque), most);
    EXPECT_LT(now.gripper_force / full.gripper_force, most);
  });
}

}  // namespace
}  // namespace hapticd
