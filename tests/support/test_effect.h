/** @file
 * A scene with effects and one hand, in few words.
 */
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>

#include "rt/effect/object_effects.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd::test {

[[nodiscard]] inline EffectParameters effect(EffectKind kind, double force = 2, double stiffness = 200,
                                             double damping = 0, double reach = 0.05) {
  EffectParameters out{};
  out.kind = static_cast<std::uint32_t>(kind);
  out.force = force;
  out.stiffness = stiffness;
  out.damping = damping;
  out.reach = reach;
  out.frequency = 50;
  return out;
}

[[nodiscard]] inline EffectParameters along(EffectParameters effect, std::initializer_list<Vec3> points) {
  for (const Vec3& point : points) {
    for (int axis = 0; axis < 3; ++axis) effect.path[effect.points][axis] = static_cast<float>(point[axis]);
    ++effect.points;
  }
  return effect;
}

inline void expectForce(const Vec3& got, const Vec3& wanted, double tolerance = 1e-6) {
  EXPECT_LT((got - wanted).norm(), tolerance) << got.transpose() << ", not " << wanted.transpose();
}

struct EffectScene : TestScene {
  ErrorCode set(std::uint32_t id, const EffectParameters& parameters) {
    return apply(CommandKind::kSetEffect, SetEffect{id, 0, parameters});
  }
  /** An object without a shape that has it. */
  std::uint32_t add(const EffectParameters& parameters, const Pose& X = {}) {
    const std::uint32_t id = TestScene::add(ShapeKind::kGroup, Vec3::Zero(), X);
    EXPECT_EQ(set(id, parameters), ErrorCode::kOk);
    return id;
  }
  using TestScene::add;
  /** A tick later, with the hand at p. */
  Vec3 feel(const Vec3& p, const Vec3& v = Vec3::Zero()) {
    scene->advance(kTick);
    now_ns += 1'000'000;
    return hand.step(*scene, p, v, kTick, now_ns);
  }
  /** As feel(), with what changed before long over. */
  Vec3 settled(const Vec3& p, const Vec3& v = Vec3::Zero()) {
    for (int i = 0; i < 30; ++i) (void)feel(p, v);
    return feel(p, v);
  }

  ObjectEffects hand;
  std::int64_t now_ns = 0;
};

}  // namespace hapticd::test
