// What a hand feels of the world while its clutch falls or rises is what the guard's books hold of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/solid.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kWeighedGround = makeObjectId(1, 1), kWeighedFrame = makeObjectId(2, 1);

/** An armed hand in the air above a floor, z = 0, of 1000 N/m. */
class ClutchedHand : public test::SteppedCycle {
 public:
  explicit ClutchedHand(double damping = 0, double delay = 0) : SteppedCycle(config(delay)) {
    add(test::solid(kWeighedGround, ShapeKind::kPlane, {1000, damping, 0, 0}));
    put(CommandKind::kAddSession, SessionRef{0, 0, 1});
    at({0, 0, 0.05});
    arm();
    for (int i = 0; i < 10; ++i) step();
  }
  void clutch(bool held) { put(CommandKind::kSetClutch, SetClutch{0, held ? 1u : 0u, 0, 0, {}}); }
  void model(hd_local_model model) {
    model.lease_ns = 60'000'000'000;
    put(CommandKind::kLocalModel, model, 0);
  }
  /** Within 0.2 s. */
  void go(const Vec3& to) {
    const Vec3 from = p();
    for (int i = 1; i <= 200; ++i) at(from + i / 200.0 * (to - from));
  }
  [[nodiscard]] const Vec3& p() const { return input->device[0].p; }
  [[nodiscard]] const GuardOutput& guard() const { return output->device[0].guard; }
  [[nodiscard]] double weight() const { return cycle->clutch(0).weight(); }

 private:
  static CycleConfig config(double delay) {
    CycleConfig config = test::openConfig(100);
    config.guard[0].delay = delay;
    return config;
  }
};

/** A hand goes up and down while nothing passive presses it: the books stay empty to the bit. */
void expectNothingBooked(ClutchedHand& hand) {
  const Vec3 from = hand.p();
  bool partly = false;
  for (int i = 0; i < 400; ++i) {
    if (i == 30 || i == 170) hand.clutch(i == 30);
    hand.at(from + 0.003 * std::sin(0.05 * i) * Vec3::UnitZ());
    ASSERT_EQ(hand.guard().energy, 0) << i;
    partly = partly || (hand.weight() > 0.2 && hand.weight() < 0.8);
  }
  EXPECT_TRUE(partly);
}

TEST(CycleClutchEnergy, ASpringsWorkIsItsClients) {
  ClutchedHand hand;
  hd_local_model spring{};
  spring.kind = HD_MODEL_SPRING;
  spring.material = {200, 0, 0, 0};
  hand.model(spring);
  hand.go({0, 0.01, 0.02});
  ASSERT_NEAR(hand.output->device[0].command.force.z(), -4, 1e-6);
  expectNothingBooked(hand);
}

/** A hollow of 10 mm takes from its floor all that it presses. */
TEST(CycleClutchEnergy, AboveTheGroundOfAHollowNothingPresses) {
  ClutchedHand hand;
  const test::TestRelief black(256, 256, [](double, double) { return 0.0; });
  hand.meshes.publishTexture(0, &black.view);
  SurfaceParameters surface{};
  surface.relief = 1;
  surface.relief_depth = 0.01;
  surface.relief_size[0] = surface.relief_size[1] = 0.032;
  hand.put(CommandKind::kSetSurface, SetSurface{kWeighedGround, 0, surface});
  hand.go({0, 0, -0.005});
  ASSERT_NEAR(hand.guard().by_source[HD_SOURCE_SURFACE].z(), 5, 1e-6);
  expectNothingBooked(hand);
}

/** Whatever is felt of a spring can be got back from it, and no more. */
TEST(CycleClutchEnergy, AFloorHoldsAsMuchAsIsFeltOfIt) {
  ClutchedHand hand;
  hand.go({0, 0, -0.004});
  const double stored = 0.5 * 1000 * 0.004 * 0.004;
  const double begun = hand.guard().energy;
  ASSERT_NEAR(begun, stored, 1e-3);
  hand.clutch(true);
  for (int i = 0; i < 60; ++i) {
    hand.step();
    ASSERT_LE(hand.guard().energy, hand.weight() * stored + Passivity::kMargin + 1e-9) << i;
    ASSERT_GE(hand.guard().energy, std::min(begun, hand.weight() * stored) - 1e-9) << i;
  }
}

