/** @file
 * Solids that overlap as they like: in one mesh, a mesh that passes through itself, one that stands there twice, and a
 * hundred objects on one heap.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kSolidSize = 0.03;  // Of a solid, at most [m].
constexpr double kCrowdStiffness = 1000;

struct Crowd {
  TestScene t;
  std::vector<TestMesh> meshes;
  std::vector<std::uint32_t> ids;
  double mu = 0;

  explicit Crowd(Random& random) : mu(random.once(2) ? random.in(0, 1.5) : 0) { meshes.reserve(128); }
  void add(ShapeKind kind, const Vec3& size, const Pose& X) { ids.push_back(t.add(kind, size, X, material())); }
  void add(TestMesh mesh, const Pose& X) {
    meshes.push_back(std::move(mesh));
    ids.push_back(t.addMesh(meshes.back().view(), X, material()));
  }
  [[nodiscard]] hd_material material() const { return {kCrowdStiffness, 0, mu, 0.7 * mu}; }

  /** By more than rounding. */
  [[nodiscard]] bool isInside(const SceneObject& o, const Vec3& x_W) const {
    const Vec3 x = o.X_WO.inverse() * x_W;
    if (o.shape.kind != ShapeKind::kMesh) return test::distanceTo(o.shape, x) < -1e-9;
    return test::windingNumber(*o.shape.mesh, x) > 0.5 && test::distanceTo(*o.shape.mesh, x) > 1e-9;
  }

  /** A hand goes for one aim after the other, and through everything. */
  void stroke(Random& random, int ticks, int& contacts) {
    t.tick(Vec3(0, 0, 0.5));
    Vec3 hand = Vec3::Zero(), aim = hand;
    double speed = 0.01;
    for (int i = 0; i < ticks; ++i) {
      if (random.once(20)) aim = random.vector(0.05);
      if (random.once(30)) speed = std::pow(10, random.in(-3, 0));
      hand += speed * (aim - hand);
      const SurfaceContact& c = t.tick(hand);
      contacts += c.object != 0;
      ASSERT_LE(c.force.norm(), kCrowdStiffness * (c.proxy - hand).norm() * (1 + 1e-9)) << "tick " << i;
      ASSERT_LT(c.work, 20000u) << "tick " << i;
      for (const std::uint32_t id : ids) ASSERT_FALSE(isInside(*t.scene->find(id), c.proxy)) << "tick " << i;
    }
  }
};

TestMesh bumpyBall(Random& random, double radius) {
  TestMesh mesh = test::sphereMesh(radius, 4 + random.below(6u));
  mesh.scale([&] { return random.in(0.7, 1.1); });
  return mesh;
}

Vec3 anySize(Random& random, double most) {
  return {random.in(0.001, most), random.in(0.001, most), random.in(0.0005, most)};
}

void append(TestMesh& mesh, const TestMesh& other, const Pose& X) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const auto& v : other.vertices) mesh.addVertex(X * Vec3(v[0], v[1], v[2]));
  for (const auto& t : other.triangles) mesh.addTriangle(base + t[0], base + t[1], base + t[2]);
}

