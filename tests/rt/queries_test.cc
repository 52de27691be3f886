// Contract 1 on the queries of meshes: sweeps of points and balls, nearest points, triangles about a point, vertex
// moves.
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "rt/geometry/boxes.h"
#include "rt/geometry/nearest.h"
#include "rt/geometry/sweep.h"
#include "support/detectors.h"
#include "support/seeds.h"
#include "support/test_mesh.h"

namespace hapticd {
namespace {

/** One of each query at a random place; the number of answers. */
int askAll(MeshView& mesh, std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  const auto point = [&] { return Vec3(u(random), u(random), u(random)); };
  int answers = 0;
  for (const double radius : {0.0, 0.1}) {
    Sweep sweep;
    sweep.a = 2 * point().normalized();
    sweep.d = -sweep.a + 0.3 * point();
    sweep.radius = radius;
    sweep.limit = 50'000;
    SweepHit hit;
    answers += sweepMesh(mesh, sweep, hit) == SweepResult::kHit ? 1 : 0;
  }
  NearestQuery query;
  query.x = point();
  query.limit = 50'000;
  Nearest nearest;
  answers += nearestOnMesh(mesh, query, nearest) == NearestResult::kFound ? 1 : 0;
  const float p[3] = {mesh.vertices[7][0], mesh.vertices[7][1], mesh.vertices[7][2]};
  answers += moveVertex(mesh, 7, p) == ErrorCode::kOk ? 1 : 0;
  return answers;
}

TEST(Queries, AreCleanOnEveryVectorPath) {
  test::TestMesh sphere = test::sphereMesh(1, 20);
  MeshView& mesh = *sphere.deformableView();
  const VectorPath best = vectorPath();
  for (const VectorPath path : {VectorPath::kPortable, best}) {
    ASSERT_TRUE(choosePath(path));
    test::RtViolations seen;
    bool trapped = false;
    int answers = 0;
    std::thread([&] {
      std::mt19937 random(seedOf(1));
      for (int i = 0; i < 100; ++i) askAll(mesh, random);  // Brings in pages.
      trapped = test::trapSystemCalls();
      test::RtScope scope;
      for (int i = 0; i < 1000; ++i) answers += askAll(mesh, random);
      seen = scope.finish();
    }).join();
    EXPECT_TRUE(trapped);
    EXPECT_EQ(seen, test::RtViolations{});
    EXPECT_EQ(answers, 4 * 1000);
  }
}

}  // namespace
}  // namespace hapticd
