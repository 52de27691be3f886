/** @file
 * The proxy on triangles: seams are not felt, thin walls hold, corners have their closed form.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/random.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kOneSided;
using test::kTick;
using test::kTwoSided;
using test::TestMesh;
using test::TestScene;

TEST(ProxyOnMesh, SlidingOverATessellatedPlaneGivesOneSteadyForce) {
  // A proxy that needs a tick to catch up makes the force alternate by k v dt: 0.9 N here.
  for (const std::uint32_t n : {1u, 4u, 10u, 333u}) {
    TestMesh mesh = test::heightMesh(0.1, n, [](double, double) { return 0.0; });
    TestScene t;
    t.addMesh(mesh.view(), {}, {3000, 0, 0, 0});
    t.tick(Vec3(-0.05, 0.0123, 0.001));
    for (int i = 0; i < 300; ++i) {
      const SurfaceContact& c = t.tick(Vec3(-0.05 + 0.3 * kTick * i, 0.0123 + 0.11 * kTick * i, -0.001));
      ASSERT_LT((c.force - Vec3(0, 0, 3)).norm(), 1e-9) << n << " tick " << i;
      ASSERT_EQ(c.touch, i == 0);
    }
  }
}

/** From face to face it comes to the border of its cone by the depth below the surface, not by that of its skin too. */
TEST(ProxyOnMesh, TheConeBeyondAnEdgeIsThatOfTheDepth) {
  constexpr double kMu = 0.5, kDepth = 0.003;
  TestMesh mesh = test::heightMesh(0.1, 20, [](double, double) { return 0.0; });
  TestScene t;
  t.addMesh(mesh.view(), {}, {1000, 0, kMu, kMu});
  t.tick(Vec3(-0.05, 0.0123, 0.001));
  for (int i = 0; i < 20; ++i) {
    const Vec3 hip(-0.05 + 0.004 * i, 0.0123 + 0.001 * i, -kDepth);
    const SurfaceContact& c = t.tick(hip);
    if (i > 2) {
      ASSERT_NEAR((c.proxy - hip).head<2>().norm(), kMu * kDepth, 2e-14) << i;
    }
  }
}

TEST(ProxyOnMesh, SlidingExactlyAlongEdgesAndThroughVerticesHolds) {
  TestMesh mesh = test::heightMesh(0.1, 8, [](double, double) { return 0.0; });
  for (const Vec3& along : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(1, -1, 0)}) {
    TestScene t;
    t.addMesh(mesh.view());
    t.tick(-0.09 * along + Vec3(0, 0, 0.01));
    for (int i = 0; i <= 180; ++i) {
      const Vec3 force = t.tick((-0.09 + 0.001 * i) * along - Vec3(0, 0, 0.002)).force;
      ASSERT_LT((force - Vec3(0, 0, 2)).norm(), 1e-9) << i;
    }
  }
}

TEST(ProxyOnMesh, ThinPlateIsNotTunnelledAtAMetrePerSecond) {
  TestMesh mesh = test::boxMesh(Vec3(0.1, 0.1, 0.000025));
  for (const double mu : {0.0, 0.5}) {
    for (int start = 0; start < 50; ++start) {
      TestScene t;
      t.addMesh(mesh.view(), {}, {1000, 0, mu, mu});
      for (int i = 0; i < 40; ++i) {
        const double z = 0.01 + 0.00002 * start - 1.0 * kTick * i;
        const SurfaceContact& c = t.tick(Vec3(0.01 + 0.3 * kTick * i, 0.02, z));
        ASSERT_GE(c.proxy.z(), 0.0000249999);
        ASSERT_NEAR(c.force.z(), 1000 * std::max(0.0, double{0.000025f} - z), 1e-9);
      }
    }
  }
}

