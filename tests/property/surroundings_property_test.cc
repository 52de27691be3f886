/** @file
 * What is kept of the triangles about a proxy changes no bit of what is felt: two renderers on the same way, one of
 * them without.
 */
#include <gtest/gtest.h>

#include <random>

#include "rt/geometry/tree/boxes.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;
using test::TestScene;

constexpr double kMeshSize = 0.03;  // [m]

/** A closed ball with bumps, a sheet with waves that can move, a needle-ridden clod, and a box as the plainest mesh. */
std::vector<TestMesh> someMeshes(Random& random, unsigned seed) {
  std::vector<TestMesh> meshes;
  meshes.push_back(test::sphereMesh(kMeshSize, 16 + random.below(24)));
  meshes[0].scale([&] { return random.in(0.97, 1.03); });
  const double wave = random.in(100, 600), high = random.in(0, 0.002);
  meshes.push_back(test::heightMesh(
      2 * kMeshSize, 30, [&](double x, double y) { return high * std::sin(wave * x) * std::sin(wave * y); }));
  std::mt19937 engine(seed);
  meshes.push_back(test::crumpled(engine, 8));
  meshes[2].scale([] { return kMeshSize; });
  meshes.push_back(test::boxMesh(Vec3(kMeshSize, 0.5 * kMeshSize, 0.00003)));
  return meshes;
}

struct MovingMeshes {
  TestScene t;
  std::vector<TestMesh> meshes;
  std::vector<MeshView*> views;
  std::vector<std::uint32_t> ids;

  MovingMeshes(Random& random, unsigned seed) : meshes(someMeshes(random, seed)) {
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      views.push_back(i == 1 ? meshes[i].deformableView() : meshes[i].view());
      const double mu = random.once(2) ? random.in(0, 0.8) : 0;
      const bool two_sided = i == 1 && random.once(2);
      const Pose X{Vec3(2.2 * kMeshSize * (i % 2), 2.2 * kMeshSize * (i / 2), 0) + random.vector(0.1 * kMeshSize),
                   Quat(Eigen::AngleAxisd(random.in(0, 3), random.vector(1).normalized()))};
      ids.push_back(t.addMesh(views[i], X, {random.in(100, 2000), 0, mu, 0.7 * mu},
                              HD_OBJECT_ENABLED | (two_sided ? 0u + HD_OBJECT_TWO_SIDED : 0u)));
    }
  }

  /** Something happens to the scene, mostly to what is touched. */
  void disturb(Random& random) {
    auto which = static_cast<std::size_t>(random.below(static_cast<int>(ids.size())));
    for (std::size_t i = 0; i < ids.size() && !random.once(4); ++i) which = ids[i] == t.contact.object ? i : which;
    const Pose X = t.scene->find(ids[which])->X_WO;
    switch (random.below(4)) {
      case 0:  // Moves on, or stops.
        t.pose(ids[which], X, random.once(2) ? Twist{} : Twist{random.vector(0.1), random.vector(2)});
        break;
      case 1:  // Is somewhere else.
        t.pose(ids[which], {X.p + random.vector(kMeshSize), X.q});
        break;
      case 2: {  // Waves about the hand.
        const Vec3 at = t.scene->find(ids[1])->X_WO.inverse() * t.contact.proxy;
        std::vector<hd_vertex_move> moves;
        for (std::uint32_t i = 0; i < views[1]->vertex_count; ++i) {
          const float* v = views[1]->vertices[i];
          if ((Vec3(v[0], v[1], v[2]) - at).norm() > 0.006) continue;
          moves.push_back({i, {v[0], v[1], v[2] + static_cast<float>(random.in(-0.0005, 0.0005))}});
        }
        t.moveVertices(ids[1], moves);
        break;
      }
      default: {  // Takes the shape of another, or its own again.
        const auto entry = 1 + static_cast<std::uint32_t>(random.below(4));
        EXPECT_EQ(t.setShape(ids[which], {static_cast<std::uint32_t>(ShapeKind::kMesh), entry, {}}), ErrorCode::kOk);
      }
    }
  }
};

/** A hand that strokes the meshes, rests, hurries, leaps, and now and then is deep inside. */
class StrokingHand {
 public:
  explicit StrokingHand(Random& random) : random_(random) {}
  const Vec3& next() {
    if (random_.once(40)) aim_ = Vec3(random_.in(-1.2, 3.4), random_.in(-1.2, 3.4), random_.in(-1.2, 1.2)) * kMeshSize;
    if (random_.once(30)) step_ = random_.once(4) ? 0 : std::pow(10.0, random_.in(-6, -2.5));
    if (random_.once(300)) p_ = aim_;
    const Vec3 way = aim_ - p_;
    p_ += std::min(1.0, step_ / std::max(way.norm(), 1e-12)) * way;
    return p_;
  }

