/** @file
 * Shapes against their closed forms, the nearest point against dense sampling.
 */
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "tests/support/process/temporary_directory.h"
#include "tests/support/seeds.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/nearest.h"
#include "tools/haptic-bench/model/shapes.h"
#include "tools/haptic-bench/model/tree_nearest.h"
#include "tools/haptic-bench/trajectory/registry.h"

namespace haptic_bench {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

double signedVolume(const Model& m) {
  double volume = 0;
  for (std::uint32_t t = 0; t < m.triangles.size(); ++t)
    volume += m.corner(t, 0).dot(m.corner(t, 1).cross(m.corner(t, 2))) / 6;
  return volume;
}

TEST(BenchShapes, SpheresOfTheThesisHaveItsTrianglesAndFillTheSphere) {
  const std::size_t triangles[] = {48, 224, 960, 3968, 16128};
  for (int i = 0; i < 5; ++i) {
    const Model m = sphere(0.05, 4 << i);
    EXPECT_EQ(m.triangles.size(), triangles[i]);
    const double full = 4.0 / 3 * EIGEN_PI * std::pow(0.05, 3);
    EXPECT_LT(signedVolume(m), full);
    EXPECT_GT(signedVolume(m), full * (1 - 5.0 / std::pow(4 << i, 2))) << "outward, and closer the finer";
  }
}

TEST(BenchShapes, RidgeStandsOnItsPlane) {
  const Model m = ridge(EIGEN_PI / 3, 0.005, 0.05);
  double volume = 0;  // Between the triangles and z = 0: a prism of 2 foot * height / 2 across and 0.1 along.
  for (std::uint32_t t = 0; t < m.triangles.size(); ++t) {
    const Vec3 a = m.corner(t, 0), b = m.corner(t, 1), c = m.corner(t, 2);
    volume += (b - a).cross(c - a).z() / 2 * (a + b + c).z() / 3;
  }
  EXPECT_NEAR(volume, 0.005 / std::sqrt(3) * 0.005 * 0.1, 1e-12);
  EXPECT_THROW((void)ridge(0.1, 0.01, 0.05), Failure);
}

TEST(BenchShapes, BowlLiesOnItsSphere) {
  const Model m = bowl(0.05, 0.01, 0.0002);
  EXPECT_EQ(m.triangles.size(), 20000u);
  for (std::uint32_t v = 0; v < m.vertices.size(); ++v) {
    ASSERT_NEAR((m.vertex(v) - Vec3(0, 0, 0.05)).norm(), 0.05, 1e-8);
  }
}

TEST(BenchModels, CornersOfAFileAreJoinedAcrossTexturesAndMaterials) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/cube.obj";
  {
    // Each face has coordinates of its own in the picture, half of them another material.
    std::ofstream file(path);
    for (int i = 0; i < 8; ++i) file << fmt::format("v {} {} {}\n", 2 * (i & 1) - 1, (i & 2) - 1, (i >> 1 & 2) - 1);
    for (int i = 0; i < 24; ++i) file << fmt::format("vt 0.{:02} 0\nvn 0 0 1\n", i);
    const int faces[][4] = {{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5}, {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}};
    for (int f = 0; f < 6; ++f) {
      file << (f % 3 == 0 ? fmt::format("usemtl m{}\nf", f) : "f");
      for (int c = 0; c < 4; ++c) file << fmt::format(" {0}/{1}/{1}", faces[f][c], 4 * f + c + 1);
      file << '\n';
    }
  }
  const Model cube = makeModel(path + ":scale=m");
  EXPECT_EQ(cube.triangles.size(), 12u);
  EXPECT_EQ(cube.vertices.size(), 8u);
  EXPECT_NEAR(signedVolume(cube), 8, 1e-6);
  const NearestPoint surface(cube);
  EXPECT_FALSE(surface.find(Vec3(1.2, 1.1, 0)).inside) << "beside an edge";
  EXPECT_FALSE(surface.find(Vec3(1.1, 1.2, 1.3)).inside) << "beside a corner";
  EXPECT_LT((surface.find(Vec3(1.2, 1.1, 0)).normal - Vec3(1, 1, 0).normalized()).norm(), 1e-9) << "of both faces";
}

