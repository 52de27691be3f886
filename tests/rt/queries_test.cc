// Contract 1 on the queries of meshes: sweeps of points and balls, nearest points, triangles about a point, vertex
// moves.
#include <gtest/gtest.h>

#include <random>

#include "rt/geometry/nearest/nearest.h"
#include "rt/geometry/sweep/sweep.h"
#include "rt/geometry/tree/boxes.h"
#include "tests/support/detectors.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/test_mesh.h"

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
    int answers = 0;
    std::mt19937 random(seedOf(1));
    const auto ask = [&](int times) {
      for (int i = 0; i < times; ++i) answers += askAll(mesh, random);
    };
    test::expectClean([&] { ask(100); }, [&] { answers = 0, ask(1000); });
    EXPECT_EQ(answers, 4 * 1000);
  }
}

}  // namespace
}  // namespace hapticd
