/** @file
 * Solids of any kind that appear about a hand, about its proxy, or about both, while a wall holds it or in the air: by
 * being made, enabled or put there. Nobody is pushed, and who is inside feels nothing of it.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kAppearingStiffness = 1000, kClearlyInside = 1e-4;

/** How far x_W is inside [m]; negative outside. */
double howDeep(const SceneObject& object, const Vec3& x_W) {
  const Vec3 x = object.X_WO.inverse() * x_W;
  if (object.shape.kind != ShapeKind::kMesh) return -test::distanceTo(object.shape, x);
  const double distance = test::distanceTo(*object.shape.mesh, x);
  return test::windingNumber(*object.shape.mesh, x) > 0.5 ? distance : -distance;
}

/** A hand in the air, or deep in a wall, and a solid that is about to appear. */
struct Appearing {
  Random random;
  double mu;
  hd_material material;
  ShapeKind kind = ShapeKind::kSphere;
  Vec3 size;
  TestMesh mesh;
  MeshView* view = nullptr;
  TestScene t;      ///< In it the solid appears;
  TestScene plain;  ///< here it does not.
  Vec3 hip;
  std::uint32_t id = 0;

  explicit Appearing(std::uint32_t seed)
      : random(seed), mu(random.once(2) ? 0 : random.in(0.1, 1)), material{kAppearingStiffness, 0, mu, 0.7 * mu} {
    const double radius = random.once(2) ? 0 : random.in(5e-4, 4e-3), deep = random.in(5e-4, 0.01);
    constexpr ShapeKind kKinds[] = {ShapeKind::kSphere,   ShapeKind::kBox,  ShapeKind::kCapsule,
                                    ShapeKind::kCylinder, ShapeKind::kMesh, ShapeKind::kMesh};
    const int which = random.below(6);
    const bool walled = random.once(1.5), plane = random.once(2);
    kind = kKinds[which];
    size = Vec3(random.in(0.005, 0.03), random.in(0.005, 0.03), random.in(0.005, 0.03));
    mesh = which == 4 ? test::boxMesh(size) : test::sphereMesh(size.x(), 6);
    if (kind == ShapeKind::kMesh) view = mesh.view();
    for (TestScene* scene : {&t, &plain}) {
      scene->proxy.setRadius(radius);
      if (walled && plane) scene->add(ShapeKind::kPlane, Vec3::Zero(), {}, material);
      if (walled && !plane)
        scene->add(ShapeKind::kBox, {0.03, 0.03, 0.02}, {Vec3(0, 0, -0.02), Quat::Identity()}, material);
    }
    tick(Vec3(0, 0, 0.1));
    for (int i = 0; i <= 60; ++i) tick(Vec3(0, 0, 0.1 - (0.1 + (walled ? deep - radius : 0)) * i / 60));
    const Vec3 slide = random.vector(2e-4);
    for (int i = 0; i < 20; ++i) tick(hip + Vec3(slide.x(), slide.y(), 0));
  }
  void tick(const Vec3& x) {
    hip = x;
    t.tick(x);
    plain.tick(x);
  }
  void appear() {
    Pose X = random.pose(0.02);
    X.p += random.once(2) ? hip : t.contact.proxy;
    const int how = random.below(3);
    if (how == 0) {
      id = t.add(kind, size, X, material, HD_OBJECT_ENABLED, 0, view);
    } else {
      const Pose first{X.p + (how == 2 ? Vec3(0, 0, 1) : Vec3::Zero()), X.q};
      id = t.add(kind, size, first, material, how == 2 ? HD_OBJECT_ENABLED : 0, 0, view);
      tick(hip);
      if (how == 1) t.flags(id, HD_OBJECT_ENABLED, HD_OBJECT_ENABLED);
      if (how == 2) t.pose(id, X);
    }
  }
  [[nodiscard]] double away() const { return (t.contact.proxy - hip).norm(); }
  [[nodiscard]] const SceneObject& solid() const { return *t.scene->find(id); }
};

TEST(AppearProperty, WhatAppearsPushesNobodyHarder) {
  int pressed = 0;
  forSeeds(1000, [&](unsigned seed) {
    Appearing a(seed);
    a.appear();
    double before = a.away();
    const Vec3 step = a.random.vector(1e-4);
    for (int i = 0; i < 200; ++i) {
      a.tick(i < 5 ? a.hip : Vec3(a.hip + step));
      ASSERT_LE(a.away(), before + (i < 5 ? 0 : step.norm()) + 1e-9) << "tick " << i;
      ASSERT_LE(a.t.contact.force.norm(), kAppearingStiffness * a.away() * (1 + 1e-9)) << "tick " << i;
      before = a.away();
      pressed += a.t.contact.object == a.id;
    }
  });
  EXPECT_GT(pressed, drawn(5000));
}

/** Nor is it gone around: as long as it has not been left it is as if it were not there. */
TEST(AppearProperty, WhoIsInsideFeelsNothingOfIt) {
  int inside = 0, held = 0;
  forSeeds({11145}, 3000, [&](unsigned seed) {
    Appearing a(seed);
    a.appear();
    const Vec3 step = a.random.vector(1e-4);
    for (int i = 0; i < 400; ++i) {
      const Vec3 force = a.plain.contact.force;
      a.tick(i < 5 ? a.hip : Vec3(a.hip + step));
      // Around the wall the way may lead out of the solid, and then not back into it.
      if ((a.plain.contact.force - force).norm() > 1) break;
      if (!(howDeep(a.solid(), a.plain.contact.proxy) > kClearlyInside)) break;
      ASSERT_NEAR((a.t.contact.force - a.plain.contact.force).norm(), 0, 1e-6) << "tick " << i;
      ++inside;
      held += a.plain.contact.object != 0;
    }
  });
  EXPECT_GT(inside, 50'000);
  EXPECT_GT(held, 20'000);
}

}  // namespace
}  // namespace hapticd
