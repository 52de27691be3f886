/** @file
 * The triangles kept about a place, against all triangles of the mesh.
 */
#include "rt/geometry/tree/vicinity.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <set>

#include "rt/geometry/triangle.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

using test::randomPoint;
using test::TestMesh;

constexpr std::uint32_t kAll = Vicinity::kMaxVisits;

double distance(const MeshView& mesh, std::uint32_t t, const Vec3& x) {
  return (nearestOnTriangle({mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)}, x).point - x).norm();
}

std::set<std::uint32_t> reached(Vicinity& vicinity, const Vec3& a, const Vec3& b, double radius, bool behind,
                                std::uint32_t* blocks = nullptr) {
  Vicinity::Reached reached;
  vicinity.reach(a, b, radius, behind ? std::numeric_limits<double>::infinity() : 0.0, reached);
  std::set<std::uint32_t> all;
  for (std::uint32_t i = 0; i < reached.count; ++i)
    EXPECT_TRUE(all.insert(reached.triangle[i]).second) << "twice: " << reached.triangle[i];
  if (blocks != nullptr) *blocks = reached.blocks;
  return all;
}

/** Certainly further than `reach` from x: most are, and need no closer look. */
bool farAway(const MeshView& mesh, std::uint32_t t, const Vec3& x, double reach) {
  const Vec3 a = mesh.vertex(t, 0), b = mesh.vertex(t, 1), c = mesh.vertex(t, 2);
  return (a - x).norm() - std::max((b - a).norm(), (c - a).norm()) > reach;
}

/** A sphere's skin, a clod of needles, and a box of large triangles, flat and tilted. */
std::vector<TestMesh> someMeshes(std::mt19937& random) {
  std::vector<TestMesh> meshes;
  meshes.push_back(test::sphereMesh(1, 40));
  meshes.push_back(test::crumpled(random, 12));
  meshes.push_back(test::boxMesh(Vec3(40, 0.7, 0.001)));
  meshes.push_back(test::boxMesh(Vec3(4000, 700, 0.001)));
  const Quat tilt(Eigen::AngleAxisd(0.7, Vec3(0.3, -0.5, 0.8).normalized()));
  for (auto& v : meshes.back().vertices) {
    const Vec3 x = tilt * Vec3(v[0], v[1], v[2]);
    for (int i = 0; i < 3; ++i) v[i] = static_cast<float>(x[i]);
  }
  return meshes;
}

TEST(Vicinity, HasAllTrianglesThatABallInItMayMeet) {
  std::mt19937 random(seedOf(1));
  std::vector<TestMesh> meshes = someMeshes(random);
  std::uniform_real_distribution<double> u(0, 1);
  int filled = 0, met = 0;
  for (TestMesh& mesh : meshes) {
    const MeshView& view = *mesh.view();
    for (int i = 0; i < 150; ++i) {
      const double radius = std::pow(10.0, -2 + 2 * u(random));
      const auto t = static_cast<std::uint32_t>(random() % view.triangle_count);
      const Vec3 center = view.vertex(t, static_cast<int>(random() % 3)) + randomPoint(random, radius);
      // A third about a place, the others about a way of up to three radii.
      const Vec3 half = i % 3 == 0 ? Vec3(Vec3::Zero()) : Vec3(randomPoint(random, 1.5 * radius));
      Vicinity vicinity;
      std::uint32_t work = 0;
      vicinity.begin(view, center - half, center + half, radius);
      if (vicinity.proceed(view, kAll, work) != Vicinity::State::kFull) continue;
      ++filled;
      const auto somewhere = [&] {
        return Vec3(vicinity.center() + (2 * u(random) - 1) * half + randomPoint(random, 0.5 * radius));
      };
      for (int j = 0; j < 10; ++j) {
        const Vec3 a = somewhere();
        const Vec3 b = j % 3 == 0 ? a : somewhere();
        const double room = std::min(vicinity.room(a), vicinity.room(b));
        if (room < 0) continue;
        const double ball = j % 4 == 0 ? 0 : u(random) * room;
        const auto taken = reached(vicinity, a, b, ball, true);
        for (std::uint32_t k = 0; k < view.triangle_count; ++k) {
          if (farAway(view, k, 0.5 * (a + b), 0.5 * (b - a).norm() + ball)) continue;
          double nearest = std::numeric_limits<double>::infinity();
          for (int s = 0; s <= 16; ++s) nearest = std::min(nearest, distance(view, k, a + s / 16.0 * (b - a)));
          if (nearest > ball) continue;
          ++met;
          ASSERT_TRUE(taken.contains(k)) << "triangle " << k << " at " << nearest << ", ball " << ball;
        }
      }
    }
  }
  EXPECT_GT(filled, 200);
  EXPECT_GT(met, 3000);  // 4486 to 7434 at 120 seeds
}

TEST(Vicinity, HasTheNeedleOnWhichThePointLies) {
  // Of a hand that creeps: a millionth as large as the needle is long, whose plane rounding tips by more than that.
  std::mt19937 random(seedOf(1));
  std::uniform_real_distribution<double> u(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 along = randomPoint(random, 0.05), from = randomPoint(random, 1e-4);
    TestMesh mesh;
    const double thin = std::pow(10.0, -9 + 3 * u(random));
    mesh.addTriangle(mesh.addVertex(from), mesh.addVertex(from + along),
                     mesh.addVertex(from + u(random) * along + randomPoint(random, 0.05 * thin)));
    const MeshView& view = *mesh.view();
    const double one = u(random), other = (1 - one) * u(random);
    const Vec3 x = view.vertex(0, 0) + one * (view.vertex(0, 1) - view.vertex(0, 0)) +
                   other * (view.vertex(0, 2) - view.vertex(0, 0));
    Vicinity vicinity;
    std::uint32_t work = 0;
    vicinity.begin(view, x, x, 0.05 * std::pow(10.0, -7 + 3 * u(random)));
    ASSERT_EQ(vicinity.proceed(view, kAll, work), Vicinity::State::kFull);
    if (!vicinity.holds(x, 0)) continue;  // The centre is one of floats.
    ASSERT_EQ(reached(vicinity, x, x, 0, true).size(), 1u) << i << ": " << thin << " wide for its length";
  }
}

