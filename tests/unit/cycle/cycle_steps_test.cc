// What a device's encoder steps make of the effects of a surface, at 1 and 4 kHz: no knock and no buzz of their own.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "tests/support/seeds.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr double kSteps[] = {1e-5, 4e-5}, kPeriods[] = {1e-3, 2.5e-4};
constexpr double kKnockGain = 5;

/** An armed hand, read in steps, and a plane that rings and buzzes, turned at random. */
class Hand : public test::SteppedCycle {
 public:
  Hand(double step, double period, std::mt19937& random) : SteppedCycle(config(period)), step_(step), period_(period) {
    std::normal_distribution<double> normal;
    plane = {1e-2 * Vec3(normal(random), normal(random), normal(random)),
             Quat(normal(random), normal(random), normal(random), normal(random)).normalized()};
    ring = test::ringing(kKnockGain, 150, 0.01, period);
    cloth_.models = {{0.02, 0.02, 4, {}}, {0.3, 0.02, 9, {}}, {0.02, 3, 16, {}}};
    cloth_.triangles = {{0, 1, 2}};
    cloth_.finish();
    meshes.publishTexture(0, &cloth_.view);
    cycle->setResolution(0, step, 1e-4);
    add(test::solid(makeObjectId(1, 1), ShapeKind::kPlane, {1000, 5, 0.3, 0.2}, plane));
    SetSurface surface{makeObjectId(1, 1), 0, ring};
    surface.surface.vibration = 1;
    surface.surface.vibration_mass = 0.05;
    put(CommandKind::kSetSurface, surface);
    arm();
  }

  /** One tick with the hand at x, in the plane's frame, where the plane is z = 0. */
  void at(const Vec3& x) { SteppedCycle::at(step_ * ((plane * x).array() / step_).round()); }
  [[nodiscard]] Vec3 felt(std::uint32_t source) const {
    return plane.q.conjugate() * output->device[0].guard.by_source[source];
  }
  /** Comes to the surface within 0.1 s and lies there until what rang is silent. */
  void comeToRest() {
    for (int i = 0; i * period_ < 0.1; ++i) at({0, 0, 0.003 * (1 - i * period_ / 0.1)});
    for (int i = 0; i * period_ < 0.2; ++i) at(Vec3::Zero());
  }

  Pose plane;
  SurfaceParameters ring;

 private:
  static CycleConfig config(double period) {
    CycleConfig config = test::openConfig(20);
    config.guard[0].ramp_ns = config.period_ns = std::llround(1e9 * period);
    config.guard[0].passivity = false;
    return config;
  }

  double step_, period_;
  test::TestVibration cloth_;
};

/** Tremor of less than a step, by which the readings come and go through the surface. */
TEST(CycleSteps, AHandAtRestHearsNoKnockAndNextToNoBuzz) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const double period : kPeriods) {
    for (const double step : kSteps) {
      double knock = 0, buzz = 0;
      for (int run = 0; run < 20; ++run) {
        Hand hand(step, period, random);
        hand.comeToRest();
        const double depth = 0.5 * step * any(random), turn = 2 * std::numbers::pi * (4 + 2 * any(random)) * period;
        for (int i = 0; i * period < 1; ++i) {
          const double size = 0.8 * step * std::min(1.0, i * period / 0.2);
          hand.at(
              {size * std::sin(1.1 * turn * i), size * std::cos(turn * i) - size, depth + size * std::sin(turn * i)});
          knock = std::max(knock, hand.felt(HD_SOURCE_TRANSIENT).norm());
          buzz = std::max(buzz, hand.felt(HD_SOURCE_TEXTURE).norm());
        }
      }
      EXPECT_EQ(knock, 0) << step << " " << period;
      EXPECT_LT(buzz, 0.25 * 1000 * step) << step << " " << period;
    }
  }
}

/** Aslant: readings that come in may be out again for a tick. */
TEST(CycleSteps, ATapRingsOnceAsHardAsItCame) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const double period : kPeriods) {
    for (const double step : kSteps) {
      for (unsigned run = 0; run < drawn(300U); ++run) {
        Hand hand(step, period, random);
        const double hz = 3 + 2 * any(random), height = 0.004 + 0.003 * any(random),
                     middle = 0.7 * height * any(random);
        const double turn = 2 * std::numbers::pi * hz;
        const double speed = turn * std::sqrt(height * height - middle * middle);
        const Vec3 side(0.05 * any(random), 0.05 * any(random), 0);
        double one = 0, two = 0, strength = 0;
        int knocks = 0;
        for (int i = 0; i * period * hz < 1; ++i) {
          const double t = i * period;
          hand.at(t * side + Vec3(0, 0, middle + height * std::cos(turn * t)));
          const double ringing = hand.felt(HD_SOURCE_TRANSIENT).z();
          if (std::abs(ringing - (hand.ring.transient_turn * one - hand.ring.transient_decay * two)) > 2e-4) {
            ++knocks;
            strength = ringing / (kKnockGain * hand.ring.transient_first);
          }
          two = std::exchange(one, ringing);
        }
        if (speed < 0.03) continue;
        ASSERT_EQ(knocks, 1) << step << " " << period << " run " << run << " at " << speed;
        ASSERT_NEAR(strength, speed, 0.02 + 0.1 * speed) << step << " " << period << " run " << run;
      }
    }
  }
}

}  // namespace
}  // namespace hapticd
