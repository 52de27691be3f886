// What a device bears is borne by all that damps its point, whatever that is and whoever set it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/for_seeds.h"
#include "tests/support/stepped/mount_at.h"
#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/test_effect.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kDamper = makeObjectId(1, 1);

EffectParameters anyDrag(Random& random) {
  EffectParameters e = test::effect(EffectKind::kViscous, random.in(0, 50), 0, random.in(0, 10), 10);
  if (random.once(4)) e.damping = 1000;
  if (random.once(5)) e.force = 0;
  return e;
}

/** Up to eight of two clients', of any damping. Planes lie where the wall does; their stiffness is told [N/m]. */
double addModels(test::SteppedCycle& hand, Random& random, double scale) {
  double stiffness = 0;
  for (std::uint32_t i = 0, n = random.below(9u); i < n; ++i) {
    const std::uint32_t client = i % 2;
    if (i < 2) hand.put(CommandKind::kAddSession, SessionRef{client, 0, client + 1});
    hd_local_model model{};
    model.slot = i / 2;
    model.kind = random.once(2) ? HD_MODEL_SPRING : HD_MODEL_PLANE;
    model.normal[2] = 1;
    const double damping = random.once(4) ? 1000 : random.in(0, 5);
    const double k = model.kind == HD_MODEL_PLANE ? std::round(random.in(100, 1000)) : 0;
    model.material = {static_cast<float>(k), static_cast<float>(damping), 0, 0};
    model.lease_ns = 100'000'000'000;
    hand.put(CommandKind::kLocalModel, model, client);
    stiffness += k * scale;
  }
  return stiffness;
}

/** Scripted: a hand that shakes in a stiff wall along its normal, with clients' models and drags about it, in a world
 * of any size.
 */
TEST(DampingProperty, AllTogetherDampByWhatTheDeviceBears) {
  std::uint32_t full = 0;
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    const double can = random.in(1, 8), scale = random.once(2) ? 1 : random.in(0.5, 3);
    const double wall = random.once(5) ? 1000 : random.in(0, 2.5) * can;  // As the hand feels it.
    CycleConfig config = test::openConfig(200);
    config.guard[0].energy_limit = 100;
    config.guard[0].max_damping = can;
    test::SteppedCycle hand(config);
    if (scale != 1) hand.put(CommandKind::kSetMount, test::mountAt({}, 0, scale));
    hand.add(test::solid(kDamper, ShapeKind::kPlane, {20'000 / scale, wall / scale, 0, 0}));
    for (std::uint32_t i = 0, n = random.below(5u); i < n; ++i) {
      hand.add(test::solid(makeObjectId(2 + i, 1), ShapeKind::kGroup, {}));
      hand.put(CommandKind::kSetEffect, SetEffect{makeObjectId(2 + i, 1), 0, anyDrag(random)});
    }
    const double k = 20'000 + addModels(hand, random, scale);
    hand.arm();
    double most = 0, before = 0;
    for (int i = 0; i < 1500; ++i) {
      const double z = i < 100 ? 0.001 : -0.5e-3 - 0.3e-3 * std::sin(2 * std::numbers::pi * 0.02 * (i - 100));
      const DeviceOutput& out = hand.at({0, 0, z});
      ASSERT_EQ(out.guard.fault, HD_FAULT_NONE);
      const double v = out.velocity.v.z() / scale;             // Of the hand itself.
      const double fast = std::abs(v) + std::abs(v - before);  // The controller's is extrapolated.
      before = v;
      if (i < 1000 || std::abs(v) < 0.035) continue;
      ASSERT_LE(out.guard.by_source[HD_SOURCE_EFFECT].z() * v, 0);
      most = std::max(most, std::abs(out.command.force.z() + k * z) / fast);
    }
    EXPECT_LE(most, 1.5 * can * (1 + 1e-6)) << "of " << can << ", the wall " << wall;
    full += most > 1.3 * can ? 1 : 0;
  });
  EXPECT_GT(full, drawn(10u));
}

}  // namespace
}  // namespace hapticd
