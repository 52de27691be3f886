// The passivity controller, whatever it is told: it only takes, and no more than it may.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace hapticd
