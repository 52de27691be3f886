// A reading that is not to be used is not felt, and nothing of what was before it is felt after it.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kFloor = makeObjectId(1, 1);

/** An armed hand, and a floor at z = 0 that rubs, rings and has a relief. */
class SlidingHand : public test::SteppedCycle {
 public:
  explicit SlidingHand(std::int64_t begin_ns = 0) : SteppedCycle(config()) {
    meshes.publishTexture(0, &relief_.view);
    input->now_ns = begin_ns;
    add(test::solid(kFloor, ShapeKind::kPlane, {1000, 5, 0.6, 0.4}));
    SetSurface surface{kFloor, 0, test::ringing(10, 150, 0.05)};
    surface.surface.relief = 1;
    surface.surface.relief_depth = 1e-3;
    surface.surface.relief_size[0] = surface.surface.relief_size[1] = 0.02;
    put(CommandKind::kSetSurface, surface);
  }
  const DeviceOutput& at(const Vec3& p) {
    DeviceSample sample;
    sample.p = p;
    return read(sample);
  }
  const DeviceOutput& read(const DeviceSample& sample) {
    input->device[0] = sample;
    return SteppedCycle::at(sample.p);
  }

 private:
  static CycleConfig config() {
    CycleConfig config = test::openConfig(20);
    config.guard[0].small_force = 100;
    config.guard[0].passivity = false;  // What it holds it keeps.
    return config;
  }

  test::TestRelief relief_{16, 16, [](auto x, auto y) { return (x + y) % 3 / 2.0; }};
};

/** Down to the floor and along it. */
Vec3 path(int i) { return {1e-4 * i, 5e-5 * i, std::max(-0.002, 0.004 - 1e-4 * i)}; }

/** With one number that is not finite, whichever. */
std::array<DeviceSample, 14> broken(double bad) {
  std::array<DeviceSample, 14> all;
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].p = {0, 0, 0.001};
    all[i].has_velocity = true;
    if (i < 3) all[i].p[i] = bad;
    if (i >= 3 && i < 6) all[i].v[i - 3] = bad;
    if (i >= 6 && i < 9) all[i].w[i - 6] = bad;
    if (i >= 9 && i < 13) all[i].q.coeffs()[i - 9] = bad;
    if (i == 13) all[i].gripper_rad = bad;
  }
  return all;
}

TEST(CycleReading, WithANumberThatIsNotFiniteIsNotFelt) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    const auto samples = broken(bad);
    for (std::size_t k = 0; k < samples.size(); ++k) {
      SlidingHand hand;
      hand.arm();
      for (int i = 0; i < 80; ++i) hand.at(path(i));
      ASSERT_EQ(hand.at(path(80)).contact.object, kFloor);
      const DeviceOutput& out = hand.read(samples[k]);
      EXPECT_EQ(out.guard.fault, HD_FAULT_NOT_FINITE) << k;
      EXPECT_EQ(out.command.force, Vec3::Zero()) << k;
      EXPECT_EQ(out.contact.object, 0u) << k;
      EXPECT_EQ(out.contact.force, Vec3::Zero()) << k;
      EXPECT_EQ(out.velocity.v, Vec3::Zero()) << k;
      EXPECT_EQ(out.velocity.w, Vec3::Zero()) << k;
    }
  }
}

/** Where the hand goes on from in the floor, in the air, or where it was. */
TEST(CycleReading, AfterOneThatIsNotToBeUsedTheHandStartsAnew) {
  for (const DeviceSample& bad : broken(std::numeric_limits<double>::quiet_NaN())) {
    for (const int from : {5, 30, 60, 81}) {
      SlidingHand hand;
      hand.arm();
      for (int i = 0; i < 80; ++i) hand.at(path(i));
      hand.read(bad);
      SlidingHand anew(hand.input->now_ns);
      for (int i = from; i < from + 200; ++i) {
        if (i == from + 2) hand.arm();  // The cause is gone.
        if (i == from + 2) anew.arm();
        const DeviceOutput &out = hand.at(path(i)), &expected = anew.at(path(i));
        ASSERT_EQ(out.velocity.v, expected.velocity.v) << from << " " << i;
        ASSERT_EQ(out.contact.force, expected.contact.force) << from << " " << i;
        ASSERT_EQ(out.contact.object, expected.contact.object) << from << " " << i;
        if (i < from + 5) continue;
        for (std::uint32_t s = 0; s < HD_SOURCES; ++s)
          ASSERT_EQ(out.guard.by_source[s], expected.guard.by_source[s]) << from << " " << i << " source " << s;
      }
    }
  }
}

/** One it does not measure may hold anything. */
TEST(CycleReading, AVelocityThatTheDeviceDoesNotHaveIsNotLookedAt) {
  SlidingHand hand, expected;
  hand.arm();
  expected.arm();
  for (int i = 0; i < 200; ++i) {
    DeviceSample sample;
    sample.p = path(i);
    const Vec3 force = expected.read(sample).command.force;
    sample.v.setConstant(std::numeric_limits<double>::quiet_NaN());
    sample.w = sample.v;
    const DeviceOutput& out = hand.read(sample);
    ASSERT_EQ(out.guard.fault, HD_FAULT_NONE) << i;
    ASSERT_EQ(out.command.force, force) << i;
  }
  EXPECT_GT(hand.at(path(200)).command.force.z(), 1);
}

}  // namespace
}  // namespace hapticd
