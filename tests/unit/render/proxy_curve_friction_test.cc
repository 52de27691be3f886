// Friction where the surface turns below the proxy: on curves, and on edges over which a ball slides.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kStiffness = 1000;

/** Pushed along either face beyond the edge, at 37 degrees from the edge's normal: inside a cone of 39 wherever it is.
 * Of a rim anywhere. */
TEST(ProxyFriction, ABallSticksToAnEdgeWhateverHasIt) {
  constexpr double kHalf = 0.02, kRadius = 2e-3, kStep = 1e-4;
  for (const ShapeKind kind : {ShapeKind::kBox, ShapeKind::kCylinder, ShapeKind::kMesh}) {
    for (const bool down : {false, true}) {
      TestMesh mesh = test::boxMesh(Vec3::Constant(kHalf));
      TestScene t(kRadius);
      t.add(kind, Vec3::Constant(kHalf), {}, {kStiffness, 0, 0.8, 0.6}, HD_OBJECT_ENABLED, 0,
            kind == ShapeKind::kMesh ? mesh.view() : nullptr);
      const Quat about(Eigen::AngleAxisd(kind == ShapeKind::kCylinder ? 0.7 : 0, Vec3::UnitZ()));
      const Vec3 along = about * (down ? Vec3(0, 0, -1) : Vec3(1, 0, 0));
      const Vec3 from = about * (Vec3(-kHalf, 0, kHalf) + kRadius * (down ? Vec3(-0.6, 0, 0.8) : Vec3(-0.8, 0, 0.6)));
      for (int i = -40; i <= 100; ++i) {
        const SurfaceContact& c = t.tick(from + kStep * i * along);
        ASSERT_NEAR((c.force + kStiffness * kStep * std::max(0, i) * along).norm(), 0, 1e-6)
            << static_cast<int>(kind) << " " << down << " " << i;
        ASSERT_FALSE(c.slip);
      }
    }
  }
}

/** From the air beside the corner and its edges until it is deep below it, along many ways. */
TEST(ProxyFriction, ABallSticksToACornerWhateverHasIt) {
  constexpr double kHalf = 0.02, kRadius = 4e-3;
  TestMesh mesh = test::boxMesh(Vec3::Constant(kHalf));
  MeshView* view = mesh.view();
  Random random(seedOf(3));
  int stuck = 0;
  for (int run = 0; run < 200; ++run) {
    TestScene box(kRadius), other(kRadius);
    const hd_material material{kStiffness, 0, 0.9, 0.7};
    box.add(ShapeKind::kBox, Vec3::Constant(kHalf), {}, material);
    other.addMesh(view, {}, material);
    const Vec3 corner = Vec3::Constant(kHalf), above = corner + kRadius * Vec3::Ones().normalized();
    const Vec3 down = -(Vec3::Ones() + random.vector(0.5)).normalized();
    for (int i = -5; i < 90; ++i) {
      const Vec3 hip = above + 1e-4 * i * down, force = box.tick(hip).force;
      ASSERT_NEAR((other.tick(hip).force - force).norm(), 0, 1e-6 * (1 + force.norm())) << run << " " << i;
      stuck += i > 60 && !box.contact.slip && (box.contact.proxy - above).norm() < 1e-3;
    }
  }
  EXPECT_GT(stuck, 1000);
}

/**
 * On a circle of radius R, from a hip at h of its middle, the border of the cone is at the angle from it at which
 * h sin(angle) = mu (R - h cos(angle)); it takes no more looks at the surface than without friction.
 */