 private:
  Random& random_;
  Vec3 p_ = Vec3(0, 0, 3 * kMeshSize), aim_ = Vec3::Zero();
  double step_ = 1e-4;
};

void expectSameContact(const SurfaceContact& a, const SurfaceContact& b) {
  ASSERT_EQ(a.force, b.force);
  ASSERT_EQ(a.proxy, b.proxy);
  ASSERT_EQ(a.point, b.point);
  ASSERT_EQ(a.normal, b.normal);
  ASSERT_EQ(a.depth, b.depth);
  ASSERT_EQ(a.object, b.object);
  ASSERT_EQ(a.slip, b.slip);
  ASSERT_EQ(a.touch, b.touch);
}

void keptOrNotIsFeltAlike(unsigned seed, int& contacts) {
  Random random(seed);
  MovingMeshes w(random, seed);
  StrokingHand hand(random);
  ProxyRenderer plain;
  plain.keepSurroundings(false);
  for (int i = 0; i < 1500; ++i) {
    if (random.once(12)) w.disturb(random);
    if (i % 500 == 0) {
      const double radius = random.once(2) ? 0 : std::pow(10.0, random.in(-4, -2.3));
      w.t.proxy.setRadius(radius);
      plain.setRadius(radius);
    }
    const Vec3 hip = hand.next(), v = random.vector(0.1);
    const SurfaceContact& kept = w.t.tick(hip, v);
    SurfaceContact contact;
    plain.step(*w.t.scene, hip, v, kTick, contact);
    SCOPED_TRACE(i);
    ASSERT_NO_FATAL_FAILURE(expectSameContact(kept, contact));
    contacts += contact.object != 0;
  }
}

void keptOrNotIsFeltAlikeOn(VectorPath path) {
  const VectorPath before = vectorPath();
  if (!choosePath(path)) GTEST_SKIP() << "no " << nameOf(path) << " here";
  int contacts = 0;
  for (const unsigned seed : seeds(40)) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    keptOrNotIsFeltAlike(seed, contacts);
    if (::testing::Test::HasFailure()) break;
  }
  choosePath(before);
  EXPECT_GT(contacts, 1000);
}

TEST(SurroundingsProperty, KeptOrNotIsFeltAlikeToTheBit) { keptOrNotIsFeltAlikeOn(vectorPath()); }
TEST(SurroundingsProperty, KeptOrNotIsFeltAlikeToTheBitOnThePortablePath) {
  keptOrNotIsFeltAlikeOn(VectorPath::kPortable);
}

TEST(SurroundingsProperty, WhatIsTriedFirstChangesNothing) {
  // On a plane of many triangles, by segments and balls that meet several of them at the same time.
  Random random(seedOf(1));
  TestMesh mesh = test::heightMesh(1, 8, [](double, double) { return 0.0; });
  const MeshView& view = *mesh.view();
  int ties = 0;
  for (int i = 0; i < 20000; ++i) {
    Sweep sweep;
    sweep.a = Vec3(0.25 * random.below(8) - 1, 0.25 * random.below(8) - 1, random.once(2) ? 0.5 : 0.51);
    sweep.d = Vec3(0.125 * random.below(3), 0.125 * random.below(3), -1);
    sweep.radius = 0.0625 * random.below(3);
    sweep.limit = 1u << 20;
    SweepHit hit, hinted;
    const SweepResult result = sweepMesh(view, sweep, hit);
    sweep.hint = static_cast<std::uint32_t>(random.below(static_cast<int>(view.triangle_count)));
    if (random.once(2)) sweep.above = Vec3(0, 0, 1);
    ASSERT_EQ(sweepMesh(view, sweep, hinted), result);
    ASSERT_EQ(hit.t, hinted.t);
    ASSERT_EQ(hit.feature, hinted.feature) << sweep.hint;
    ASSERT_EQ(hit.normal, hinted.normal);
    SweepHit alone;
    sweep.limit = 0;  // The hint is tried, and then no more.
    ties += sweep.hint != hit.feature && sweepMesh(view, sweep, alone) == SweepResult::kExhausted && alone.t == hit.t;
  }
  EXPECT_GT(ties, 50);
}

