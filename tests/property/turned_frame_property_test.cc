// A body at rest and a hand that moves, or both carried along and turned: the same is felt.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "rt/base/rotation.h"
#include "rt/render/surface/surface_effects.h"
#include "tests/support/for_seeds.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/test_effect.h"

namespace hapticd {
namespace {

using test::EffectScene;
using test::kTick;
using test::TestMesh;
using test::TestRelief;

/** In which bodies and hand are told: still, or carried and turned at a steady speed. */
struct SteadyFrame {
  Twist speed;

  [[nodiscard]] Pose at(int tick) const {
    return {tick * kTick * speed.v, rotated(Quat::Identity(), speed.w, kTick * tick)};
  }
  /** Of what is fixed to it at x, in W. */
  [[nodiscard]] Twist of(int tick, const Vec3& x) const { return {speed.v + speed.w.cross(at(tick).q * x), speed.w}; }
};

SteadyFrame anySteadyFrame(Random& random) {
  const Vec3 v = random.vector(0.5), w = random.vector(10);
  return {{v, w}};
}

/** A hand that wanders about. */
struct WanderingHand {
  static constexpr int kSines = 3;
  Vec3 size[kSines];
  double rate[kSines], phase[kSines];  ///< [rad/s], [rad]

  WanderingHand(Random& random, double reach) {
    for (int i = 0; i < kSines; ++i) {
      size[i] = random.vector(reach);
      rate[i] = random.in(1, 25);
      phase[i] = random.in(0, 6);
    }
  }
  [[nodiscard]] Vec3 at(double t) const {
    Vec3 x = Vec3::Zero();
    for (int i = 0; i < kSines; ++i) x += std::sin(rate[i] * t + phase[i]) * size[i];
    return x;
  }
  [[nodiscard]] Vec3 velocity(double t) const {
    Vec3 v = Vec3::Zero();
    for (int i = 0; i < kSines; ++i) v += rate[i] * std::cos(rate[i] * t + phase[i]) * size[i];
    return v;
  }
};

/** A body and a hand that feels it, told in a frame. */
struct CarriedTouch {
  SteadyFrame frame;
  Pose X;
  test::TestScene scene;
  SurfaceEffects effects{3};
  std::uint32_t body = 0;
  int tick = 0;
  Vec3 force;                       ///< Told in the frame.
  double stored = 0;                ///< [J]
  double charged = 0, carries = 0;  ///< What the guard is told that the body gives, and what it does [W].