TEST(ProxyFriction, TheBorderOfTheConeOnACurveTakesFewSweeps) {
  constexpr double kMu = 0.64, kRadius = 2e-3;
  struct Case {
    ShapeKind kind;
    double size, ball;
  };
  for (const Case& at : {Case{ShapeKind::kSphere, 0.02, 0},
                         {ShapeKind::kCapsule, 0.02, kRadius},
                         {ShapeKind::kCylinder, 0.02, 0},
                         {ShapeKind::kBox, 0.02, kRadius},
                         {ShapeKind::kMesh, 0.02, kRadius}}) {
    const bool edge = at.kind == ShapeKind::kBox || at.kind == ShapeKind::kMesh;
    const double round = at.ball + (edge ? 0 : at.size);
    const Vec3 middle = edge ? Vec3(at.size, at.size, 0) : Vec3::Zero();
    for (const auto& [part, far] : {std::pair(0.01, 0.0), {0.2, 0.0}, {0.2, 1000.0}}) {
      const Vec3 origin(far, -far, 0);
      TestMesh mesh = test::boxMesh(Vec3::Constant(at.size));
      TestScene t(at.ball);
      t.add(at.kind, Vec3::Constant(at.size), {origin, Quat::Identity()}, {kStiffness, 0, 0.8, kMu}, HD_OBJECT_ENABLED,
            0, at.kind == ShapeKind::kMesh ? mesh.view() : nullptr);
      const double h = round * (1 - part);
      const double lag = std::asin(kMu * round / (h * std::sqrt(1 + kMu * kMu))) - std::atan(kMu);
      const double step = 0.01 * lag;
      int slid = 0;
      for (int i = -1; i < 600; ++i) {
        const double angle = 0.05 + step * std::max(0, i);
        if (edge && angle > 1.5) break;
        const double out = i < 0 ? 1.5 * round : h;
        const SurfaceContact& c = t.tick(origin + middle + out * Vec3(std::cos(angle), std::sin(angle), 0));
        if (i < 300 || angle - lag < 0.05) continue;
        const Vec3 way = c.proxy - origin - middle;
        ++slid;
        ASSERT_TRUE(c.slip) << static_cast<int>(at.kind) << " " << part << " " << i;
        ASSERT_NEAR(angle - std::atan2(way.y(), way.x()), lag,
                    at.kind == ShapeKind::kMesh || far > 0 ? 1e-6 : 1e-7 * lag)
            << static_cast<int>(at.kind) << " " << part;
        ASSERT_LE(t.proxy.effort().sweeps, 5u) << static_cast<int>(at.kind) << " " << part << " " << i;
      }
      EXPECT_GT(slid, 20) << static_cast<int>(at.kind) << " " << part;
    }
  }
}

/**
 * A hand so near the middle that only a narrow part of the circle, or none, is outside the cone: h < mu R / sqrt(1 +
 * mu^2) reaches none. The border is found all the same, and at rest the force is steady.
 */
TEST(ProxyFriction, ADeepHandInACurveFindsTheBorderOfItsCone) {
  constexpr double kRadius = 0.03;
  int slid = 0;
  forSeeds(300, [&](unsigned seed) {
    Random random(seed);
    const double mu = std::pow(10, random.in(-1, 0.3)), ball = random.once(2) ? 0 : random.in(5e-4, 6e-3);
    constexpr ShapeKind kRound[] = {ShapeKind::kSphere, ShapeKind::kCapsule, ShapeKind::kCylinder};
    TestScene t(ball);
    t.add(kRound[random.below(3)], {kRadius, 0.1, 0}, {}, {kStiffness, 0, mu, mu});
    const double least = mu * (kRadius + ball) / std::sqrt(1 + mu * mu);
    const double h = least * (1 + (random.once(2) ? 1 : -0.1) * std::pow(10, random.in(-8, -0.5)));
    for (int i = 0; i <= 50; ++i) t.tick(Vec3(2 * kRadius + (h - 2 * kRadius) * i / 50, 0, 0));
    const double step = random.in(5e-4, 0.02);
    Vec3 hip;
    const auto check = [&] {
      const SurfaceContact& c = t.tick(hip);
      ASSERT_LE(t.proxy.effort().sweeps, 10u);
      const Vec3 lag = c.pull - c.depth * c.normal;
      ASSERT_LE(lag.norm(), mu * c.depth * (1 + 1e-8));
      slid += c.slip;
    };
    for (int i = 0; i < 200 && step * i < 2; ++i) {
      hip = h * Vec3(std::cos(step * i), std::sin(step * i), 0);
      check();
      if (::testing::Test::HasFatalFailure()) return;
    }
    const Vec3 force = t.contact.force;
    for (int i = 0; i < 10; ++i) {
      check();
      ASSERT_NEAR((t.contact.force - force).norm(), 0, 1e-6);
    }
  });
  EXPECT_GT(slid, drawn(2000));
}