TEST(BenchModels, AFileInAnotherUnitIsToldSo) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/large.obj";
  std::ofstream(path) << "v 0 0 0\nv 300 0 0\nv 0 400 0\nf 1 2 3\n";
  EXPECT_THAT(
      [&] { (void)makeModel(path); },
      ThrowsMessage<Failure>(
          path + ": the vertex 300 0 0 lies 300 m away (at most 100 m: the file's unit may be another, add :scale=mm)"))
      << "its vertices lie too far away";
  EXPECT_FLOAT_EQ(makeModel(path + ":scale=0.001").vertices[2][1], 0.4f);
  EXPECT_FLOAT_EQ(makeModel(path + ":scale=mm").vertices[2][1], 0.4f);
  EXPECT_FLOAT_EQ(makeModel(path + ":scale=inch,x=0").vertices[1][0], 7.62f);
  EXPECT_THROW((void)makeModel(path + ":scale=miles"), Failure);

  const std::string part = directory.path() + "/part.obj";  // 30 mm would be 30 m, and no trajectory touches it.
  std::ofstream(part) << "v 0 0 0\nv 30 0 0\nv 0 20 0\nf 1 2 3\n";
  EXPECT_THAT([&] { (void)makeModel(part); },
              ThrowsMessage<Failure>(part + ": it is 30 m long, if its numbers are metres (add their unit: " + part +
                                     ":scale=mm, or scale=m if they are)"));
  EXPECT_FLOAT_EQ(makeModel(part + ":scale=m").vertices[1][0], 30.f) << "who says so means it";
}

TEST(BenchModels, AreWhereTheObjectOfASessionStood) {
  const Model ball = makeModel("sphere:radius=0.05,x=0.1,y=-0.2,z=0.3,turn_y=1.5707963267948966");
  const Model at_origin = makeModel("sphere:radius=0.05");
  ASSERT_EQ(ball.vertices.size(), at_origin.vertices.size());
  for (std::uint32_t v = 0; v < ball.vertices.size(); ++v) {
    const Vec3 x = at_origin.vertex(v);  // A quarter turn about y takes z to x and x to -z.
    ASSERT_LT((ball.vertex(v) - Vec3(0.1 + x.z(), -0.2 + x.y(), 0.3 - x.x())).norm(), 1e-7);
  }
  EXPECT_THROW((void)makeTrajectory("spiral", ball, {1000}), Failure) << "its poles are elsewhere";
  EXPECT_EQ(makeTrajectory("geodesic:seconds=1", ball, {1000}).samples.size(), 1000u);

  const hapticd::test::TemporaryDirectory directory;
  const std::string path = directory.path() + "/box.obj";
  std::ofstream(path) << "v 100 0 0\nv 300 0 0\nv 100 400 50\nf 1 2 3\n";
  const Model middle = makeModel(path + ":scale=0.001,center=1,z=1");
  EXPECT_LT((middle.vertex(0) - Vec3(-0.1, -0.2, 0.975)).norm(), 1e-7)
      << "the middle of its box, as hapticctl load has it";
  EXPECT_LT((middle.vertex(2) - Vec3(-0.1, 0.2, 1.025)).norm(), 1e-7);
  EXPECT_THROW((void)makeModel("sphere:center=1"), Failure) << "it is there already";
  EXPECT_THROW((void)makeModel(path + ":scale=0.001,x=200"), Failure);
}

TEST(BenchModels, FaultsAreNamed) {
  for (const char* spec : {"cube", "sphere:stacks=2", "sphere:stacks=4.5", "sphere:corners=3", "sphere:stacks",
                           "sphere:stacks=4,stacks=5", "plane:half=nan", "none.stl"}) {
    EXPECT_THAT([&] { (void)makeModel(spec); }, ThrowsMessage<Failure>(HasSubstr("("))) << "with a remedy: " << spec;
  }
}