TEST(ProxyOnMesh, ClosedBoxIsNeverEscaped) {
  // From inside, by a hand that throws itself about; an inward mesh, and the same walls two-sided.
  std::mt19937 random(seedOf(7));
  std::uniform_real_distribution<double> u(-1, 1);
  for (const bool inward : {true, false}) {
    for (const double mu : {0.0, 0.7}) {
      TestMesh mesh = test::boxMesh(Vec3(0.05, 0.04, 0.03), Vec3(0.01, 0.02, 0.03), inward);
      TestScene t;
      const Pose X{Vec3(0.1, -0.2, 0.05), Quat(Eigen::AngleAxisd(0.7, Vec3(1, -2, 1).normalized()))};
      t.addMesh(mesh.view(), X, {500, 0, mu, 0.8 * mu}, inward ? kOneSided : kTwoSided);
      Vec3 hip = X * Vec3(0.01, 0.02, 0.03);
      t.tick(hip);
      for (int i = 0; i < 5000; ++i) {
        if (i % 20 == 0) hip = X * (Vec3(0.01, 0.02, 0.03) + 0.3 * Vec3(u(random), u(random), u(random)));
        hip += 0.002 * Vec3(u(random), u(random), u(random));
        const SurfaceContact& c = t.tick(hip);
        const Vec3 x = X.inverse() * c.proxy - Vec3(0.01, 0.02, 0.03);
        ASSERT_LE((x.cwiseAbs() - Vec3(0.05, 0.04, 0.03)).maxCoeff(), 1e-8) << i;
        ASSERT_LT((c.force - 500 * (c.proxy - hip)).norm(), 1e-9);
      }
    }
  }
}

TEST(ProxyOnMesh, CornersOfTwoAndThreePlanesHaveTheirClosedForm) {
  TestMesh mesh = test::boxMesh(Vec3(0.05, 0.05, 0.05), Vec3::Zero(), true);
  TestScene t;
  t.addMesh(mesh.view());
  t.tick(Vec3::Zero());
  const double wall = double{0.05f};
  std::mt19937 random(seedOf(3));
  std::uniform_real_distribution<double> u(-0.09, 0.09);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 hip(u(random), u(random), u(random));
    const Vec3 nearest = hip.cwiseMax(-wall).cwiseMin(wall);
    const SurfaceContact& c = t.tick(hip);
    ASSERT_LT((c.force - 1000 * (nearest - hip)).norm(), 1e-9) << i << " " << hip.transpose();
  }
}

TEST(ProxyOnMesh, SphereSlidesSmoothlyOverItsEdges) {
  const double radius = 0.05, depth = 0.001;
  TestMesh mesh = test::sphereMesh(radius, 64);
  TestScene t;
  t.addMesh(mesh.view());
  t.tick(Vec3(0, 0, 0.06));
  Vec3 last = Vec3::Zero();
  for (int i = 0; i < 4000; ++i) {
    const double a = 0.002 * i;
    const Vec3 n(std::sin(a) * std::cos(0.37 * a), std::sin(a) * std::sin(0.37 * a), std::cos(a));
    const SurfaceContact& c = t.tick((radius - depth) * n);
    // The middle of a quad's diagonal lies 2 R (1 - cos(pi / 2S)) below the sphere.
    const double sag = 1000 * radius * 2 * (1 - std::cos(M_PI / 128));
    ASSERT_GT(c.force.dot(n), 1000 * depth - 1.01 * sag) << i;
    ASSERT_LT(c.force.dot(n), 1000 * depth + 1e-4) << i;
    ASSERT_LT((c.force - last).norm(), i > 0 ? 0.12 : 1.2) << i;
    ASSERT_EQ(c.touch, i == 0);
    last = c.force;
  }
}

TEST(ProxyOnMesh, TwoSidedSheetHoldsFromBothSidesAndOneSidedFromItsFront) {
  TestMesh mesh = test::heightMesh(0.1, 6, [](double x, double y) { return 0.1 * x * x - 0.2 * x * y; });
  for (const bool two_sided : {true, false}) {
    for (const double side : {1.0, -1.0}) {
      TestScene t;
      t.addMesh(mesh.view(), {}, {1000, 0, 0, 0}, two_sided ? kTwoSided : kOneSided);
      t.tick(Vec3(0.01, 0.02, 0.01 * side));
      const double force = t.tick(Vec3(0.01, 0.02, -0.005 * side)).force.z() * side;
      if (two_sided || side > 0) {
        EXPECT_GT(force, 4);
      } else {
        EXPECT_EQ(force, 0);
      }
    }
  }
}

