/** @file
 * The two-state friction cone (thesis section 2.2.1) and the energy of contact.
 */
#include <gtest/gtest.h>

#include <random>

#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;
using test::TestScene;

constexpr double kGripStiffness = 1000;

/** The bottom of a hollow sphere in edges of 0.2 mm. */
TestMesh bowlMesh(double radius) {
  return test::heightMesh(0.03, 300,
                          [&](double x, double y) { return radius - std::sqrt(radius * radius - x * x - y * y); });
}

TEST(ProxyFriction, BreaksAwayAtTheStaticConeOnAMeshWhateverTheDepth) {
  TestMesh mesh = test::heightMesh(0.05, 40, [](double, double) { return 0.0; });
  for (const double depth : {1e-5, 3e-4, 3e-3}) {
    for (const double heading : {0.0, 1.0, 2.5, 4.0}) {
      TestScene t;
      t.addMesh(mesh.view(), {}, {kGripStiffness, 0, 0.6, 0.4});
      const Vec3 along(std::cos(heading), std::sin(heading), 0), from(0.0011, 0.0007, 0);
      t.tick(from + Vec3(0, 0, 0.001));
      double held = 0;
      for (int i = 0; i <= 400; ++i) {
        const double r = 5e-3 * depth * i;
        const SurfaceContact& c = t.tick(from + r * along - Vec3(0, 0, depth));
        const double ratio = -c.force.dot(along) / c.force.z();
        if (!c.slip) held = std::max(held, ratio);
        ASSERT_NEAR(ratio, r / depth < 0.6 * (1 + 1e-7) ? r / depth : 0.4, 1e-6) << depth << " " << i;
      }
      EXPECT_NEAR(held, 0.6, 1e-6) << depth;
    }
  }
}

TEST(ProxyFriction, SteadySlidingOnASphereKeepsTheDynamicCone) {
  // On a curved surface a proxy that stops wherever it happens to be inside the cone sticks and slips in turn.
  for (const double depth : {1e-4, 2e-3}) {
    TestScene t;
    t.add(ShapeKind::kSphere, Vec3(0.05, 0, 0), {}, {kGripStiffness, 0, 0.8, 0.4});
    t.tick(Vec3(0, 0, 0.06));
    for (int i = 0; i < 1500; ++i) {
      const double a = 0.1 * kTick * i / 0.05;
      const SurfaceContact& c = t.tick((0.05 - depth) * Vec3(std::sin(a), 0, std::cos(a)));
      const Vec3 n = c.proxy.normalized();
      const double normal = c.force.dot(n), tangential = (c.force - normal * n).norm();
      if (i < 200) continue;
      ASSERT_TRUE(c.slip) << i;
      ASSERT_NEAR(tangential / normal, 0.4, 0.02) << depth << " " << i;
      ASSERT_LT(c.force.x() * std::cos(a) - c.force.z() * std::sin(a), 0) << "against the motion";
    }
  }
}

TEST(ProxyFriction, SteadySlidingInABowlKeepsTheDynamicCone) {
  // Here the normal turns so that a proxy set on the border of the cone finds itself inside it a facet later.
  const double radius = 0.05;
  TestMesh mesh = bowlMesh(radius);
  MeshView* view = mesh.view();
  for (const double depth : {1e-4, 2e-3}) {
    TestScene t;
    t.addMesh(view, {}, {kGripStiffness, 0, 0.8, 0.4});
    t.tick(Vec3(0, 0, 0.01));
    int slips = 0;
    for (int i = 0; i < 400; ++i) {
      const double a = -0.4 + 0.1 * kTick * i / radius, b = 0.0137;
      const Vec3 u(std::sin(a) * std::cos(b), std::sin(b), -std::cos(a) * std::cos(b));
      const SurfaceContact& c = t.tick(Vec3(0, 0, radius) + (radius + depth) * u);
      if (i < 50) continue;
      const double normal = c.force.dot(c.normal), tangential = (c.force - normal * c.normal).norm();
      slips += c.slip;
      ASSERT_NEAR(tangential / normal, 0.4, 0.05) << depth << " " << i;
    }
    EXPECT_GT(slips, 340) << depth;
  }
}