TEST(NearestPoint, AgreesWithDenseSampling) {
  const Model m = sphere(1, 5);
  const NearestPoint surface(m);
  std::mt19937 random(hapticd::seedOf(3));
  std::uniform_real_distribution<double> u(-1.3, 1.3);
  for (int n = 0; n < 50; ++n) {
    const Vec3 x(u(random), u(random), u(random));
    double best = 10;
    constexpr int kSteps = 60;
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) {
      for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; i + j <= kSteps; ++j) {
          const Vec3 q = (m.corner(t, 0) * i + m.corner(t, 1) * j + m.corner(t, 2) * (kSteps - i - j)) / kSteps;
          best = std::min(best, (q - x).norm());
        }
      }
    }
    const SurfacePoint found = surface.find(x);
    ASSERT_LE(found.distance, best + 1e-12);
    ASSERT_NEAR(found.distance, best, 0.02);
    ASSERT_NEAR((found.point - x).norm(), found.distance, 1e-12);
  }
}

TEST(NearestPoint, IsTheTreesToo) {
  std::mt19937 random(hapticd::seedOf(5));
  for (const Model& m : {sphere(0.05, 12), ridge(1, 0.005, 0.05), plane(0.05, 3)}) {
    const NearestPoint every(m);
    const TreeNearest tree(m);
    const auto one = [&random] { return 0.2 * (static_cast<double>(random()) / 4294967295.0) - 0.1; };
    for (int i = 0; i < 1000; ++i) {
      const Vec3 x(one(), one(), one());
      const SurfacePoint a = every.find(x), b = tree.find(x);
      ASSERT_NEAR(a.distance, b.distance, 1e-9) << m.name;
      ASSERT_LT((x - a.point).norm(), (x - b.point).norm() + 1e-9);
      ASSERT_EQ(a.inside, b.inside) << m.name << " " << x.transpose();
      ASSERT_LT((a.outward(x) - b.outward(x)).norm(), 1e-6);
    }
  }
}

TEST(NearestPoint, KnowsInsideAtFacesEdgesAndCorners) {
  // A box: inside is what the coordinates say. Many points project to edges and corners.
  Model m;
  for (int i = 0; i < 8; ++i) m.addVertex(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  const std::uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) m.addQuad(q[0], q[1], q[2], q[3]);
  const NearestPoint surface(m);
  std::mt19937 random(hapticd::seedOf(4));
  std::uniform_real_distribution<double> u(-2, 2);
  for (int n = 0; n < 3000; ++n) {
    const Vec3 x(u(random), u(random), u(random));
    const double depth = 1 - x.cwiseAbs().maxCoeff();
    const SurfacePoint found = surface.find(x);
    ASSERT_EQ(found.inside, depth > 0) << x.transpose();
    const double distance = depth > 0 ? depth : (x.cwiseAbs() - Vec3::Ones()).cwiseMax(0).norm();
    ASSERT_NEAR(found.distance, distance, 1e-12);
  }
}

TEST(NearestPoint, KnowsOutsideAboutABladesEdge) {
  // There one face's normal alone would say inside.
  const NearestPoint surface(ridge(85 * EIGEN_PI / 180, 0.005, 0.05));
  for (int degrees = -84; degrees <= 84; ++degrees) {
    const double tilt = degrees * EIGEN_PI / 180;
    const SurfacePoint found = surface.find(Vec3(0.001 * std::sin(tilt), 0.0123, 0.005 + 0.001 * std::cos(tilt)));
    ASSERT_FALSE(found.inside) << degrees;
    ASSERT_NEAR(found.distance, 0.001, 1e-6) << degrees;
  }
}

}  // namespace
}  // namespace haptic_bench
