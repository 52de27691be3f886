// What clients put into the walls that hold a hand, by making them stiffer, is booked to the joule.
#include <gtest/gtest.h>

#include "rt/base/rotation.h"
#include "tests/support/for_seeds.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

/** An armed hand in the corner of three walls: each coordinate is how far it is before one. */
class Corner : public test::SteppedCycle {
 public:
  explicit Corner(const Vec3& stiffness) : SteppedCycle(config()), stiffness_(stiffness) {
    for (std::uint32_t i = 0; i < 3; ++i) {
      const Quat faces = Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::Unit(i));
      add(test::solid(id(i), ShapeKind::kPlane, {stiffness_[i], 0, 0, 0}, {Vec3::Zero(), faces}));
    }
    arm();
    rest(20);
  }
  /** Slowly. */
  void go(const Vec3& to) {
    const Vec3 from = p_;
    for (int i = 1; i <= 1000; ++i) {
      p_ = from + 1e-3 * i * (to - from);
      rest(1);
    }
  }
  void rest(int ticks) {
    for (int i = 0; i < ticks; ++i) at(p_);
  }
  void set(std::uint32_t wall, double stiffness) {
    stiffness_[wall] = stiffness;
    put(CommandKind::kObjectMaterial, hd_object_material{id(wall), 0, {stiffness, 0, 0, 0}});
  }
  /** Of the springs: independent, as the walls are at right angles. */
  double stored() const {
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += 0.5 * stiffness_[i] * std::pow(std::min(0.0, p_[i]), 2);
    return sum;
  }
  double stiffness(std::uint32_t wall) const { return stiffness_[wall]; }
  const DeviceOutput& out() const { return output->device[0]; }

 private:
  static std::uint32_t id(std::uint32_t wall) { return makeObjectId(wall + 1, 1); }
  static CycleConfig config() {
    CycleConfig config = test::openConfig(100);
    config.guard[0].energy_limit = 100;
    return config;
  }

  Vec3 stiffness_, p_ = Vec3::Constant(1e-3);
};

/** In one wall, two or all three, of which some are made stiffer, twice at least. */
TEST(CycleStiffened, WhatIsPutInIsWhatTheSpringsHoldMore) {
  int several = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    Corner corner({random.in(200, 800), random.in(200, 800), random.in(200, 800)});
    Vec3 to;
    for (double& x : to) x = random.once(3) ? random.in(0.001, 0.003) : random.in(-0.006, -0.002);
    corner.go(to);
    corner.rest(5);
    several += corner.out().contact.parts > 1 ? 1 : 0;
    ASSERT_NEAR(corner.out().contact.stored, corner.stored(), 1e-9);
    const double begun = corner.out().guard.energy - corner.stored();
    ASSERT_LE(begun, 0) << "less than what the guard would cut off";
    for (int i = 0; i < 4; ++i) {
      const double before = corner.stored(), energy = corner.out().guard.energy;
      for (std::uint32_t wall = 0; wall < 3; ++wall) {
        if (random.once(2)) corner.set(wall, corner.stiffness(wall) * random.in(1, 1.5));
      }
      corner.rest(3);
      ASSERT_NEAR(corner.out().guard.energy - energy, corner.stored() - before, 1e-9) << i;
    }
    ASSERT_EQ(corner.out().guard.fault, HD_FAULT_NONE);
  });
  if (drawsAll()) {
    EXPECT_GT(several, 20);
  }
}

/** A wall without stiffness holds nothing; who gives it one with a hand in it puts all of that in. */
TEST(CycleStiffened, AWallThatIsTurnedOnUnderTheHandIsPutInWhole) {
  for (const int off : {1, 2, 3}) {  // That many of the walls.
    Corner corner({off > 0 ? 0.0 : 500.0, off > 1 ? 0.0 : 400.0, off > 2 ? 0.0 : 600.0});
    corner.go({-0.003, -0.004, -0.002});
    corner.rest(5);
    for (std::uint32_t wall = 0; wall < static_cast<std::uint32_t>(off); ++wall) {
      const double before = corner.stored(), energy = corner.out().guard.energy;
      corner.set(wall, 500);
      corner.rest(3);
      EXPECT_GT(corner.stored() - before, 9e-4);
      EXPECT_NEAR(corner.out().guard.energy - energy, corner.stored() - before, 1e-9) << off << " " << wall;
    }
    EXPECT_EQ(corner.out().guard.fault, HD_FAULT_NONE);
  }
}

/** Who makes a wall softer takes out, and gets nothing for it; nor does who then gives back less. */
TEST(CycleStiffened, WhatIsTakenOutIsNotPutIn) {
  Corner corner({600, 400, 500});
  corner.go({-0.004, -0.003, -0.005});
  corner.rest(5);
  const double energy = corner.out().guard.energy;
  corner.set(0, 300);
  corner.rest(3);
  EXPECT_LE(corner.out().guard.energy, energy);
  EXPECT_LE(corner.out().guard.energy, corner.stored() + Passivity::kMargin) << "the guard is told what is left";
  corner.set(1, 300);
  corner.rest(3);
  EXPECT_LE(corner.out().guard.energy, energy);
}

}  // namespace
}  // namespace hapticd