/** Over its edge and on along the face beyond, in ticks of half a radius: as if its faces were of triangles. */
TEST(ProxyFriction, ABallRollsOffABoxAsOffItsMesh) {
  constexpr double kHalf = 1.0 / 64, kRadius = 2e-3, kDeep = 8e-4;
  TestMesh mesh = test::boxMesh(Vec3::Constant(kHalf));
  int edges = 0;
  for (const double step : {4e-4, 7e-4, 1e-3}) {
    for (const double aside : {-0.8, 0.0, 0.5}) {
      const hd_material material{kStiffness, 0, 0.6, 0.4};
      TestScene box, other;
      box.add(ShapeKind::kBox, Vec3::Constant(kHalf), {}, material);
      other.addMesh(mesh.view(), {}, material);
      box.proxy.setRadius(kRadius);
      other.proxy.setRadius(kRadius);
      for (int i = -1; i < 40; ++i) {  // Along the upper face, round a quarter of a circle and down beside it.
        const double way = step * i - 0.01, inner = kRadius - kDeep, turn = std::clamp(way / inner, 0.0, M_PI / 2);
        const Vec3 hip(kHalf + std::min(way, 0.0) + inner * std::sin(turn), aside * way,
                       kHalf + inner * std::cos(turn) - std::max(0.0, way - inner * M_PI / 2) + (i < 0 ? 0.01 : 0));
        const SurfaceContact& c = box.tick(hip);
        ASSERT_NEAR((other.tick(hip).force - c.force).norm(), 0, 1e-6 * kStiffness * kDeep) << step << " " << i;
        edges += c.slip && c.normal.x() > 0.01 && c.normal.z() > 0.01;
      }
    }
  }
  EXPECT_GT(edges, 10);
}

/** A hand that throws itself through damped meshes: over an edge damping takes of the next face's force what is its
 * own. */
TEST(ProxyFriction, AFastHandThatDampingFreesIsInTheConeOfTheFaceItComesTo) {
  int contacts = 0, freed = 0, beyond = 0;
  forSeeds(300, [&](unsigned seed) {
    Random random(seed);
    const double mu = random.in(0.1, 1), speed = std::pow(10, random.in(-1, 0.5));
    TestScene t(random.once(2) ? 0 : random.in(5e-4, 4e-3));
    TestMesh mesh = test::sphereMesh(random.in(0.01, 0.03), 6);
    mesh.scale([&] { return random.in(0.8, 1.1); });
    t.addMesh(mesh.view(), random.pose(0.01), {kStiffness, random.in(0, 20), mu, 0.7 * mu});
    Vec3 hip(0.1, 0, 0), v = Vec3::Zero();
    t.tick(hip);
    for (int i = 0; i < 400; ++i) {
      if (i % 20 == 0) v = speed * (random.vector(0.03) - hip).normalized();
      const SurfaceContact& c = t.tick(hip += test::kTick * v, v);
      const double normal = c.force.dot(c.normal);
      contacts += c.object != 0;
      freed += c.damping < -1;
      beyond += (c.force - normal * c.normal).norm() > mu * std::max(0.0, normal) + 1;
    }
  });
  if (!drawsAll()) return;
  EXPECT_GT(contacts, 10'000);
  EXPECT_GT(freed, 1000);
  EXPECT_LE(beyond, 3) << "through hollows";
}

/** About the y axis, of so many flat sides, without its ends. */
TestMesh tubeMesh(double radius, double half, std::uint32_t sides) {
  TestMesh m;
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double angle = 2 * M_PI * i / sides;
    for (const double y : {-half, half}) m.addVertex({radius * std::sin(angle), y, radius * std::cos(angle)});
  }
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t next = (i + 1) % sides;
    m.addQuad(2 * i, 2 * next, 2 * next + 1, 2 * i + 1);
  }
  return m;
}