TEST(SurroundingsProperty, WhatLiesBelowTheWayIsNotMet) {
  // Segments and balls that graze a bumpy sheet, seen along all kinds of directions.
  Random random(seedOf(2));
  TestMesh mesh = test::heightMesh(1, 12, [](double x, double y) { return 0.1 * std::sin(5 * x) * std::cos(4 * y); });
  const MeshView& view = *mesh.view();
  int hits = 0, misses = 0;
  for (int i = 0; i < 20000; ++i) {
    Sweep sweep;
    sweep.radius = random.once(2) ? 0 : random.in(0.01, 0.5);
    sweep.tolerance = 1e-14;
    sweep.two_sided = random.once(4);
    sweep.a = Vec3(random.in(-0.8, 0.8), random.in(-0.8, 0.8), sweep.radius + random.in(-0.05, 0.12));
    sweep.d = random.vector(0.2);
    sweep.limit = 1u << 20;
    SweepHit hit, other;
    const SweepResult result = sweepMesh(view, sweep, hit);
    const auto t = static_cast<std::uint32_t>(random.below(static_cast<int>(view.triangle_count)));
    sweep.above =
        random.once(2)
            ? random.vector(1).normalized()
            : Vec3((view.vertex(t, 1) - view.vertex(t, 0)).cross(view.vertex(t, 2) - view.vertex(t, 0)).normalized());
    ASSERT_EQ(sweepMesh(view, sweep, other), result) << i;
    ASSERT_EQ(hit.t, other.t) << i;
    ASSERT_EQ(hit.normal, other.normal) << i;
    ASSERT_EQ(hit.feature, other.feature) << i;
    ++(result == SweepResult::kHit ? hits : misses);
  }
  EXPECT_GT(hits, 2000);
  EXPECT_GT(misses, 2000);
}

TEST(SurroundingsProperty, AStrokeSeldomLooksIntoTheTree) {
  TestMesh mesh = test::sphereMesh(kMeshSize, 64);
  for (const double radius : {0.0, 0.001}) {
    TestScene t;
    t.addMesh(mesh.view(), {}, {1000, 0, 0, 0});
    ProxyRenderer plain;
    plain.keepSurroundings(false);
    for (ProxyRenderer* proxy : {&t.proxy, &plain}) {
      proxy->setRadius(radius);
      proxy->reset(Vec3(0, 0, 2 * kMeshSize));
    }
    std::uint64_t looked = 0, looked_plain = 0;
    constexpr int kTicks = 1000;
    for (int i = 0; i < kTicks; ++i) {
      const double a = 0.5 + 0.003 * i;
      const Vec3 hip =
          (kMeshSize + radius - 0.001) * Vec3(std::cos(0.1 * a) * std::sin(a), std::sin(0.1 * a), std::cos(a));
      SurfaceContact contact;
      looked += t.tick(hip).work;
      plain.step(*t.scene, hip, Vec3::Zero(), kTick, contact);
      looked_plain += contact.work;
    }
    EXPECT_LT(2 * looked, looked_plain) << radius;
  }
}

/** Over fine ground, also if it was fast before. */
TEST(SurroundingsProperty, ASlowHandSeldomGathers) {
  TestMesh mesh = test::heightMesh(0.02, 150, [](double x, double y) { return 1e-4 * std::sin(900 * (x + y)); });
  for (const double radius : {0.0, 0.001}) {
    TestScene t;
    t.addMesh(mesh.view(), {}, {1000, 0, 0, 0});
    ProxyRenderer fresh;
    for (ProxyRenderer* proxy : {&t.proxy, &fresh}) {
      proxy->setRadius(radius);
      proxy->reset(Vec3(0.01, 0, 0.01));
    }
    const auto at = [&](double angle) { return Vec3(0.01 * std::cos(angle), 0.01 * std::sin(angle), radius - 0.001); };
    for (int i = 0; i < 3000; ++i) t.tick(at(0.02 * i));  // 0.2 m/s.
    SurfaceContact contact;
    fresh.step(*t.scene, at(60), Vec3::Zero(), kTick, contact);
    std::uint64_t gathered = 0, gathered_fresh = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec3 hip = at(60 + 0.0002 * i);  // 2 mm, in a second.
      t.tick(hip);
      gathered += t.proxy.effort().gathered;
      fresh.step(*t.scene, hip, Vec3::Zero(), kTick, contact);
      gathered_fresh += fresh.effort().gathered;
      ASSERT_NE(contact.object, 0u) << i;
    }
    // About 150 triangles lie about the hand; without a least margin they are gathered 20 to 30 times.
    EXPECT_LT(gathered, 1200u) << radius;
    EXPECT_LT(gathered_fresh, 1200u) << radius;
  }
}

}  // namespace
}  // namespace hapticd
