/** @file
 * A proxy that an object takes along: what must hold of it whatever comes. A failure names its seed.
 */
#include <gtest/gtest.h>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"
#include "tests/support/stepped/wandering_hand.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;
using test::WanderingHand;

/** Rough ground, open, alone in its scene and on its way: in its own frame the spring gains nothing of it. */
void whatCarriesGivesNothingElse(std::uint32_t seed, int& contacts) {
  Random random(seed);
  TestScene t;
  TestMesh mesh =
      test::heightMesh(0.03, 4 + random.below(12u), [&](double, double) { return random.in(-0.003, 0.003); });
  const double mu = seed % 3 == 0 ? random.in(0, 1.5) : 0;
  const std::uint32_t id = t.addMesh(mesh.view(), random.pose(0.01), {1000, 0, mu, 0.5 * mu});
  t.proxy.setRadius(std::pow(10.0, random.in(-4, -1.3)));
  WanderingHand hand(random, 0.05);
  t.tick(Vec3(0, 0, 0.2));
  const SceneObject& object = *t.scene->find(id);
  for (int i = 0; i < 500; ++i) {
    if (random.below(10) == 0) {
      const Vec3 v = object.X_WO.p.norm() > 0.04 ? Vec3(-4 * object.X_WO.p) : random.vector(0.2);
      t.pose(id, object.X_WO, {v, random.vector(3)});
    }
    const Vec3 hip = hand.next(), from = t.contact.proxy;
    const bool held = t.contact.object != 0;
    t.tick(hip);
    if (!held || t.contact.object == 0) continue;
    const Vec3 carried = object.X_WO * (object.X_WO_before.inverse() * from);
    ASSERT_LT((t.contact.proxy - hip).norm(), (carried - hip).norm() * (1 + 1e-6) + 1e-9) << "tick " << i;
    ++contacts;
  }
}

TEST(CarriedProxyProperty, AnObjectThatMovesGivesTheSpringNothingElse) {
  int contacts = 0;
  forSeeds(200, [&](unsigned seed) { whatCarriesGivesNothingElse(seed, contacts); });
  EXPECT_GT(contacts, drawn(10000));
}

}  // namespace
}  // namespace hapticd
