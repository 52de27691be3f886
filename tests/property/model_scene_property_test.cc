// Without friction a local model is the scene that it stands for: planes, balls, corners and convex solids feel alike,
// whether a client describes them or the servo has them as objects. Two ways to one force, of which neither knows the
// other.
#include <gtest/gtest.h>

#include "tests/support/for_seeds.h"
#include "tests/support/stepped/test_scene.h"
#include "tests/unit/render/model_rig.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestScene;

constexpr int kWandered = 600;

/** A hand that wanders between two corners as seen from `middle`, at all speeds. It begins at the second. */
class Wanderer {
 public:
  Wanderer(Random& random, const Vec3& middle, const Vec3& from, const Vec3& to)
      : random_(random), middle_(middle), from_(from), to_(to), hand_(middle + to), aim_(to) {}
  const Vec3& next() {
    if (random_.once(60)) {
      for (int i = 0; i < 3; ++i) aim_[i] = random_.in(from_[i], to_[i]);
      speed_ = std::pow(10, random_.in(-2.3, -0.7));
    }
    return hand_ += speed_ * (middle_ + aim_ - hand_);
  }

 private:
  Random& random_;
  Vec3 middle_, from_, to_, hand_, aim_;
  double speed_ = 0.01;
};

struct Both {
  TestScene scene;
  hd_local_model model;
  hd_material material;
  unsigned touched = 0;

  Both(Random& random, hd_model_kind kind)
      : model(modelOf(kind, random.in(200, 3000))), material{model.material.stiffness, 0, 0, 0} {}
  /** Another velocity is felt by damping alone, and here nothing damps. */
  void run(Wanderer& hand) {
    LoneModel lone(model);
    for (int i = 0; i < kWandered; ++i) {
      const Vec3 x = hand.next(), f = scene.tick(x).force;
      ASSERT_LT((f - lone.at(x)).norm(), 1e-6 * (1 + f.norm())) << "tick " << i;
      touched += f.isZero(0) ? 0 : 1;
    }
  }
};

constexpr unsigned kScenes = 60;

TEST(ModelSceneProperty, APlaneIsAPlane) {
  unsigned touched = 0;
  forSeeds(kScenes, [&](unsigned seed) {
    Random random(seed);
    Both both(random, HD_MODEL_PLANE);
    const Pose X = random.pose(0.05);
    both.scene.add(ShapeKind::kPlane, Vec3::Zero(), X, both.material);
    store(Vec3(X.q * Vec3::UnitZ()), both.model.normal);
    store(X.p, both.model.origin);
    Wanderer hand(random, X.p, Vec3::Constant(-0.01), X.q * Vec3(0, 0, 0.01));
    both.run(hand);
    touched += both.touched;
  });
  EXPECT_GT(touched, seeds(kScenes).size() * kWandered / 20);
}

TEST(ModelSceneProperty, ABallIsABall) {
  unsigned touched = 0;
  forSeeds(kScenes, [&](unsigned seed) {
    Random random(seed);
    Both both(random, HD_MODEL_SPHERE);
    const Pose X = random.pose(0.05);
    both.scene.add(ShapeKind::kSphere, {0.02, 0, 0}, X, both.material);
    store(X.p, both.model.origin);
    Wanderer hand(random, X.p, {0.005, -0.03, -0.03}, {0.03, 0.03, 0.03});  // Its middle fades.
    both.run(hand);
    touched += both.touched;
  });
  EXPECT_GT(touched, seeds(kScenes).size() * kWandered / 20);
}

TEST(ModelSceneProperty, ACornerIsOneOfThreePlanes) {
  unsigned touched = 0;
  forSeeds(kScenes, [&](unsigned seed) {
    Random random(seed);
    Both both(random, HD_MODEL_CORNER);
    const Vec3 at = random.vector(0.05);
    store(at, both.model.origin);
    for (int i = 0; i < 3; ++i) {
      setHalfspace(both.model, Vec3::Unit(i), 0);
      both.scene.add(ShapeKind::kPlane, Vec3::Zero(), {at, Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::Unit(i))},
                     both.material);
    }
    Wanderer hand(random, at, Vec3::Constant(-0.01), Vec3::Constant(0.006));
    both.run(hand);
    touched += both.touched;
  });
  EXPECT_GT(touched, seeds(kScenes).size() * kWandered / 20);
}

/** About one of its edges, where the hand comes to be under each of two faces. */
TEST(ModelSceneProperty, ASharpSolidIsABox) {
  unsigned touched = 0;
  forSeeds(kScenes, [&](unsigned seed) {
    Random random(seed);
    Both both(random, HD_MODEL_HALFSPACES);
    both.model.radius = 1e-9;
    const Vec3 size(0x5p-8, 0x1p-5, 0x3p-7), at = random.vector(0.05);
    store(at, both.model.origin);
    both.scene.add(ShapeKind::kBox, size, {at, Quat::Identity()}, both.material);
    for (int i = 0; i < 3; ++i) {
      setHalfspace(both.model, Vec3::Unit(i), size[i]);
      setHalfspace(both.model, -Vec3::Unit(i), size[i]);
    }
    Wanderer hand(random, at + size, {-0.008, -0.008, -0.015}, {0.004, 0.004, -0.01});
    both.run(hand);
    touched += both.touched;
  });
  EXPECT_GT(touched, seeds(kScenes).size() * kWandered / 20);
}

}  // namespace
}  // namespace hapticd