/** A slow hand too, which moves less in a tick than the turning normal takes the proxy into the cone. */
TEST(ProxyFriction, ASlowHandKeepsSlidingInAGroove) {
  constexpr double kRadius = 0.01, kDepth = 2e-3;
  TestMesh mesh =
      test::heightMesh(0.008, 120, [](double x, double) { return kRadius - std::sqrt(kRadius * kRadius - x * x); });
  MeshView* const view = mesh.view();
  for (const double radius : {0.0, 1e-3}) {
    TestScene t(radius);
    t.addMesh(view, {}, {kGripStiffness, 0, 0.6, 0.3});
    t.tick(Vec3(-0.003, 0, 0.005));
    int slips = 0;
    for (int i = 0; i < 2500; ++i) {
      const double a = -0.4 + 2e-6 * i / (kRadius - radius), y = 1e-6 * i;
      const double out = kRadius - radius + kDepth;
      const SurfaceContact& c = t.tick(Vec3(out * std::sin(a), y, kRadius - out * std::cos(a)));
      const double normal = c.force.dot(c.normal), tangential = (c.force - normal * c.normal).norm();
      if (slips > 0) {
        ASSERT_TRUE(c.slip) << i << " " << tangential / normal;
      }
      slips += c.slip;
      if (c.slip) {
        ASSERT_NEAR(tangential / normal, 0.3, 0.03) << i;
      }
    }
    EXPECT_GT(slips, 1500) << radius;
  }
}

/** Encoders step on one axis after the other: of a hand that goes on some readings fall back. */
TEST(ProxyFriction, AHandReadInStepsKeepsSliding) {
  constexpr double kStep = 3e-5, kRadius = 0.02;
  const auto read = [=](const Vec3& x) { return Vec3(kStep * (x.array() / kStep).round()); };
  for (const bool curved : {false, true}) {
    for (const double depth : {3e-4, 2e-3}) {
      for (const double heading : {0.0, 0.7, 2.5}) {
        TestScene t;
        const Quat turn(Eigen::AngleAxisd(0.6, Vec3(1, 2, 0.5).normalized()));
        t.add(curved ? ShapeKind::kSphere : ShapeKind::kPlane, Vec3(curved ? kRadius : 0, 0, 0), {Vec3::Zero(), turn},
              {kGripStiffness, 0, 0.6, 0.3});
        t.proxy.setResolution(kStep);
        const Vec3 up = turn * Vec3::UnitZ(), along = turn * Vec3(std::cos(heading), std::sin(heading), 0);
        const auto hip = [&](double way) {
          const double a = way / kRadius;
          return curved ? Vec3((kRadius - depth) * (std::cos(a) * up + std::sin(a) * along))
                        : Vec3(way * along - depth * up);
        };
        t.tick(0.03 * up);
        int slips = 0;
        for (int i = 0; i < 2000; ++i) {
          const SurfaceContact& c = t.tick(read(hip(5e-6 * i)));
          if (slips > 0) {
            ASSERT_TRUE(c.slip) << i << " " << depth << " " << heading << " " << curved;
          }
          slips += c.slip;
        }
        EXPECT_GT(slips, 1000) << depth;
        t.tick(read(hip(5e-6 * 1999 - 0.3 * depth)));
        EXPECT_FALSE(t.contact.slip) << "come back";
      }
    }
  }
}

TEST(ProxyFriction, NormalAndDepthAreTheSurfacesNotTheForces) {
  const Quat turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()));
  const Vec3 p(0.11, -0.07, 0.03), n = turn * Vec3::UnitZ(), along = turn * Vec3::UnitX();
  TestScene t;
  t.add(ShapeKind::kPlane, Vec3::Zero(), {p, turn}, {kGripStiffness, 0, 0.6, 0.4});
  t.tick(p + 0.01 * n);
  for (int i = 0; i < 200; ++i) {
    const SurfaceContact& c = t.tick(p - 0.002 * n + 1e-5 * i * along);
    ASSERT_LT((c.normal - n).norm(), 1e-12) << i;
    ASSERT_NEAR(c.depth, 0.002, 1e-15) << i;
  }
}

