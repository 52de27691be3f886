#include "rt/render/surface/transient.h"

#include <gtest/gtest.h>

#include "tests/support/shape/test_surface.h"

namespace hapticd {
namespace {

constexpr double kHz = 150, kDecay = 0.01, kGain = 10;

SurfaceParameters ringing() { return test::ringing(kGain, kHz, kDecay); }

/** gain v exp(-t / decay) sin(2 pi f t), at t = 1, 2, ... ticks. */
double closedForm(double speed, int n) {
  const double t = n * 1e-3;
  return kGain * speed * std::exp(-t / kDecay) * std::sin(2 * std::numbers::pi * kHz * t);
}

TEST(Transient, RingsAsTheClosedFormFromItsFirstTick) {
  for (const double speed : {0.01, 0.1, 0.5}) {
    Transient transient;
    const Vec3 n = Vec3(1, 2, 2) / 3;
    transient.strike(ringing(), speed, n);
    for (int tick = 1; tick < 40; ++tick) {
      ASSERT_LT((transient.step() - closedForm(speed, tick) * n).norm(), 1e-12) << tick << " at " << speed;
    }
  }
}

TEST(Transient, IsSilentBeforeAndAfter) {
  Transient transient;
  EXPECT_EQ(transient.step(), Vec3::Zero());
  transient.strike(ringing(), 0.3, Vec3::UnitZ());
  for (int tick = 0; tick < 200; ++tick) (void)transient.step();
  for (int tick = 0; tick < 10; ++tick) EXPECT_EQ(transient.step(), Vec3::Zero());
}

TEST(Transient, SlowTouchesAndSoftGainsAreNoImpacts) {
  Transient transient;
  transient.strike(ringing(), 0.9 * Transient::kLeastSpeed, Vec3::UnitZ());
  EXPECT_EQ(transient.step(), Vec3::Zero());
  transient.strike(ringing(), -1, Vec3::UnitZ());
  EXPECT_EQ(transient.step(), Vec3::Zero());
  transient.strike(test::ringing(0, kHz, kDecay), 1, Vec3::UnitZ());
  EXPECT_EQ(transient.step(), Vec3::Zero());
}

TEST(Transient, TheHardestBlowIsBounded) {
  Transient transient;
  transient.strike(ringing(), 1e6, Vec3::UnitZ());
  for (int tick = 0; tick < 100; ++tick) ASSERT_LE(transient.step().norm(), Transient::kMostForce);
}

TEST(Transient, AWeakerBlowDoesNotCutAStrongerOneShort) {
  Transient alone, hit;
  alone.strike(ringing(), 0.5, Vec3::UnitZ());
  hit.strike(ringing(), 0.5, Vec3::UnitZ());
  (void)alone.step();
  (void)hit.step();
  hit.strike(ringing(), 0.1, Vec3::UnitX());
  EXPECT_EQ(hit.step(), alone.step());
  hit.strike(ringing(), 0.6, Vec3::UnitX());
  EXPECT_NEAR(hit.step().x(), closedForm(0.6, 1), 1e-12);
}

}  // namespace
}  // namespace hapticd