  void step(const Vec3& hand, const Vec3& velocity) {
    ++tick;
    const Pose F = frame.at(tick);
    if (!frame.speed.w.isZero(0)) {
      EXPECT_EQ(scene.pose(body, F * X, frame.of(tick, X.p)), ErrorCode::kOk);
    }
    const Vec3 hip = F * hand, along = frame.of(tick, hand).v, v = along + F.q * velocity;
    scene.tick(hip, v);
    const SurfaceContact& contact = scene.contact;
    const SurfaceForces added = effects.step(*scene.scene, contact, scene.proxy.holding(), hip, v);
    const Vec3 all = contact.force + added.relief;
    force = F.q.conjugate() * all;
    stored = added.stored;
    charged = contact.force.dot(contact.velocity) + contact.apart.sum() + added.carried.sum();
    carries = all.dot(along);
  }
};

struct CarriedBody {
  int kind;
  Vec3 size;
  hd_material material;
  double radius;
};

/** What is given is told; and, if `alike`, the same hand feels it alike where it rests and where it is carried. */
void expectFeltAlike(Random& random, const CarriedBody& is, const SurfaceParameters& surface,
                     const TextureView* texture, bool alike = true) {
  TestMesh mesh = test::sphereMesh(0.03, 12);
  const Pose X = random.pose(0.02);
  const auto make = [&](const SteadyFrame& frame) {
    auto t = std::make_unique<CarriedTouch>();
    t->frame = frame;
    t->X = X;
    t->scene.proxy.setRadius(is.radius);
    if (texture != nullptr) t->scene.table->publishTexture(0, texture);
    constexpr ShapeKind kKinds[] = {ShapeKind::kBox, ShapeKind::kCapsule, ShapeKind::kCylinder, ShapeKind::kSphere};
    t->body = is.kind < 4 ? t->scene.add(kKinds[is.kind], is.size, X, is.material)
                          : t->scene.addMesh(mesh.view(), X, is.material);
    EXPECT_EQ(t->scene.setSurface(t->body, surface), ErrorCode::kOk);
    return t;
  };
  const auto still = make({}), moves = make(anySteadyFrame(random));
  const WanderingHand hand(random, 0.03);
  const Vec3 out = 0.06 * random.vector(1).normalized();
  for (int i = 0; i < 1500; ++i) {
    constexpr double kIn_s = 0.1;  // It comes from outside.
    const double t = i * kTick, in = std::min(1.0, t / kIn_s);
    const Vec3 at = (1 - in) * out + in * hand.at(t);
    const Vec3 v = in < 1 ? Vec3(in * hand.velocity(t) + (hand.at(t) - out) / kIn_s) : hand.velocity(t);
    still->step(at, v);
    moves->step(at, v);
    if (alike) {
      ASSERT_LT((moves->force - still->force).norm(), 1e-6) << "tick " << i;
      ASSERT_NEAR(moves->stored, still->stored, 1e-9);
    }
    ASSERT_NEAR(moves->charged, moves->carries, 1e-6) << "tick " << i;
  }
}

Vec3 anySize(Random& random) { return {random.in(0.01, 0.03), random.in(0.01, 0.03), random.in(0.01, 0.03)}; }

TEST(TurnedFrameProperty, AReliefOnWhatIsCarriedIsThatOnWhatRests) {
  forSeeds(40, [](unsigned seed) {
    Random random(seed);
    const TestRelief picture(24, 24, [&](auto, auto) { return random.in(0, 1); });
    SurfaceParameters s{};
    s.relief = 1;
    s.relief_depth = random.in(1e-4, 2e-3);
    s.relief_size[0] = s.relief_size[1] = random.in(0.05, 0.1);
    const double damping = random.once(2) ? random.in(0, 5) : 0;
    const CarriedBody body{
        random.below(5), anySize(random), {random.in(300, 2000), damping, 0, 0}, random.once(2) ? 1e-3 : 0.0};
    expectFeltAlike(random, body, s, &picture.view);
  });
}

/**
 * Who sticks to what turns is not damped, though the place that holds him moves otherwise than he does. On a curve the
 * border of the cone is found to some microns; what is given is known there all the same.
 */
TEST(TurnedFrameProperty, FrictionAndDampingOnWhatIsCarriedAreThoseOnWhatRests) {
  forSeeds(40, [](unsigned seed) {
    Random random(seed);
    const int kind = random.once(2) ? 0 : 1 + random.below(4);
    const CarriedBody body{
        kind, anySize(random), {random.in(300, 2000), random.in(0, 5), 0.8, 0.5}, random.once(2) ? 1e-3 : 0.0};
    expectFeltAlike(random, body, {}, nullptr, kind == 0);
  });
}

TEST(TurnedFrameProperty, EffectsOfWhatIsCarriedAreThoseOfWhatRests) {
  forSeeds(40, [](unsigned seed) {
    Random random(seed);
    const SteadyFrame frame = anySteadyFrame(random);
    EffectScene still, moves;
    std::vector<Pose> X;
    std::vector<std::uint32_t> id;
    for (int i = 0; i < 3; ++i) {
      EffectParameters e = test::effect(static_cast<EffectKind>(1 + random.below(5u)), random.in(0, 4),
                                        random.in(0, 500), random.in(0, 5), random.in(0.005, 0.08));
      e.points = random.once(2) ? 2 + random.below(8u) : 0;
      for (std::uint32_t k = 0; k < e.points; ++k)
        for (float& x : e.path[k]) x = static_cast<float>(random.in(-0.05, 0.05));
      const auto kind = static_cast<ShapeKind>(random.below(6u));
      const Vec3 size = anySize(random);
      const std::uint32_t flags = random.once(2) ? std::uint32_t{HD_OBJECT_ENABLED} : 0;
      X.push_back(random.pose(0.05));
      for (EffectScene* t : {&still, &moves}) {
        id.push_back(t->TestScene::add(kind, size, X.back(), {1000, 0, 0, 0}, flags));
        ASSERT_EQ(t->set(id.back(), e), ErrorCode::kOk);
      }
    }
    const WanderingHand hand(random, 0.04);
    int apart = 0;
    for (int i = 0; i < 1500; ++i) {
      const Vec3 at = hand.at(i * kTick), v = hand.velocity(i * kTick);
      const Pose F = frame.at(i);
      for (std::size_t k = 0; k < X.size(); ++k)
        ASSERT_EQ(moves.pose(id[2 * k + 1], F * X[k], frame.of(i, X[k].p)), ErrorCode::kOk);
      const Vec3 felt = still.feel(at, v);
      const Vec3 told = F.q.conjugate() * moves.feel(F * at, frame.of(i, at).v + F.q * v);
      if ((felt - told).norm() > 1e-6) ++apart;
    }
    EXPECT_LE(apart, 2) << "more than where two places are equally near";
  });
}

}  // namespace
}  // namespace hapticd
