// The passivity controller, whatever it is told: it only takes, and no more than it may.
#include <gtest/gtest.h>

#include "rt/guard/guard.h"
#include "rt/guard/passivity.h"
#include "tests/support/for_seeds.h"

namespace hapticd {
namespace {

TEST(PassivityProperty, ControllerOnlyTakesAndWithinItsDamping) {
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    const double most = random.once(8) ? 0.0 : random.in(0, 50);
    Passivity p(most);
    int acted = 0;
    for (int i = 0; i < 500; ++i) {
      p.observe(random.vector(10), random.vector(1e-4), random.vector(1e-4));
      p.follow(random.once(20) ? random.in(-1e3, 1e3) : random.in(-1e-4, 2e-4));
      p.limitStore(random.once(3) ? -1 : random.in(0, 0.01));
      const Vec3 v = random.once(5) ? Vec3(Vec3::Zero()) : random.vector(0.3);
      const Vec3 f = random.once(5) ? Vec3(Vec3::Zero()) : random.vector(random.once(5) ? 1e-12 : 8);
      const Vec3 out = p.control(f, v, v, random.vector(0.1), 1e-3);
      ASSERT_TRUE(isFinite(out));
      // Damping along f, then by axis: each takes power, together with no more than `most`.
      ASSERT_LE((out - f).dot(v), 1e-12) << "energy added";
      ASSERT_LE((out - f).norm(), most * v.norm() * (1 + 1e-9) + 1e-12);
      ASSERT_TRUE(std::isfinite(p.energy()) && std::isfinite(p.leak()));
      acted += p.acting() ? 1 : 0;
      if (!p.acting()) {
        ASSERT_EQ(out, f) << "bit for bit when nothing is owed";
      }
    }
    if (most > 0) {
      EXPECT_GT(acted, 50);
    }
  });
}

/** A hand that goes steadily along with a wall which leaks, while the servo misses periods as it will. */
TEST(PassivityProperty, PeriodsThatAreMissedNeverMakeTheDampingMoreThanTheHandsSpeedDoes) {
  unsigned acted = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    GuardConfig config;
    config.limits = {100, 1, 1e6, 1, 1, 50, 1e4, 1e4};
    config.ramp_ns = 0;
    config.energy_limit = 1e9;
    config.delay = random.in(0, 3);
    config.max_damping = random.in(0.5, 10);
    Guard guard(config);
    DeviceSample sample;
    sample.fresh = true;
    GuardInput in;
    in.sample = &sample;
    in.dt = 1e-3;
    GuardOutput out;
    (void)guard.arm();
    const double speed = random.in(0.01, 0.5) * (random.once(2) ? 1 : -1), stiffness = random.in(500, 5000);
    in.velocity.v = {speed, 0, 0};
    double push = 0;
    for (int i = 0; i < 1000; ++i) {
      in.missed = random.once(5) ? random.below(10u) : 0;
      in.now_ns += std::int64_t{1'000'000} * (1 + in.missed);
      sample.p.x() += speed * in.dt * (1 + in.missed);
      push = i < 10 ? 0 : std::min(20.0, push + random.in(0, 0.1));
      in.source[HD_SOURCE_SURFACE].force = {push, 0, 0};
      in.stored = push * push / (2 * stiffness);
      in.carried = {push * speed, 0, 0};
      guard.step(in, out);
      ASSERT_LE(std::abs(out.command.force.x() - push), config.max_damping * std::abs(speed) * (1 + 1e-6) + 1e-9) << i;
      acted += (out.flags & HD_SAMPLE_PASSIVITY) != 0 ? 1 : 0;
    }
  });
  EXPECT_GT(acted, 1000u);
}

}  // namespace
}  // namespace hapticd