/** However the steps toward the cone come to their end: a tick's last looks bring a proxy on a curve no nearer. */
TEST(ProxyFriction, NormalAndDepthOnCurvesAreTheSurfacesToo) {
  constexpr double kSize = 0.02;
  for (const ShapeKind kind : {ShapeKind::kSphere, ShapeKind::kCylinder}) {
    for (const double radius : {0.0, 1e-3}) {
      for (const double depth : {1e-4, 1e-3}) {
        TestScene t(radius);
        t.add(kind, Vec3(kSize, 0.05, 0), {}, {kGripStiffness, 0, 0.4, 0.3});
        t.tick(Vec3(2 * kSize, 0, 0));
        int slips = 0;
        for (int i = 0; i < 500; ++i) {
          const double a = 2e-3 * i;
          const Vec3 hip = (kSize + radius - depth) * Vec3(std::cos(a), std::sin(a), 0);
          const SurfaceContact& c = t.tick(hip);
          slips += c.slip;
          ASSERT_LT((c.normal - c.proxy.normalized()).norm(), 1e-3) << i << " " << depth << " " << radius;
          ASSERT_NEAR(c.depth, (c.proxy - hip).dot(c.normal), 1e-6 * depth) << i;
        }
        EXPECT_GT(slips, 100) << depth;
      }
    }
  }
}

/** A slow hand too: a proxy that sticks on a curve is farther from the hand than its cone is wide. */
TEST(ProxyFriction, ASlowHandBreaksAwayOnCurves) {
  constexpr double kRadius = 0.02;
  TestMesh coarse = test::sphereMesh(kRadius, 20), fine = test::sphereMesh(kRadius, 150);
  MeshView* const views[] = {nullptr, coarse.view(), fine.view()};
  for (MeshView* const mesh : views) {
    for (const double radius : {0.0, 1e-3}) {
      for (const double depth : {1e-3, 3e-3}) {
        TestScene t(radius);
        t.add(mesh != nullptr ? ShapeKind::kMesh : ShapeKind::kSphere, Vec3(kRadius, 0, 0), {},
              {kGripStiffness, 0, 0.4, 0.2}, HD_OBJECT_ENABLED, 0, mesh);
        t.tick(Vec3(2 * kRadius, 0, 0));
        double most = 0;
        for (int i = 0; i < 400; ++i) {
          const double a = 5e-4 * i;
          const SurfaceContact& c =
              t.tick((kRadius + radius - depth) * Vec3(std::cos(a), 0.8 * std::sin(a), 0.6 * std::sin(a)));
          const double push = c.force.dot(c.normal), ratio = (c.force - push * c.normal).norm() / push;
          if (!c.slip) most = std::max(most, ratio);
          if (i < 350) continue;
          ASSERT_TRUE(c.slip) << i << " " << depth << " " << radius << " " << (mesh != nullptr);
          ASSERT_NEAR(ratio, 0.2, 0.002) << i << " " << depth << " " << radius;
        }
        EXPECT_NEAR(most, 0.4, 0.02) << depth << " " << radius;
      }
    }
  }
}

TEST(ProxyFriction, SlipEndsInsideTheDynamicCone) {
  TestScene t;
  t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {kGripStiffness, 0, 0.6, 0.4});
  t.tick(Vec3(0, 0, 0.001));
  const double depth = 0.001;
  t.tick(Vec3(0, 0, -depth));
  EXPECT_TRUE(t.tick(Vec3(0.01, 0, -depth)).slip);
  EXPECT_TRUE(t.tick(Vec3(0.01, 0, -depth)).slip) << "at rest on the border";
  const SurfaceContact back = t.tick(Vec3(0.0099, 0, -depth));
  EXPECT_FALSE(back.slip);
  EXPECT_NEAR(back.force.x(), -kGripStiffness * 0.3 * depth, 1e-9);
  EXPECT_FALSE(t.tick(Vec3(0.01019, 0, -depth)).slip) << "now the static cone holds: 0.59";
  EXPECT_TRUE(t.tick(Vec3(0.01021, 0, -depth)).slip);
}

