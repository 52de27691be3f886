/** @file
 * Local models along closed ways, on and through them: no way around gives more than it took.
 */
#include <gtest/gtest.h>

#include <numbers>

#include "rt/render/model/model_force.h"
#include "tests/support/random.h"
#include "tests/support/seeds.h"
#include "tests/unit/render/model_rig.h"

namespace hapticd {
namespace {

constexpr double kStiffness = 1000, kSize = 0.01;
constexpr int kTicksRound = 4000;

hd_local_model solid(std::initializer_list<std::pair<Vec3, double>> sides) {
  hd_local_model m = modelOf(sides.size() == 0 ? HD_MODEL_SPHERE : HD_MODEL_HALFSPACES, kStiffness);
  if (sides.size() == 0) m.radius = kSize;
  for (const auto& [n, d] : sides) setHalfspace(m, n, d);
  return m;
}

/** Four waves, so a way that closes; as wide as the solid, or about its middle. */
struct ClosedWay {
  Vec3 cosine[4], sine[4];
  ClosedWay(Random& random, double width) {
    for (int k = 0; k < 4; ++k) cosine[k] = random.vector(width / (k + 1)), sine[k] = random.vector(width / (k + 1));
  }
  [[nodiscard]] Vec3 at(double turn) const {
    Vec3 x = Vec3::Zero();
    for (int k = 0; k < 4; ++k) x += std::cos((k + 1) * turn) * cosine[k] + std::sin((k + 1) * turn) * sine[k];
    return x;
  }
};

TEST(ModelPassivityProperty, NoClosedWayGivesMoreThanItTook) {
  Random random(seedOf(61));
  const hd_local_model solids[] = {
      solid({}),                                         // a ball
      solid({{{0, 0, 1}, 0.004}, {{0, 0, -1}, 0.004}}),  // a plate
      solid({{{1, 0, 1}, 0.005}, {{-1, 0, 1}, 0.005}, {{0, 1, 0.3}, 0.008}, {{0, -1, 0}, 0.008}, {{0, 0, -1}, 0.006}}),
      solid({{{5, 0, 1}, 0.003}, {{-5, 0, 1}, 0.003}}),  // a blade
  };
  for (hd_local_model m : solids) {
    for (const double mu : {0.0, 0.2, 0.6, 1.5}) {
      m.material.friction_static = static_cast<float>(mu);
      m.material.friction_dynamic = static_cast<float>(0.7 * mu);
      for (int round = 0; round < (m.kind == HD_MODEL_SPHERE ? 150 : 16); ++round) {
        SCOPED_TRACE(testing::Message() << "kind " << m.kind << ", " << m.count << " sides, " << mu << ", " << round);
        const ClosedWay way(random, round % 2 == 0 ? kSize : 0.4 * kSize);
        LocalModel model;
        ASSERT_EQ(model.set(commandOf(m)), ErrorCode::kOk);
        Vec3 last_p = way.at(0);
        ModelForce last = model.evaluate(last_p, Vec3::Zero(), {});
        const double before = last.stored;
        double taken = 0;
        for (int i = 1; i <= 2 * kTicksRound; ++i) {
          const Vec3 p = way.at(2 * std::numbers::pi * i / kTicksRound);
          const ModelForce now = model.evaluate(p, Vec3::Zero(), {});
          taken -= 0.5 * (now.force + last.force).dot(p - last_p);
          last_p = p;
          last = now;
        }
        EXPECT_LE(last.stored - before - taken, 3e-4 * kStiffness * kSize * kSize) << "more than the steps' error";
      }
    }
  }
}

}  // namespace
}  // namespace hapticd
