// Local models replaced at random while the hand moves at random: the formula
// and the bound of rt/render/model/local_model.h.
#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "rt/render/model/local_model.h"
#include "tests/support/for_seeds.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

Command randomModel(Random& random) {
  Command c;
  if (random.once(5)) {
    c.kind = CommandKind::kForceField;
    auto& f = c.as<hd_force_field>();
    f.lease_ns = random.below(120) * kMs;
    f.blend_ns = random.below(30) * kMs;
    store(random.vector(0.01), f.x0);
    store(random.vector(2), f.f0);
    for (double& j : f.jacobian) j = random.in(-300, 300);
    f.radius = random.in(0.005, 0.05);
    return c;
  }
  c.kind = CommandKind::kLocalModel;
  auto& m = c.as<hd_local_model>();
  m.kind = static_cast<std::uint32_t>(1 + random.below(5));
  m.lease_ns = random.below(120) * kMs;
  m.blend_ns = random.below(30) * kMs;
  m.material.stiffness = random.in(0, 2000);
  m.material.damping = random.in(0, 5);
  store(random.vector(0.01), m.origin);
  store(random.vector(1) + Vec3(0, 0, 1.01), m.normal);
  store(Vec3(vec3(m.normal).normalized()), m.normal);
  m.radius = random.in(0.005, 0.03) * (m.kind == HD_MODEL_SPHERE && random.once(2) ? -1 : 1);
  m.count = static_cast<std::uint32_t>(1 + random.below(HD_HALFSPACES));
  for (std::uint32_t i = 0; i < m.count; ++i) {
    const Vec3 n = (random.vector(1) + Vec3(0, 0, 0.01)).normalized();
    for (int k = 0; k < 3; ++k) m.halfspace[i][k] = static_cast<float>(n[k]);
    m.halfspace[i][3] = static_cast<float>(random.in(0, 0.01));
  }
  return c;
}

/** The header's formula, kept by hand beside the slot. Frictionless models:
 * they have no memory. */
struct Account {
  LocalModel now, old;
  bool has_now = false, has_old = false;
  double c = 0, now_weight = 0, agreed_weight = 0;
  Vec3 r = Vec3::Zero(), last = Vec3::Zero(), last_of_now = Vec3::Zero();
  std::int64_t start = 0, applied = 0, blend = 5 * kMs, lease = 0;
  bool fresh = false;  ///< Replaced in this tick.

  void replace(const LocalModel& next, bool has_next, std::int64_t at, std::int64_t blend_ns, std::int64_t lease_ns,
               bool was_empty) {
    if (!fresh) {
      start = was_empty ? at : at - kMs;  // The last tick of the old one.
      old = now;
      c = has_now ? now_weight : 0;
      if (has_now && last_of_now.norm() > 1e-12) {
        const double least_squares = last.dot(last_of_now) / last_of_now.squaredNorm();
        c = std::max(c, std::min(1.0, least_squares));
      } else if (has_now && last.norm() <= 1e-12) {
        c = agreed_weight;
      }
      has_old = has_now;
      r = last - c * last_of_now;
    }
    now = next;
    has_now = has_next;
    applied = at;
    blend = std::max(blend_ns, LocalModelSlot::kMinBlendNs);
    lease = lease_ns;
    fresh = true;
  }
};

