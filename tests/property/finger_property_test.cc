// Whatever hand, object and finger do: what a soft finger gives stays within friction, and turns nobody faster.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/for_seeds.h"
#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/stepped/wandering_hand.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kThing = makeObjectId(1, 1);

SetFinger anyFinger(Random& random) {
  SetFinger out{};
  out.law = 1 + random.below(5u);
  out.flags = random.below(2u);
  out.shows_moment = 1;
  out.radius = random.in(1e-3, 2e-2);
  out.arm = random.in(0, 2e-2);
  out.stiffness = std::pow(10.0, random.in(-3, 1));
  out.damping = random.in(0, 20);
  out.cue = random.in(0, 5);
  return out;
}

/** A hand that wanders and turns over a ball or a box that a client moves, and turns, by steps. */
class Fingered : public test::SteppedCycle {
 public:
  explicit Fingered(unsigned seed) : SteppedCycle(test::openConfig(20)), random(seed), hand_(random, 0.04) {
    hd_material material{random.in(100, 2000), random.in(0, 5), 0, 0};
    material.friction_static = random.in(0, 1.5);
    material.friction_dynamic = random.in(0, material.friction_static);
    add(test::solid(kThing, random.once(2) ? ShapeKind::kSphere : ShapeKind::kBox, material, Pose{},
                    Vec3::Constant(0.02)));
    arm();
    wear();
  }
  void wear() {
    finger = anyFinger(random);
    put(CommandKind::kSetFinger, finger);
  }
  const DeviceOutput& go() {
    if (random.once(200)) wear();
    if (random.once(100)) spin_ = random.vector(20);
    if (random.once(50)) turn_ = random.vector(10);
    if (random.once(3)) {
      if (random.once(20)) place_.p = random.vector(0.005);
      place_.q = (place_.q * Quat(Eigen::AngleAxisd(3e-3 * spin_.norm(), (spin_ + Vec3(1e-9, 0, 0)).normalized())))
                     .normalized();
      put(CommandKind::kObjectPose, poseMessage(kThing, place_, {Vec3::Zero(), random.once(2) ? spin_ : Vec3::Zero()}));
    }
    Quat& q = input->device[0].q;
    q = (q * Quat(Eigen::AngleAxisd(1e-3 * turn_.norm(), (turn_ + Vec3(1e-9, 0, 0)).normalized()))).normalized();
    return at(hand_.next());
  }

  Random random;
  SetFinger finger{};

 private:
  test::WanderingHand hand_;
  Pose place_;
  Vec3 spin_ = Vec3::Zero(), turn_ = Vec3::Zero();
};

TEST(FingerProperty, ForceAndMomentStayWithinFriction) {
  int turned = 0, held = 0, shared = 0;
  forSeeds(40, [&](unsigned seed) {
    Fingered world(seed);
    for (int tick = 0; tick < 2000; ++tick) {
      const DeviceOutput& out = world.go();
      const SurfaceContact& c = out.contact;
      const SoftFinger& finger = world.cycle->finger(0);
      if (c.object == 0) {
        ASSERT_EQ(finger.twist(), 0) << "it begins anew";
        continue;
      }
      const double pressed = std::max(0.0, c.stiffness * c.depth + std::min(0.0, c.damping));
      const double arm =
          momentArm({static_cast<PadLaw>(world.finger.law), world.finger.radius, world.finger.arm}, pressed);
      const Vec3 lag = c.pull - c.pull.dot(c.normal) * c.normal;
      const double across = c.stiffness * lag.norm(), moment = world.finger.stiffness * std::abs(finger.twist());
      const double bears = c.friction.still * pressed, slack = 1e-9 + 1e-6 * bears;
      ASSERT_LE(moment, arm * bears + slack) << tick;
      ASSERT_LE(out.guard.command.torque.norm(), arm * bears + slack) << "with its viscosity";
      const Vec3 aside = c.force - c.force.dot(c.normal) * c.normal;
      ASSERT_LE(aside.norm(), std::max(bears, across) + slack) << "nor does the pad's viscosity add to it";
      if ((world.finger.flags & kFingerUncoupled) == 0 && bears > 1e-6) {
        const double x = std::min(1.0, across / bears), y = arm > 0 ? moment / (arm * bears) : 0;
        ASSERT_LE(x * x + y * y, 1 + 1e-6) << tick;
        shared += x > 0.3 && y > 0.3;
      }
      turned += finger.turning();
      held += !finger.turning() && moment > 1e-5;
    }
  });
  if (drawsAll()) {
    EXPECT_GT(turned, 1000);
    EXPECT_GT(held, 1000);
    EXPECT_GT(shared, 300);
  }
}