TEST(ProxyOnMesh, InsideAtTheStartNothingIsFeltUntilItHasLeft) {
  TestMesh mesh = test::boxMesh(Vec3(0.05, 0.05, 0.05));
  TestScene t;
  t.addMesh(mesh.view());
  EXPECT_EQ(t.tick(Vec3(0.01, 0, 0)).force, Vec3(Vec3::Zero()));
  EXPECT_EQ(t.tick(Vec3(0.049, 0, 0)).force, Vec3(Vec3::Zero()));
  EXPECT_EQ(t.tick(Vec3(0.06, 0, 0)).force, Vec3(Vec3::Zero()));
  EXPECT_NEAR(t.tick(Vec3(0.04, 0, 0)).force.x(), 10, 1e-5);
}

TEST(ProxyOnMesh, WorkIsBoundedAndTheProxyStaysWhenItIsUsedUp) {
  // Triangles that fill one half of their boxes, piled up; the segment passes all boxes through the other half.
  TestMesh mesh;
  for (int k = 0; k < 60000; ++k) {
    const double z = 1e-5 * k;
    const auto a = mesh.addVertex({0, 0, z}), b = mesh.addVertex({1, 0, z}), c = mesh.addVertex({0, 1, z});
    mesh.addTriangle(a, b, c);
  }
  TestScene t;
  t.addMesh(mesh.view());
  const Vec3 above(0.9, 0.9, 1);
  t.tick(above);
  const SurfaceContact& c = t.tick(Vec3(0.9, 0.9, -1));
  EXPECT_GT(c.work, ProxyRenderer::kMaxWork);
  EXPECT_LE(c.work, ProxyRenderer::kMaxWork + HD_BVH_LEAF_TRIANGLES);
  EXPECT_EQ(c.proxy, above);
  EXPECT_EQ(c.force, Vec3(Vec3::Zero()));
  EXPECT_EQ(t.tick(Vec3(0.9, 0.9, 0.99)).proxy, Vec3(0.9, 0.9, 0.99)) << "goes on when the way is short again";
}

constexpr std::uint32_t kLongestWalk = 32;  // From face to face.

/** Also by walks that end in no plan. */
TEST(ProxyOnMesh, FacesFollowedInATickAreFew) {
  TestMesh mesh = test::sphereMesh(0.03, 120);
  MeshView* const view = mesh.view();
  std::uint32_t most = 0;
  for (const bool ball : {false, true}) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      Random random(seed);
      TestScene t(ball ? random.in(1e-4, 3e-3) : 0);
      t.addMesh(view);
      Vec3 hip(0, 0, 0.06), aim = hip;
      for (int i = 0; i < 500; ++i) {
        if (i % 15 == 0) aim = random.vector(0.04);
        hip += std::pow(10.0, random.in(-2, -0.3)) * (aim - hip);
        t.tick(hip);
        most = std::max(most, t.proxy.effort().walked);
      }
    }
  }
  EXPECT_LT(most, ProxyRenderer::kMaxWalked + kLongestWalk);
  EXPECT_GE(most, ProxyRenderer::kMaxWalked) << "no hand was thrown so that it matters";
}

/** The faces send this hand on to each other, round and round. */
TEST(ProxyOnMesh, AWalkInACircleEndsAndCountsAsWork) {
  TestMesh mesh;
  const auto a = mesh.addVertex({-0.008, -0.01, -0.013}), b = mesh.addVertex({0.024, -0.011, -0.007});
  const auto c = mesh.addVertex({0.028, 0.017, 0.028}), d = mesh.addVertex({0.008, -0.01, -0.025});
  mesh.addTriangle(a, b, c);
  mesh.addTriangle(a, c, d);
  mesh.addTriangle(a, d, b);
  mesh.addTriangle(b, d, c);
  TestScene t;
  t.addMesh(mesh.view(), {}, {1000, 0, 0, 0});
  t.tick(Vec3(0.032, 0.024, 0.011));
  t.tick(Vec3(-0.029, -0.029, -0.02));
  const ProxyEffort& effort = t.proxy.effort();
  EXPECT_EQ(effort.walked, kLongestWalk);
  EXPECT_GE(effort.visited, effort.walked);
  EXPECT_LT(effort.visited, 2 * effort.walked) << "so much else was visited that the walk would not show";
}

}  // namespace
}  // namespace hapticd
