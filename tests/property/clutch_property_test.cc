// A clutch that is held and let go at random by a random hand: nothing jumps, and no clutch is a pump.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/for_seeds.h"
#include "tests/support/stepped/mount_at.h"
#include "tests/support/stepped/solid.h"
#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/stepped/wandering_hand.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kClutchFloor = makeObjectId(1, 1), kClutchBall = makeObjectId(2, 1);
const Vec3 kClutchBallAt{0.02, 0, 0};

/** Springs alone, which give back what they got; the guard does not help. */
class Springs : public test::SteppedCycle {
 public:
  explicit Springs(Random& random) : SteppedCycle(config()), random_(random), hand_(random, 0.01) {
    const double s = random.once(2) ? 1 : std::exp(random.in(-1, 1));
    put(CommandKind::kSetMount, test::mountAt(Pose{Vec3::Zero(), random.pose(1).q}, 0, s));
    put(CommandKind::kAddSession, SessionRef{0, 0, 1});
    add(test::solid(kClutchFloor, ShapeKind::kPlane, {500, 0, 0, 0}, {{0, 0, -0.005}, Quat::Identity()}));
    add(test::solid(kClutchBall, ShapeKind::kSphere, {300, 0, 0, 0}, {kClutchBallAt, Quat::Identity()}, {0.01, 0, 0}));
    hd_local_model wall{};
    wall.kind = HD_MODEL_PLANE;
    wall.lease_ns = 60'000'000'000;
    wall.material = {200, 0, 0, 0};
    store(random.vector(1).normalized(), wall.normal);
    put(CommandKind::kLocalModel, wall, 0);
    arm();
    input->device[0].buttons = 0;
    at({0, 0, 0});
  }
  static CycleConfig config() {
    CycleConfig c = test::openConfig(50);
    c.guard[0].passivity = false;
    c.guard[0].small_force = 1e3;
    c.guard[0].limits.power = c.guard[0].limits.active_power = 1000;
    return c;
  }
  /** At most 0.1 m/s; whoever holds the clutch does as they like. */
  const DeviceOutput& next() {
    if (random_.once(80)) put(CommandKind::kSetClutch, SetClutch{0, held_ = held_ == 0 ? 1u : 0u, 0, 0, {}});
    const Vec3 from = input->device[0].p;
    return at(from + clampNorm(hand_.next() - from, 1e-4));
  }

 private:
  Random& random_;
  test::WanderingHand hand_;
  std::uint32_t held_ = 0;
};

TEST(ClutchProperty, IsNoPump) {
  int clutched = 0, felt = 0, rising = 0;
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    Springs world(random);
    // What the hand has put in, less what it got, since the clutch was let go: nothing was tensed then that is felt. A
    // wall that holds its force for a tick gives k dx^2 / 2 too much.
    double received = 0, brought = 0, rounding = 0;
    Vec3 force = Vec3::Zero(), last = world.input->device[0].p;
    for (int tick = 0; tick < 6000; ++tick) {
      SCOPED_TRACE(tick);
      const double weight = world.cycle->clutch(0).weight();
      const bool off = world.cycle->clutch(0).frozen();
      const DeviceOutput& out = world.next();
      const Vec3 moved = world.input->device[0].p - last;
      received -= force.dot(moved);
      rounding += 0.5 * 4000 * moved.squaredNorm();
      const bool rises = world.cycle->clutch(0).weight() > weight;
      brought += rises ? Clutch::kMostPower * 1e-3 : 0;
      if (off) received = brought = rounding = 0;
      // Half more: a hand that presses on while it rises finds more than the last tick's springs held.
      ASSERT_GE(received, -1.5 * brought - rounding - 0.2e-3);
      ASSERT_TRUE(!world.cycle->clutch(0).frozen() || out.command.force.isZero(0));
      force = out.command.force;
      last = world.input->device[0].p;
      clutched += world.cycle->clutch(0).frozen() ? 1 : 0;
      felt += force.norm() > 0.5 ? 1 : 0;
      rising += rises ? 1 : 0;
    }
  });
  if (!drawsAll()) return;
  EXPECT_GT(clutched, 10'000);
  EXPECT_GT(felt, 10'000);
  EXPECT_GT(rising, 1000);
}

/** A point that goes on where it was: no clutch moves it, but off what held it to where it was held. */
TEST(ClutchProperty, NoPointLeapsAndNoForceDoes) {
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    Springs world(random);
    Vec3 force = Vec3::Zero();
    for (int tick = 0; tick < 3000; ++tick) {
      SCOPED_TRACE(tick);
      const Vec3 shown = world.output->device[0].contact.object != 0 ? world.output->device[0].contact.proxy
                                                                     : world.output->device[0].pose.p;
      const double s = world.cycle->mount(0).scale();
      const DeviceOutput& out = world.next();
      const Vec3 now = out.contact.object != 0 ? out.contact.proxy : out.pose.p;
      // About the middle of the ball, and of its circle on the floor, the way out goes round faster than the hand.
      if ((out.pose.p - kClutchBallAt).head<2>().norm() > 2e-3) {
        ASSERT_LE((now - shown).norm(), s * 1e-3);
        // 1 kN/m of three walls together, times s, over 0.1 mm; and a fiftieth of what is felt.
        ASSERT_LE((out.command.force - force).norm(), 1000 * 3 * 1e-4 + force.norm() / 49);
      }
      force = out.command.force;
    }
  });
}

}  // namespace
}  // namespace hapticd