/** However many sides lie between the proxy and where it would slide to. */
TEST(ProxyFriction, AFineTubeBreaksAwayLikeACoarseOne) {
  constexpr double kRadius = 0.03, kDepth = 0.01, kStill = 0.6, kSliding = 0.42;
  for (const std::uint32_t sides : {100u, 800u}) {
    TestMesh mesh = tubeMesh(kRadius, 0.05, sides);
    TestScene t;
    t.addMesh(mesh.view(), {}, {kStiffness, 0, kStill, kSliding});
    t.tick(Vec3(0, 0.001, 2 * kRadius));
    double most = 0, last = 0;
    for (int i = 0; i < 3000; ++i) {
      const double angle = 3e-4 * i;
      const SurfaceContact& c =
          t.tick(Vec3((kRadius - kDepth) * std::sin(angle), 0.001, (kRadius - kDepth) * std::cos(angle)));
      const double normal = c.force.dot(c.normal);
      last = (c.force - normal * c.normal).norm() / normal;
      most = std::max(most, last);
    }
    EXPECT_NEAR(most, kStill, 0.01) << sides;
    EXPECT_NEAR(last, kSliding, 0.01) << sides;
  }
}

/** All the way to the border of the cone, over as many faces as lie between: the next tick has nothing left to go. */
TEST(ProxyFriction, ADeepHandBreaksAwayInOneTickInAFineBowl) {
  constexpr double kRound = 0.05, kStep = 1e-5, kStill = 1.1, kSliding = 0.6;
  TestMesh mesh = test::heightMesh(
      0.014, 112, [](double x, double y) { return kRound - std::sqrt(kRound * kRound - x * x - y * y); });
  MeshView* view = mesh.view();
  Random random(seedOf(1));
  for (int run = 0; run < 20; ++run) {
    TestScene t(run % 2 == 0 ? 0 : 1e-3);
    t.addMesh(view, {}, {kStiffness, 0, kStill, kSliding});
    const double way = random.in(0, 2 * M_PI), depth = random.in(5e-3, 7e-3);
    const Vec3 along(std::cos(way), std::sin(way), 0);
    const Vec3 from = t.proxy.radius() * Vec3::UnitZ() - 4e-3 * along;
    t.tick(from + 0.01 * Vec3::UnitZ());
    for (int i = 1; i <= 100; ++i) t.tick(from - 0.01 * i * depth * Vec3::UnitZ());
    bool slipped = false;
    Vec3 hip = from - depth * Vec3::UnitZ();
    for (int i = 0; i < 1200 && !slipped; ++i) slipped = t.tick(hip += kStep * along).slip;
    ASSERT_TRUE(slipped) << run;
    const SurfaceContact c = t.contact;
    const Vec3 out = (Vec3(0, 0, kRound) - c.proxy).normalized();
    EXPECT_GT(c.normal.dot(out), 0.999) << run;
    EXPECT_NEAR((c.force - c.force.dot(c.normal) * c.normal).norm() / c.force.dot(c.normal), kSliding, 0.01) << run;
    EXPECT_LT((t.tick(hip + kStep * along).proxy - c.proxy).norm(), 0.1 * depth * (kStill - kSliding)) << run;
  }
}

}  // namespace
}  // namespace hapticd