TEST(CrowdProperty, SolidsThatOverlapInOneMeshLetNobodyIn) {
  int contacts = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    Crowd crowd(random);
    crowd.t.proxy.setRadius(random.once(2) ? 0 : std::exp(random.in(std::log(1e-5), std::log(5e-3))));
    TestMesh mesh;
    for (int i = 2 + random.below(4); i > 0; --i) {
      const Pose X = random.pose(0.02);
      append(
          mesh,
          random.once(2) ? test::boxMesh(anySize(random, kSolidSize)) : bumpyBall(random, random.in(0.01, kSolidSize)),
          X);
    }
    crowd.add(mesh, random.pose(0.01));
    crowd.stroke(random, 200, contacts);
  });
  EXPECT_GT(contacts, drawn(2000));
}
/** A point; a ball may come in at vertices about which faces look every way. */
TEST(CrowdProperty, AMeshThatPassesThroughItselfLetsNoPointIn) {
  int contacts = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    Crowd crowd(random);
    TestMesh mesh = test::sphereMesh(kSolidSize, 3 + random.below(8u));
    const double far = kSolidSize * std::pow(10, random.in(-1, 0));
    for (auto& v : mesh.vertices) {
      const bool thrown = random.once(3);
      for (float& x : v) x += thrown ? static_cast<float>(random.in(-far, far)) : 0;
    }
    crowd.add(mesh, random.pose(0.01));
    crowd.stroke(random, 200, contacts);
  });
  EXPECT_GT(contacts, drawn(2000));
}
/** As a box and the mesh of its looks do: what the one lets go around lets the other, a hair apart. */
TEST(CrowdProperty, ASolidThatStandsThereTwiceIsFeltAsOne) {
  int contacts = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    const Vec3 half = Vec3(random.in(0.005, 0.03), random.in(0.005, 0.03), random.in(0.005, 0.03));
    const bool ball = random.once(2), mesh_first = random.once(2);
    const double mu = ball || random.once(2) ? 0 : random.in(0.2, 1);
    const hd_material material{kCrowdStiffness, 0, mu, 0.8 * mu};
    const Pose X = random.pose(0.02);
    TestMesh looks = test::boxMesh(half);
    MeshView* view = looks.view();
    TestScene one(ball ? random.in(5e-4, 4e-3) : 0), two(one.proxy.radius());
    one.add(ShapeKind::kBox, half, X, material);
    if (mesh_first) two.addMesh(view, X, material);
    two.add(ShapeKind::kBox, half, X, material);
    if (!mesh_first) two.addMesh(view, X, material);
    Vec3 hand = X.p + Vec3(0, 0, 0.2), way = Vec3::Zero();
    for (int i = 0; i < 1000; ++i) {
      if (i % 100 == 0) way = (X.p + random.in(0.5, 1.3) * half.norm() * random.vector(1).normalized() - hand) / 100;
      hand += way;
      const Vec3 force = one.tick(hand).force;
      ASSERT_NEAR((two.tick(hand).force - force).norm(), 0, 1e-3 * (1 + force.norm())) << "tick " << i;
      contacts += one.contact.object != 0;
    }
  });
  EXPECT_GT(contacts, drawn(5000));
}

/** As files hold it that were merged with themselves: neither thrown, nor held from between the two. */
TEST(CrowdProperty, AMeshWhoseSurfaceIsThereTwiceIsFeltAsOne) {
  int contacts = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    const bool is_box = random.once(2);
    TestMesh mesh =
        is_box ? test::boxMesh(anySize(random, kSolidSize)) : bumpyBall(random, random.in(0.01, kSolidSize));
    TestMesh doubled = mesh;
    append(doubled, mesh, {});
    const double mu = random.once(2) ? 0 : random.in(0.2, 1);
    const hd_material material{kCrowdStiffness, 0, mu, 0.8 * mu};
    const Pose X = random.pose(0.02);
    TestScene one(random.once(2) ? random.in(1e-4, 2e-3) : 0), two(one.proxy.radius());
    one.addMesh(mesh.view(), X, material);
    two.addMesh(doubled.view(), X, material);
    Vec3 hand = X.p + Vec3(0, 0, 0.2), way = Vec3::Zero();
    for (int i = 0; i < 1000; ++i) {
      if (i % 50 == 0) way = (X.p + random.vector(kSolidSize) - hand) / 50;
      hand += way;
      const Vec3 force = one.tick(hand).force;
      ASSERT_NEAR((two.tick(hand).force - force).norm(), 0, 1e-6 * (1 + force.norm())) << "tick " << i;
      contacts += one.contact.object != 0;
    }
  });
  EXPECT_GT(contacts, 5000);
}

TEST(CrowdProperty, AHundredObjectsOnOneHeapLetNobodyIn) {
  int contacts = 0;
  forSeeds(15, [&](unsigned seed) {
    Random random(seed);
    Crowd crowd(random);
    crowd.t.proxy.setRadius(random.once(2) ? 0 : std::exp(random.in(std::log(1e-5), std::log(5e-3))));
    for (int i = 0; i < 100; ++i) {
      const Pose X = random.pose(0.04);
      const Vec3 size = anySize(random, 0.02);
      const int kind = random.below(6);
      if (kind < 4) {
        constexpr ShapeKind kKinds[] = {ShapeKind::kSphere, ShapeKind::kBox, ShapeKind::kCapsule, ShapeKind::kCylinder};
        crowd.add(kKinds[kind], size, X);
      } else {
        crowd.add(kind == 4 ? test::boxMesh(size) : bumpyBall(random, size.x()), X);
      }
    }
    crowd.stroke(random, 150, contacts);
  });
  EXPECT_GT(contacts, 500);
}

}  // namespace
}  // namespace hapticd