/**
 * A model comes back that moves with its hand, which it presses from below: what the client brings by moving it, and by
 * the rise, is what the hand takes and what is then stored; along the axis of the force.
 */
TEST(CycleClutchEnergy, AMovingModelIsChargedForWhatIsFeltOfIt) {
  for (const double speed : {-0.05, 0.05}) {
    ClutchedHand hand;
    hand.add(test::solid(kWeighedFrame, ShapeKind::kSphere, {0, 0, 0, 0}, {{1, 0, 0}, Quat::Identity()}, {0.01, 0, 0}));
    hd_local_model wall{};
    wall.kind = HD_MODEL_PLANE;
    wall.frame = kWeighedFrame;
    wall.material = {1000, 0, 0, 0};
    wall.normal[2] = 1;
    wall.origin[2] = 0.05;
    hand.model(wall);
    hand.go({0, 0, 0.044});
    hand.clutch(true);
    hand.go({0, 0, 0.044});
    hand.clutch(false);
    hand.step();
    ASSERT_LT(hand.weight(), 0.01);
    const double stored = 0.5 * 1000 * 0.006 * 0.006;
    for (int i = 1; i <= 400; ++i) {
      const Vec3 way = 1e-3 * speed * i * Vec3::UnitZ();
      hand.put(CommandKind::kObjectPose, poseMessage(kWeighedFrame, {Vec3(1, 0, 0) + way, Quat::Identity()},
                                                     {speed * Vec3::UnitZ(), Vec3::Zero()}));
      hand.at(Vec3(0, 0, 0.044) + way);
      const Vec3& by_axis = hand.cycle->deviceGuard(0).passivity().byAxis();
      ASSERT_NEAR(by_axis.z(), hand.weight() * stored, Passivity::kMargin + 1e-4) << speed << " " << i;
      ASSERT_LT(std::abs(by_axis.x()) + std::abs(by_axis.y()), 1e-6) << speed << " " << i;
    }
    EXPECT_GT(hand.weight(), 0.3) << "within the rise";
    EXPECT_LT(hand.weight(), 0.9);
  }
}

/** A floor as viscous as the controller may be leaves it nothing; of a floor that is felt in part it is as much less.
 */
TEST(CycleClutchEnergy, WhereLessOfAFloorsDampingIsFeltTheControllerHasMore) {
  const auto actsIn = [](double damping, bool clutched) {
    ClutchedHand hand(damping, 12);
    hand.go({0, 0, -0.004});
    int acts = 0;
    for (int i = 0; i < 160; ++i) {
      if (clutched && i == 100) hand.clutch(true);
      hand.at({0, 0, -0.004 + 0.002 * std::sin(0.2 * i)});
      acts += hand.weight() > 0 && (hand.guard().flags & HD_SAMPLE_PASSIVITY) != 0 ? 1 : 0;
    }
    return acts;
  };
  EXPECT_GT(actsIn(0, false), 10) << "a floor whose force comes 12 ms late gives energy";
  EXPECT_EQ(actsIn(5, false), 0);
  EXPECT_GT(actsIn(5, true), 5);
}

/** By the time that has passed, though the servo slept through some of it. */
TEST(CycleClutchEnergy, AClutchFallsInTimeNotInTicks) {
  ClutchedHand hand;
  hand.go({0, 0, -0.002});
  hand.clutch(true);
  hand.input->missed = 9;
  hand.step();
  EXPECT_NEAR(hand.weight(), 1 - 10e-3 / Clutch::kFall_s, 1e-12);
  hand.input->missed = 0;
  hand.step();
  EXPECT_NEAR(hand.weight(), 1 - 11e-3 / Clutch::kFall_s, 1e-12);
}

}  // namespace
}  // namespace hapticd