TEST(SlotProperty, ForceIsContinuousAndWithinTheStatedBound) {
  int replaced = 0, mid_blend = 0;
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    MeshTable meshes;
    const auto scene = std::make_unique<Scene>(meshes);
    LocalModelSlot slot;
    Account a;
    ToolPoint tool;
    Vec3 former = Vec3::Zero(), former_new = Vec3::Zero(), former_old = Vec3::Zero();
    Vec3 former_unfaded = Vec3::Zero();
    double former_s = 1;
    std::int64_t now = 1000 * kMs;
    for (int tick = 0; tick < 3000; ++tick, now += kMs) {
      tool.v = 0.98 * tool.v + random.vector(0.01) - 2 * tool.p;
      tool.p += 1e-3 * tool.v;
      a.fresh = false;
      const int times = random.once(15) ? 1 + random.below(2) : 0;
      for (int i = 0; i < times; ++i) {
        if (random.once(6)) {
          const std::int64_t blend = random.below(20) * kMs;
          if (!slot.empty()) a.replace({}, false, now, blend, std::numeric_limits<std::int64_t>::max(), false);
          slot.clear(now, blend);
          continue;
        }
        const Command command = randomModel(random);
        const bool was_empty = slot.empty();
        ASSERT_EQ(slot.set(command, now, *scene), ErrorCode::kOk);
        LocalModel next;
        (void)next.set(command);
        mid_blend += a.has_now && now - a.start < a.blend;
        a.replace(next, true, now, next.blend_ns(), next.lease_ns(), was_empty);
        ++replaced;
      }
      const Vec3 f = slot.evaluate(tool, now, *scene).force;
      ASSERT_TRUE(isFinite(f));

      const double s = std::min(1.0, static_cast<double>(now - a.start) / static_cast<double>(a.blend));
      const std::int64_t late = a.has_now ? now - a.applied - a.lease : -1;
      const double w = late > 0 ? std::max(0.0, 1 - static_cast<double>(late) / LocalModelSlot::kFadeNs) : 1;
      const Vec3 f_new = a.has_now ? a.now.evaluate(tool.p, tool.v, {}).force : Vec3(Vec3::Zero());
      const Vec3 f_old = a.c * a.old.evaluate(tool.p, tool.v, {}).force + a.r;
      ASSERT_LT((f - w * (s * f_new + (1 - s) * f_old)).norm(), 1e-9) << "tick " << tick;
      if (w == 0) a = Account{};

      if (a.fresh) {
        // In the tick of replacement nothing has changed but what the old model did with the hand's motion, and one
        // tick of the blend.
        const double first = static_cast<double>(now - a.start) / static_cast<double>(a.blend);
        ASSERT_LE(first, static_cast<double>(kMs) / static_cast<double>(a.blend));
        ASSERT_LE((f - f_old).norm(), first * (f_new - f_old).norm() + 1e-9);
      } else {
        const double blending = former_s < 1 ? static_cast<double>(kMs) / static_cast<double>(a.blend) : 0;
        const double fading = late > 0 ? static_cast<double>(kMs) / LocalModelSlot::kFadeNs : 0;
        const double bound = std::max((f_new - former_new).norm(), (f_old - former_old).norm()) +
                             blending * (former_new - former_old).norm() + fading * former_unfaded.norm();
        ASSERT_LE((f - former).norm(), bound + 1e-9) << "tick " << tick;
      }
      former = f;
      former_new = f_new;
      former_old = f_old;
      former_unfaded = s * f_new + (1 - s) * f_old;
      former_s = s;
      a.last = f;
      a.last_of_now = f_new;
      a.now_weight = w * s;
      a.agreed_weight = w * (s + (a.has_old ? (1 - s) * a.c : 0));
    }
  });
  if (drawsAll()) {
    EXPECT_GT(replaced, 3000);
    EXPECT_GT(mid_blend, 500);
  }
}

/** Of a hand that rests: what is stored more than a tick ago, the client has put in, and that is what is charged to
 * him. */
TEST(SlotProperty, WhatReplacedModelsAddIsBookedToTheJoule) {
  double booked = 0;
  forSeeds(40, [&](unsigned seed) {
    Random random(seed);
    MeshTable meshes;
    const auto scene = std::make_unique<Scene>(meshes);
    LocalModelSlot slot;
    ToolPoint tool;
    double former = 0;
    std::int64_t now = 1000 * kMs;
    const int period = 1 + random.below(20);
    for (int tick = 0; tick < 3000; ++tick, now += kMs) {
      const bool rests = tick % 50 != 0;
      if (!rests) tool.p = random.vector(0.01);
      if (random.once(period)) {
        Command command = randomModel(random);
        if (command.kind == CommandKind::kLocalModel) command.as<hd_local_model>().lease_ns = 10'000 * kMs;
        if (command.kind == CommandKind::kForceField) command.as<hd_force_field>().lease_ns = 10'000 * kMs;
        ASSERT_EQ(slot.set(command, now, *scene), ErrorCode::kOk);
      } else if (random.once(100)) {
        slot.clear(now, random.below(20) * kMs);
      }
      const ModelForce f = slot.evaluate(tool, now, *scene);
      if (rests) {
        const double put_in = 1e-3 * f.carried.sum();
        ASSERT_NEAR(put_in, std::max(0.0, f.stored - former), 1e-12) << "tick " << tick;
        booked += put_in;
      }
      former = f.stored;
    }
  });
  if (drawsAll()) {
    EXPECT_GT(booked, 10.0);
  }
}

}  // namespace
}  // namespace hapticd
