/** @file
 * A scene and a hand drawn at random, and ways to tell the same: whoever touches it must feel the same.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "rt/render/surface/shading.h"
#include "tests/support/random.h"
#include "tests/support/shape/retold_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd::test {

/** What a scene is drawn of. */
struct SceneWish {
  int bodies = 0;           ///< 0: one to three.
  bool primitives = false;  ///< Beside meshes.
  bool friction = false, damping = false, shading = false, moving = false;
  bool ball = false;      ///< In place of a point.
  bool creeping = false;  ///< The hand is slow.
};

/** A scene, and where the hand is in each tick. */
struct ToldScene {
  struct Body {
    ShapeKind kind = ShapeKind::kMesh;
    Vec3 size = Vec3::Zero();
    TestMesh mesh;
    Pose home;
    hd_material material{};
    double smooth_cosine = 0;  ///< Of its shading; 0: none.
    Vec3 spin = Vec3::Zero(), sway = Vec3::Zero();
  };
  std::vector<Body> bodies;
  std::vector<Vec3> hand;
  double radius = 0;
  bool moving = false;

  ToldScene(std::uint32_t seed, const SceneWish& wish, int ticks) : moving(wish.moving) {
    Random random(seed);
    if (wish.ball) radius = std::exp(random.in(std::log(1e-5), std::log(1e-3)));
    const int count = wish.bodies != 0 ? wish.bodies : 1 + random.below(3);
    for (int i = 0; i < count; ++i) bodies.push_back(drawBody(random, wish, i == 0 ? 0.01 : 0.035));
    moveHand(random, wish.creeping, ticks);
  }

 private:
  static Body drawBody(Random& random, const SceneWish& wish, double away) {
    Body b;
    if (wish.primitives && random.once(2)) {
      b.kind = static_cast<ShapeKind>(static_cast<int>(ShapeKind::kSphere) + random.below(4));
      for (double& x : b.size) x = random.in(0.008, 0.03);
    } else {
      b.mesh = drawMesh(random);
      if (wish.shading) b.smooth_cosine = std::cos(random.in(0.3, 1.2));
    }
    b.home = random.pose(away);
    const double mu = wish.friction ? random.in(0.1, 1.2) : 0, damping = wish.damping ? random.in(0, 4) : 0;
    b.material.stiffness = random.in(300, 2000);
    b.material.damping = damping;
    b.material.friction_static = mu;
    b.material.friction_dynamic = random.in(0.5, 0.95) * mu;
    if (wish.moving) {
      b.spin = random.vector(3);
      b.sway = random.vector(0.004);
    }
    return b;
  }

  static TestMesh drawMesh(Random& random) {
    const double size = random.in(0.012, 0.03), rough = std::pow(10, random.in(-4, -2));
    const auto parts = 4 + random.below(10u);
    TestMesh mesh;
    Vec3 half;
    switch (random.below(6)) {
      case 0:
        for (double& x : half) x = random.in(0.004, 0.03);
        mesh = boxMesh(half);
        break;
      case 1:
        mesh = sphereMesh(size, parts);
        break;
      case 2:
        mesh = sphereMesh(size, 3 + parts / 2);
        mesh.scale([&] { return random.in(0.7, 1.1); });
        break;
      case 3:
        mesh = heightMesh(0.04, parts, [&](double, double) { return random.in(-rough, rough); });
        break;
      case 4:
        mesh = coneMesh(size, 1.5 * size, parts + 3);
        break;
      default:
        mesh = torusMesh(0.7 * size, 0.3 * size, parts + 2);
    }
    toSteps(mesh);
    return mesh;
  }

  void moveHand(Random& random, bool creeping, int ticks) {
    constexpr int kWayIn = 60;        // Ticks in which a slow hand comes near.
    constexpr double kCreeps = 3e-5;  // In a tick [m].
    Vec3 at(0, 0, 0.12), aim = at;
    double speed = creeping ? 0.1 : 0.01;
    for (int i = 0; i < ticks; ++i) {
      const bool creeps = creeping && i > kWayIn;
      if (i == 0 || random.once(creeps ? 150 : 25))
        aim = bodies[random.below(bodies.size())].home.p + random.vector(creeping ? 0.02 : 0.036);
      if (random.once(30)) speed = creeping ? 0.1 : std::pow(10, random.in(-3, -0.5));
      const double far = (aim - at).norm(), part = far > kCreeps ? kCreeps / far : 1.0;
      at += (creeps ? part : speed) * (aim - at);
      hand.push_back(at);
    }
  }
};

/** How it is told. */
struct SceneTelling {
  std::uint32_t shuffle = 0;  ///< Seed of another order of triangles and of their corners; 0: as they are.
  bool in_four = false;       ///< Each triangle is cut.
  Pose at;                    ///< Where all of it stands.
};

/** A scene as it is told, stepped tick by tick. */
class RetoldScene {
 public:
  RetoldScene(const ToldScene& what, const SceneTelling& how) : what_(what), how_(how), t_(what.radius) {
    meshes_.reserve(what.bodies.size());
    for (const ToldScene::Body& b : what.bodies) {
      TestMesh& mesh = meshes_.emplace_back(how.in_four ? inFour(b.mesh) : b.mesh);
      if (how.shuffle != 0) shuffle(mesh, how.shuffle);
      MeshView* const view = b.kind == ShapeKind::kMesh ? mesh.view() : nullptr;
      ids_.push_back(t_.add(b.kind, b.size, how.at * b.home, b.material, kOneSided, 0, view));
      SurfaceParameters surface{};
      surface.smooth_cosine = b.smooth_cosine;
      if (b.smooth_cosine > 0) t_.setSurface(ids_.back(), surface);
    }
    t_.tick(how.at * Vec3(0, 0, 0.5));
  }

  /** The next tick's force, told back. */
  Vec3 next() {
    constexpr double kSways = 20;  // [rad/s]
    const Quat& q = how_.at.q;
    const Vec3 hip = what_.hand[tick_], before = what_.hand[tick_ > 0 ? tick_ - 1 : 0];
    const double t = kTick * static_cast<double>(++tick_);
    for (std::size_t i = 0; what_.moving && i < ids_.size(); ++i) {
      const ToldScene::Body& b = what_.bodies[i];
      const Pose X{b.home.p + std::sin(kSways * t) * b.sway, rotated(b.home.q, b.spin, t)};
      const Vec3 v = kSways * std::cos(kSways * t) * b.sway;
      t_.pose(ids_[i], how_.at * X, {q * v, q * b.spin});
    }
    const Vec3 v = q * ((hip - before) / kTick);
    t_.tick(how_.at * hip, v);
    shading_.step(*t_.scene, t_.proxy.holding(), v, t_.contact);
    return q.conjugate() * t_.contact.force;
  }
  [[nodiscard]] const SurfaceContact& contact() const { return t_.contact; }

 private:
  const ToldScene& what_;
  SceneTelling how_;
  TestScene t_;
  Shading shading_;
  std::vector<TestMesh> meshes_;
  std::vector<std::uint32_t> ids_;
  std::size_t tick_ = 0;
};

}  // namespace hapticd::test