TEST(ProxyFriction, ACycleDissipatesTheAreaOfItsLoop) {
  // Elastic and perfectly plastic: 4 mu F_n (A - mu d) for a stroke of +-A.
  const double mu = 0.5, depth = 0.002, amplitude = 0.01;
  TestScene t;
  t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {kGripStiffness, 0, mu, mu});
  t.tick(Vec3(0, 0, 0.001));
  const int n = 4000;
  Vec3 x = Vec3(0, 0, -depth), f = t.tick(x).force;
  double work = 0;
  for (int i = 1; i <= 3 * n; ++i) {
    const Vec3 next(amplitude * std::sin(2 * M_PI * i / n), 0, -depth);
    const Vec3 force = t.tick(next).force;
    if (i > n) work += 0.5 * (f + force).dot(next - x);
    x = next;
    f = force;
  }
  EXPECT_NEAR(-work / 2, 4 * mu * kGripStiffness * depth * (amplitude - mu * depth), 1e-7);
}

TEST(ProxyFriction, AWallNeverGivesMoreThanItTook) {
  // Press, wander and release, at random; the hand's path is closed in free space. Trapezoids, fine steps.
  std::mt19937 random(seedOf(5));
  std::uniform_real_distribution<double> u(-1, 1);
  for (const double mu : {0.0, 0.2, 0.9}) {
    for (int round = 0; round < 20; ++round) {
      TestScene t;
      t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {kGripStiffness, 0, mu, 0.7 * mu});
      const Vec3 a(0.004 * u(random), 0.004 * u(random), -0.002 + 0.001 * u(random));
      const Vec3 b(0.006 * u(random), 0.006 * u(random), 0.003 * u(random));
      Vec3 x(0, 0, 0.004), f = t.tick(x).force;
      double work = 0;
      for (int i = 1; i <= 4000; ++i) {
        const double s = 2 * M_PI * i / 4000;
        const Vec3 next = Vec3(0, 0, 0.004) + (1 - std::cos(s)) * a + std::sin(s) * b * (1 - std::cos(s));
        const Vec3 force = t.tick(next).force;
        work += 0.5 * (f + force).dot(next - x);
        x = next;
        f = force;
      }
      EXPECT_LT(work, 2e-8) << mu << " " << round;
      if (mu == 0) {
        EXPECT_GT(work, -2e-8) << round;
      }
    }
  }
}

/** Where damping takes from the normal force, friction is in proportion to what it leaves, and nothing is left alone.
 */
TEST(ProxyFriction, AWithdrawingHandIsHeldByWhatDampingLeaves) {
  constexpr double kDamping = 10, kMu = 0.4;
  for (const double out : {0.0, 0.02, 0.05, 0.15, 0.5}) {
    TestScene t;
    t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {kGripStiffness, kDamping, kMu, kMu});
    t.tick(Vec3(0, 0, 1e-3));
    const Vec3 along(0.1, 0, 0), v = along + Vec3(0, 0, out);
    for (int i = 0; i < 200; ++i) t.tick(Vec3(0, 0, -3e-3) + i * kTick * along, along);
    for (int i = 200; i < 205; ++i) {
      const double depth = 3e-3 - (i - 200) * kTick * out;
      const SurfaceContact& c = t.tick(Vec3(0, 0, -depth) + i * kTick * along, v);
      const double normal = std::max(0.0, kGripStiffness * depth - kDamping * out);
      if (!(depth > 0)) break;
      ASSERT_NEAR(c.force.z(), normal, 1e-6) << out;
      ASSERT_NEAR(c.force.x(), -kMu * normal, 1e-6) << out;
    }
  }
}

/** By so little as one at rest, though damping has narrowed its cone; and not while what that leaves goes up and down.
 */
TEST(ProxyFriction, AWithdrawingHandThatTurnsBackSticks) {
  constexpr double kDamping = 80, kMu = 0.4, kOut = 0.05;  // 4 of 10 N.
  for (const double back : {0.0, 0.05}) {
    TestScene t;
    t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {kGripStiffness, kDamping, 1.5 * kMu, kMu});
    t.tick(Vec3(0, 0, 1e-3));
    Vec3 hip(0, 0, -10 / kGripStiffness);
    for (int i = 0; i < 200; ++i) t.tick(hip += Vec3(1e-4, 0, 0), Vec3(0.1, 0, 0));
    for (int i = 0; i < 20; ++i) {
      t.tick(hip += Vec3(1e-4, 0, kTick * kOut), Vec3(0.1, 0, (1 + 0.1 * (i % 2)) * kOut));
      ASSERT_TRUE(t.contact.slip) << i;
    }
    const double r = std::abs(t.contact.proxy.x() - hip.x());
    t.tick(hip += Vec3(back > 0 ? -back * r : 1e-4, 0, kTick * kOut), Vec3(0, 0, kOut));
    EXPECT_EQ(t.contact.slip, back == 0);
  }
}