TEST(Vicinity, BitByBitIsAsAtOnce) {
  TestMesh sphere = test::sphereMesh(1, 48);
  const MeshView& view = *sphere.view();
  Vicinity once, slowly;
  std::uint32_t work = 0, slow_work = 0;
  once.begin(view, Vec3(1, 0, 0), Vec3(1, 0, 0), 0.35);
  ASSERT_EQ(once.proceed(view, kAll, work), Vicinity::State::kFull);
  slowly.begin(view, Vec3(1, 0, 0), Vec3(1, 0, 0), 0.35);
  int calls = 1;
  for (; slowly.proceed(view, 1, slow_work) == Vicinity::State::kFilling; ++calls) {
    ASSERT_LT(slowly.room(Vec3(1, 0, 0)), 0) << "nothing may be asked before all is there";
    ASSERT_LT(calls, 1000);
  }
  EXPECT_EQ(slowly.state(), Vicinity::State::kFull);
  EXPECT_GT(calls, 10);
  EXPECT_EQ(slow_work, work);
  EXPECT_EQ(slowly.count(), once.count());
  const Vec3 a(1, 0.1, 0), b(0.99, 0, 0.1);
  EXPECT_EQ(reached(slowly, a, b, 0.2, true), reached(once, a, b, 0.2, true));
  EXPECT_EQ(slowly.proceed(view, kAll, slow_work), Vicinity::State::kFull) << "and stays so";
  EXPECT_EQ(slow_work, work);
}

TEST(Vicinity, HasRoomAlongItsWayAndNotBesideIt) {
  TestMesh sphere = test::sphereMesh(1, 48);
  const MeshView& view = *sphere.view();
  Vicinity vicinity;
  std::uint32_t work = 0;
  vicinity.begin(view, Vec3(1, -0.2, 0), Vec3(1, 0.2, 0), 0.1);
  ASSERT_EQ(vicinity.proceed(view, kAll, work), Vicinity::State::kFull);
  for (const double y : {-0.2, -0.1, 0.0, 0.15, 0.2}) EXPECT_NEAR(vicinity.room(Vec3(1, y, 0)), 0.1, 1e-4) << y;
  EXPECT_NEAR(vicinity.room(Vec3(1, 0.27, 0)), 0.03, 1e-4) << "round at its end";
  EXPECT_NEAR(vicinity.room(Vec3(1.06, 0.1, 0.03)), 0.1 - std::hypot(0.06, 0.03), 1e-4);
  EXPECT_TRUE(vicinity.holds(Vec3(1, 0.15, 0.05), 0.04));
  EXPECT_FALSE(vicinity.holds(Vec3(1, 0.15, 0.05), 0.06));
  EXPECT_FALSE(vicinity.holds(Vec3(1, 0.31, 0), 0));
}

TEST(Vicinity, MoreThanFitsIsNothing) {
  TestMesh sphere = test::sphereMesh(1, 48);
  const MeshView& view = *sphere.view();
  Vicinity vicinity;
  std::uint32_t work = 0;
  vicinity.begin(view, Vec3::Zero(), Vec3::Zero(), 2);
  EXPECT_EQ(vicinity.proceed(view, kAll, work), Vicinity::State::kEmpty);
  EXPECT_LE(work, kAll);
  EXPECT_EQ(vicinity.count(), 0u);
  EXPECT_LT(vicinity.room(Vec3::Zero()), 0);
  vicinity.begin(view, Vec3::Zero(), Vec3::Zero(), 0.5);  // In the air: none is there, and that is known.
  EXPECT_EQ(vicinity.proceed(view, kAll, work), Vicinity::State::kFull);
  EXPECT_EQ(vicinity.count(), 0u);
  EXPECT_GT(vicinity.room(Vec3::Zero()), 0.4);
  vicinity.begin(view, Vec3::Zero(), Vec3::Zero(), 0);
  EXPECT_EQ(vicinity.proceed(view, kAll, work), Vicinity::State::kEmpty);
}

TEST(Vicinity, AShortWayLooksAtFewOfMany) {
  TestMesh sphere = test::sphereMesh(1, 48);
  const MeshView& view = *sphere.view();
  Vicinity vicinity;
  std::uint32_t work = 0, blocks = 0;
  vicinity.begin(view, Vec3(1, 0, 0), Vec3(1, 0, 0), 0.35);
  ASSERT_EQ(vicinity.proceed(view, kAll, work), Vicinity::State::kFull);
  ASSERT_GT(vicinity.count(), 200u);
  const auto near = reached(vicinity, Vec3(1.01, 0, 0), Vec3(0.98, 0.01, 0.01), 0, false, &blocks);
  EXPECT_GE(near.size(), 1u);
  EXPECT_LE(blocks, vicinity.count() / kPrismWidth / 4);
}

}  // namespace
}  // namespace hapticd