/** On a body that moves freely a contact is viscous while it sticks: it only ever slows what moves across, stays within
 * friction together with what is elastic, and stops a body within a tick at the most. */
TEST(FingerProperty, WhatIsViscousSlowsWithinFriction) {
  int bounded = 0, stopped = 0;
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    for (int i = 0; i < 2000; ++i) {
      const double dt = std::pow(10.0, random.in(-4, -2));
      SurfaceContact contact;
      contact.normal = (random.vector(1) + Vec3(0, 0, 1e-9)).normalized();
      contact.stiffness = std::pow(10.0, random.in(1, 4));
      contact.depth = random.in(0, 5e-3);
      contact.damping = random.in(-5, 5);
      contact.friction.still = random.in(0, 2);
      const double most =
          contact.friction.still * std::max(0.0, contact.stiffness * contact.depth + std::min(0.0, contact.damping));
      Vec3 aside = random.vector(1);
      aside -= aside.dot(contact.normal) * contact.normal;
      const Vec3 elastic = random.in(0, most) * aside.normalized();
      contact.pull = contact.depth * contact.normal + elastic / contact.stiffness;
      contact.velocity = contact.at_hip = random.vector(1);
      FingerMotion motion;
      motion.hand.v = random.vector(1);
      motion.fingers = static_cast<int>(1 + random.below(4));
      const Vec3 v = contact.velocity - motion.hand.v, across = v - v.dot(contact.normal) * contact.normal;
      const PadForce none = padForce(contact, motion, 10, dt);
      ASSERT_TRUE(none.force.isZero(0)) << "nothing that stands";
      const double mass = std::pow(10.0, random.in(-3, 1));
      motion.body = Mobility::free(mass, Mat3::Identity());
      const double wanted = random.in(0, 20);
      const PadForce pad = padForce(contact, motion, wanted, dt);
      ASSERT_LE(std::abs(pad.force.dot(contact.normal)), 1e-9);
      ASSERT_GE(pad.force.dot(across), -1e-12) << "of the surface on the hand: along with it";
      ASSERT_LE((elastic + pad.force).norm(), most * (1 + 1e-9) + 1e-12);
      ASSERT_LE(pad.damping, wanted);
      ASSERT_LE(pad.force.norm() * dt / mass, across.norm() / motion.fingers * (1 + 1e-9)) << "not back";
      bounded += (elastic + pad.force).norm() > 0.999 * most;
      stopped += pad.damping < wanted;
      contact.slip = true;
      ASSERT_TRUE(padForce(contact, motion, wanted, dt).force.isZero(0));
    }
  });
  if (drawsAll()) {
    EXPECT_GT(bounded, 1000);
    EXPECT_GT(stopped, 1000);
  }
}

/** A hand that turns on a thing that stands is never paid for it: the spring gives back no more than it took. */
TEST(FingerProperty, TurningAHandGainsNothing) {
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    test::SteppedCycle world(test::openConfig(20));
    const double mu = random.in(0.2, 1.5);
    world.add(test::solid(kThing, ShapeKind::kBox, {1000, 0, mu, 0.8 * mu}, Pose{}, Vec3::Constant(0.02)));
    SetFinger finger = anyFinger(random);
    finger.cue = 0;
    world.put(CommandKind::kSetFinger, finger);
    world.arm();
    double angle = 0, speed = 0, paid = 0;
    const double depth = random.in(1e-4, 5e-3);
    for (int tick = 0; tick < 3000; ++tick) {
      if (random.once(100)) speed = random.in(-5, 5);
      const double moment = world.output->device[0].guard.command.torque.z();
      // By the mean of both ends of a tick: a spring held for it is not charged with the sample's own half step.
      angle += speed * 1e-3;
      world.input->device[0].q = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
      const DeviceOutput& out = world.at({0, 0, 0.02 - depth * std::min(1.0, tick / 100.0)});
      paid -= 0.5 * (moment + out.guard.command.torque.z()) * speed * 1e-3;
      ASSERT_GT(paid, -1e-7) << tick;
    }
    if (momentArm({static_cast<PadLaw>(finger.law), finger.radius, finger.arm}, 1) > 1e-3) {
      EXPECT_GT(paid, 1e-6);
    }
  });
}

}  // namespace
}  // namespace hapticd