/** To the bit: what rounding left of it would be a direction to whoever asks for one. */
TEST(ProxyFriction, DampingThatTakesAllLeavesNoForceAtAll) {
  Random random(seedOf(9));
  for (const ShapeKind kind : {ShapeKind::kPlane, ShapeKind::kSphere, ShapeKind::kCylinder}) {
    for (int run = 0; run < 50; ++run) {
      TestScene t;
      const double mu = random.once(2) ? 0.4 : 0;
      t.add(kind, Vec3(0.02, 0.02, 0), {}, {kGripStiffness, 10, mu, 0.7 * mu});
      const Vec3 out = kind == ShapeKind::kPlane ? Vec3::UnitZ() : Vec3(1, 0, 0);
      const Vec3 top = kind == ShapeKind::kPlane ? Vec3::Zero() : Vec3(0.02, 0, 0);
      const Vec3 any = random.vector(1e-4), slide = any - any.dot(out) * out;
      Vec3 hip = top + 1e-3 * out;
      for (int i = 0; i < 40; ++i) t.tick(hip += slide - 1e-4 * out);
      ASSERT_GT(t.contact.force.norm(), 0.1);
      const SurfaceContact& c = t.tick(hip += 1e-4 * out, 1e3 * out);
      ASSERT_GT(c.depth, 0);
      ASSERT_EQ(c.force, Vec3(0, 0, 0)) << run;
      ASSERT_GT(c.stored, 0);
    }
  }
}

TEST(ProxyFriction, DampingAndFrictionTogetherGiveNothing) {
  std::mt19937 random(seedOf(6));
  std::uniform_real_distribution<double> u(-1, 1);
  for (const double mu : {0.2, 0.9}) {
    for (int round = 0; round < 40; ++round) {
      TestScene t;
      t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {kGripStiffness, 2 + 10 * (1 + u(random)), mu, 0.7 * mu});
      // A closed path that wanders into the plane and out of it, also along it.
      Vec3 a[4], b[4];
      for (int k = 0; k < 4; ++k) {
        a[k] = 0.003 / (k + 1) * Vec3(u(random), u(random), u(random));
        b[k] = 0.003 / (k + 1) * Vec3(u(random), u(random), u(random));
      }
      constexpr int kTicks = 4000;
      const double turn = 2 * M_PI / kTicks;
      double work = 0, exchanged = 0;
      for (int i = 0; i < 2 * kTicks; ++i) {
        Vec3 x(0, 0, -1e-3), v = Vec3::Zero();
        for (int k = 0; k < 4; ++k) {
          const double w = turn * (k + 1);
          x += std::cos(w * i) * a[k] + std::sin(w * i) * b[k];
          v += w / kTick * (std::cos(w * i) * b[k] - std::sin(w * i) * a[k]);
        }
        const double part = t.tick(x, v).force.dot(v) * kTick;
        if (i < kTicks) continue;  // From round to round it is the same.
        work += part;
        exchanged += std::abs(part);
      }
      EXPECT_LE(work, 1e-3 * exchanged) << mu << " " << round;
    }
  }
}

TEST(ProxyFriction, AFrictionlessTourOfASphereCostsNothing) {
  TestMesh mesh = test::sphereMesh(0.05, 60);
  for (const bool as_mesh : {false, true}) {
    TestScene t;
    if (as_mesh) {
      t.addMesh(mesh.view());
    } else {
      t.add(ShapeKind::kSphere, Vec3(0.05, 0, 0));
    }
    const auto path = [](double s) {
      return Vec3((0.049 + 0.0005 * std::sin(3 * s)) *
                  Vec3(std::cos(s), std::sin(s), 0.3 * std::sin(2 * s)).normalized());
    };
    t.tick(2 * path(0));
    Vec3 x = path(0), f = t.tick(x).force;
    double work = 0, spent = 0;
    for (int i = 1; i <= 20000; ++i) {
      const Vec3 next = path(2 * M_PI * i / 20000);
      const Vec3 force = t.tick(next).force;
      const double w = 0.5 * (f + force).dot(next - x);
      work += w;
      spent += std::abs(w);
      x = next;
      f = force;
    }
    EXPECT_GT(spent, 1e-3);
    // Over an edge the proxy falls from one facet's depth to the next one's: a little is lost, nothing is won.
    EXPECT_LT(work, 1e-6 * spent) << as_mesh;
    EXPECT_GT(work, as_mesh ? -1e-3 * kGripStiffness * 0.001 * 0.31 : -1e-6 * spent) << as_mesh;
  }
}

TEST(ProxyFriction, TheBottomOfAFineBowlIsReached) {
  // Edges of 0.2 mm, pressed deep and stroked fast: plain proxies hang on the edges, millimetres behind.
  const double radius = 0.05;
  TestMesh mesh = bowlMesh(radius);
  MeshView* view = mesh.view();
  for (const double speed : {0.01, 0.1, 0.5}) {
    for (const double depth : {0.0003, 0.001, 0.005}) {
      TestScene t;
      t.addMesh(view);
      t.tick(Vec3(0, 0, 0.01));
      for (int i = 0; i < 800 && speed * kTick * i < 0.04; ++i) {
        const double a = -0.4 + speed * kTick * i / radius, b = 0.21 * std::sin(3 * a);
        const Vec3 u(std::sin(a) * std::cos(b), std::sin(b), -std::cos(a) * std::cos(b));
        const SurfaceContact& c = t.tick(Vec3(0, 0, radius) + (radius + depth) * u);
        if (i < 5) continue;
        ASSERT_LT((c.proxy - Vec3(0, 0, radius) - radius * u).norm(), 0.05 * 0.0002 + 0.003 * depth)
            << speed << " " << depth << " " << i;
      }
    }
  }
}

/** Force along the normal and across it, and how often the one lost what held the other in a tick. */
struct Rubbing {
  int let_go = 0;    ///< Ticks in which a proxy that slides came to lie where it would without friction.
  double wrong = 0;  ///< Of the contact's normal, the largest angle from the smooth surface's [rad].
};

/** A stroke at 10 mm/s, 1.5 mm deep, over a sheet of these heights with friction of 0.5. */
Rubbing rub(double half, std::uint32_t parts, double (*height)(double, double), double radius) {
  TestMesh mesh = test::heightMesh(half, parts, height);
  TestScene t(radius);
  t.addMesh(mesh.view(), {}, {kGripStiffness, 0, 0.5, 0.5});
  Rubbing rubbing;
  double last = 0;
  const double reach = 0.55 * half;
  for (double a = 0; a < 7; a += 1e-5 / reach) {
    const double x = reach * std::sin(a), y = 0.83 * reach * std::sin(0.71 * a + 0.4), e = 1e-6;
    const Vec3 n = Vec3(height(x - e, y) - height(x + e, y), height(x, y - e) - height(x, y + e), 2 * e).normalized();
    const Vec3 foot(x, y, height(x, y));
    if (a == 0) t.tick(foot + (radius + 3e-3) * n);
    const SurfaceContact& c = t.tick(foot + (radius - 1.5e-3) * n);
    const double along = c.force.dot(c.normal), ratio = (c.force - along * c.normal).norm() / along;
    if (last > 0.4 && ratio < 0.1) ++rubbing.let_go;
    rubbing.wrong = std::max(rubbing.wrong, std::acos(c.normal.dot(n)));
    last = ratio;
  }
  return rubbing;
}

/** Where a proxy without friction would come to in a hollow of two facets, friction alone keeps it from: no way around.
 */
TEST(ProxyFriction, IsNotLostOnASaddle) {
  const auto wave = [](double x, double y) { return 2e-3 * std::sin(157 * x) * std::cos(157 * y); };
  EXPECT_EQ(rub(0.05, 100, wave, 0).let_go, 0);
  EXPECT_EQ(rub(0.05, 20, wave, 0).let_go, 0);
}

/** On its way over an edge, which takes all sweeps of a tick: the contact's normal is the edge's, not the force's. */
TEST(ProxyFriction, ABallKeepsTheNormalOfAnEdge) {
  const auto dome = [](double x, double y) { return -10 * (x * x + y * y); };
  EXPECT_LT(rub(0.03, 6, dome, 2e-3).wrong, 0.25);
}

}  // namespace
}  // namespace hapticd
