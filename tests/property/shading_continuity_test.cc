// A shaded mesh feels like the smooth surface it stands for, between its facets too: docs/surfaces.md, "Round facets".
#include <gtest/gtest.h>

#include <numbers>

#include "rt/render/surface/shading.h"
#include "rt/render/surface/surface_effects.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kDepth = 1.5e-3, kStep = 1e-5;  // Of the hand below the smooth surface, and in a tick [m].

/** A sheet z = f(x, y). */
struct Sheet {
  double half;
  std::uint32_t parts;
  double (*height)(double x, double y);

  [[nodiscard]] Vec3 normal(double x, double y) const {
    constexpr double kBy = 1e-6;
    return Vec3(height(x - kBy, y) - height(x + kBy, y), height(x, y - kBy) - height(x, y + kBy), 2 * kBy).normalized();
  }
};

double dome(double x, double y) { return -10 * (x * x + y * y); }
double bowl(double x, double y) { return 10 * (x * x + y * y); }
double wave(double x, double y) { return 2e-3 * std::sin(157 * x) * std::cos(157 * y); }

constexpr Sheet kSheets[] = {{0.03, 6, dome},  {0.03, 40, dome}, {0.03, 6, bowl},
                             {0.03, 40, bowl}, {0.05, 20, wave}, {0.05, 100, wave}};
constexpr double kRadii[] = {0, 2e-3, 8e-3};

double angleBetween(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/** The largest of a stroke [rad]. */
struct Stroke {
  double jump = 0;              ///< Of the force, from tick to tick,
  double wrong = 0, plain = 0;  ///< against the smooth surface's normal, and of the unshaded force.
  double most_friction = 0;     ///< Shaded, in parts of the force along the normal; with friction only.
};

/** A stroke to and fro over the middle, at one depth below the smooth surface grown by the radius, read in steps. */
Stroke stroke(const Sheet& sheet, double radius, double mu, double resolution = 0) {
  TestMesh mesh = test::heightMesh(sheet.half, sheet.parts, sheet.height);
  TestScene t(radius);
  t.proxy.setResolution(resolution);
  const std::uint32_t id = t.addMesh(mesh.view(), {}, {1000, 0, mu, mu});
  SurfaceParameters surface{};
  surface.smooth_cosine = std::cos(0.9);
  EXPECT_EQ(t.setSurface(id, surface), ErrorCode::kOk);
  Shading shading;
  Stroke most;
  Vec3 last = Vec3::Zero();
  const double reach = 0.55 * sheet.half;
  for (double a = 0; a < 6; a += kStep / reach) {
    const double x = reach * std::sin(a), y = 0.83 * reach * std::sin(0.71 * a + 0.4);
    const Vec3 n = sheet.normal(x, y), foot(x, y, sheet.height(x, y));
    if (a == 0) t.tick(foot + (radius + 3e-3) * n);
    Vec3 hip = foot + (radius - kDepth) * n;
    for (double& x_i : hip)
      if (resolution > 0) x_i = std::round(x_i / resolution) * resolution;
    t.tick(hip);
    const Vec3 plain = t.contact.force;
    shading.step(*t.scene, t.proxy.holding(), Vec3::Zero(), t.contact);
    const Vec3& force = t.contact.force;
    EXPECT_NEAR(force.norm(), plain.norm(), 1e-9 * plain.norm()) << a;
    if (a > 0) most.jump = std::max(most.jump, angleBetween(force, last));
    most.wrong = std::max(most.wrong, angleBetween(force, n));
    most.plain = std::max(most.plain, angleBetween(plain, n));
    last = force;
  }
  return most;
}

/** Where facets meet, a point and balls of all sizes feel the normal turn as it does between: on domes and in hollows.
 */
TEST(ShadingContinuity, WithoutFrictionTheForceTurnsAsTheSmoothNormalDoes) {
  for (const Sheet& sheet : kSheets) {
    for (const double radius : kRadii) {
      SCOPED_TRACE(testing::Message() << (&sheet - kSheets) << ", ball of " << radius);
      const Stroke most = stroke(sheet, radius, 0);
      EXPECT_LT(most.jump, 6e-3);
      EXPECT_LT(most.wrong, (sheet.height == wave ? 0.75 : 0.15) * most.plain);
    }
  }
}

/** A relief on round facets lies on the smooth surface: as its slopes are felt, no facet is. */
TEST(ShadingContinuity, AReliefGoesOnOverEdges) {
  const auto grey = [](std::uint32_t x, std::uint32_t y) { return 0.5 + 0.5 * std::sin(0.1 * x) * std::cos(0.1 * y); };
  test::TestRelief relief(256, 256, grey);
  for (const double radius : {0.0, 2e-3}) {
    for (const double mu : {0.0, 0.3}) {
      SCOPED_TRACE(testing::Message() << "ball of " << radius << ", " << mu);
      TestMesh mesh = test::sphereMesh(0.05, 8);
      TestScene t(radius);
      const std::uint32_t id = t.addMesh(mesh.view(), {}, {1000, 0, mu, mu});
      SurfaceParameters surface{};
      surface.smooth_cosine = std::cos(0.9);
      surface.relief_depth = 5e-4;
      surface.relief_size[0] = surface.relief_size[1] = 0.1;
      surface.relief = 1;
      t.table->publishTexture(0, &relief.view);
      ASSERT_EQ(t.setSurface(id, surface), ErrorCode::kOk);
      Shading shading;
      SurfaceEffects effects;
      double jump = 0, least = 1, most = 0;
      Vec3 last = Vec3::Zero();
      t.tick(Vec3(0.06 + radius, 0, 0));
      for (double a = 0; a < 6; a += 2e-4) {
        const Vec3 u = Vec3(std::cos(a), std::sin(a), 0.7 * std::sin(0.6 * a + 0.3)).normalized();
        const Vec3 hip = (0.044 + radius) * u;
        t.tick(hip);
        shading.step(*t.scene, t.proxy.holding(), Vec3::Zero(), t.contact);
        const Vec3 added = effects.step(*t.scene, t.contact, t.proxy.holding(), hip, Vec3::Zero()).texture();
        const Vec3 share = added / t.contact.force.norm();
        if (a > 0) jump = std::max(jump, (share - last).norm());
        least = std::min(least, share.norm());
        most = std::max(most, share.norm());
        last = share;
      }
      EXPECT_GT(most - least, 0.1) << "the relief is felt";
      EXPECT_LT(jump, mu > 0 ? 0.02 : 1e-3);
    }
  }
}

/** Friction that sticks lets the force turn by a tick's way over the depth; nothing turns it by more than thrice that.
 */
TEST(ShadingContinuity, WithFrictionNoEdgeIsFelt) {
  for (const Sheet& sheet : kSheets) {
    for (const double radius : kRadii) {
      for (const double mu : {0.1, 0.5}) {
        SCOPED_TRACE(testing::Message() << (&sheet - kSheets) << ", ball of " << radius << ", " << mu);
        EXPECT_LT(stroke(sheet, radius, mu).jump, 4 * kStep / kDepth);
      }
    }
  }
}

/** A reading in steps lies on a line between two flat facets again and again, to the last bit. */
TEST(ShadingContinuity, AHandReadInStepsFeelsNoEdge) {
  constexpr double kResolution = 1e-5;
  for (const double radius : kRadii) {
    for (const double mu : {0.0, 0.3}) {
      SCOPED_TRACE(testing::Message() << "ball of " << radius << ", " << mu);
      EXPECT_LT(stroke(kSheets[0], radius, mu, kResolution).jump, mu == 0 ? 6e-3 : 3e-2);
      EXPECT_LT(stroke(kSheets[2], radius, mu, kResolution).jump, mu == 0 ? 6e-3 : 3e-2);
    }
  }
}

/** A tube about z, 20 mm wide at its upper rim, and how its quads are cut. */
struct Tube {
  double below;  ///< Its radius at the lower rim [m].
  bool lids, two_sided;
  bool turned = false;  ///< The lower rim, by half a side: three facets at each corner, which bend every way.
  double bottom = -0.02;
};
TestMesh tubeMesh(const Tube& tube, std::uint32_t sides, bool otherwise) {
  TestMesh mesh;
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double a = 2 * std::numbers::pi * i / sides, low = a + (tube.turned ? std::numbers::pi / sides : 0);
    (void)mesh.addVertex({tube.below * std::cos(low), tube.below * std::sin(low), tube.bottom});
    (void)mesh.addVertex({0.02 * std::cos(a), 0.02 * std::sin(a), 0.02});
  }
  const std::uint32_t low = mesh.addVertex({0, 0, tube.bottom}), high = mesh.addVertex({0, 0, 0.02});
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % sides);
    if (otherwise) {
      mesh.addQuad(b, b + 1, a + 1, a);
    } else {
      mesh.addQuad(a, b, b + 1, a + 1);
    }
    if (!tube.lids) continue;
    mesh.addTriangle(high, a + 1, b + 1);
    mesh.addTriangle(low, b, a);
  }
  return mesh;
}

/** Over a crease, and off a border, a ball rolls as without shading, whichever triangle of a corner it is held by. */
TEST(ShadingContinuity, ABallRollsOverTheCornersOfACrease) {
  constexpr Tube kTubes[] = {{0.02, true, false},
                             {0.004, true, false},
                             {0.004, true, true},
                             {0.02, false, true},
                             {0.022, false, false, true, 0.014},
                             {0.024, false, true, true, 0.014}};
  for (const Tube& tube : kTubes) {
    for (const bool otherwise : {true, false}) {
      if (tube.turned && otherwise) continue;  // It would be hollow between its facets.
      for (const std::uint32_t sides : {12u, 24u}) {
        for (const double mu : {0.0, 0.3}) {
          SCOPED_TRACE(testing::Message() << sides << " sides, " << mu << ' ' << (&tube - kTubes) << otherwise);
          TestMesh mesh = tubeMesh(tube, sides, otherwise);
          TestScene t(5e-3);
          const std::uint32_t id =
              t.addMesh(mesh.view(), {}, {1000, 0, mu, mu}, tube.two_sided ? test::kTwoSided : test::kOneSided);
          SurfaceParameters surface{};
          surface.smooth_cosine = std::cos(0.8);
          ASSERT_EQ(t.setSurface(id, surface), ErrorCode::kOk);
          Shading shading;
          double jump = 0, most = 0;
          Vec3 last = Vec3::Zero();
          for (double a = -0.01; a < 8; a += 1e-3) {  // Up and down over the rim, and round it.
            const double lowest = std::atan2(tube.below - 0.02, 0.02 - tube.bottom), around = 0.31 * a;
            const double up = lowest + (std::numbers::pi / 2 - lowest) / 2 * (1 + std::sin(a));
            const Vec3 out(std::cos(around), std::sin(around), 0);
            const Vec3 n = std::cos(up) * out + std::sin(up) * Vec3::UnitZ();
            const Vec3 hip = 0.02 * out + 0.02 * Vec3::UnitZ() + (a < 0 ? 7e-3 : 4e-3) * n;
            t.tick(hip);
            const Vec3 plain = t.contact.force;
            shading.step(*t.scene, t.proxy.holding(), Vec3::Zero(), t.contact);
            const Vec3& force = t.contact.force;
            if (a > 0.01) jump = std::max(jump, angleBetween(force, last));
            most = std::max(most, angleBetween(force, plain));
            last = force;
          }
          const double half_bend = std::numbers::pi / sides;
          EXPECT_LT(jump, tube.turned ? half_bend : 3e-2);
          EXPECT_LT(most, half_bend + 0.05) << "half of what a facet bends, as beside the rim";
        }
      }
    }
  }
}

/** Below a hand at rest a coarse sphere turns: what is felt is that of a hand that goes over the sphere at rest. */
TEST(ShadingContinuity, ItIsTheRelativeMotionThatCounts) {
  const Vec3 w(0.2, 0.5, 1.1);
  for (const double radius : {0.0, 2e-3}) {
    for (const double mu : {0.0, 0.3}) {
      SCOPED_TRACE(testing::Message() << "ball of " << radius << ", " << mu);
      TestMesh mesh = test::sphereMesh(0.05, 8);
      TestScene turning, resting;
      Shading shading[2];
      Vec3 last = Vec3::Zero();
      SurfaceParameters surface{};
      surface.smooth_cosine = std::cos(0.9);
      std::uint32_t id = 0;
      for (TestScene* t : {&turning, &resting}) {
        t->proxy.setRadius(radius);
        id = t->addMesh(mesh.view(), {}, {1000, 0, mu, mu});
        ASSERT_EQ(t->setSurface(id, surface), ErrorCode::kOk);
        t->tick(Vec3(0.06 + radius, 0, 0.01));
      }
      const Vec3 hip(0.047 + radius, 0, 0.008);
      for (int i = 0; i < 3000; ++i) {
        const Quat q(Eigen::AngleAxisd(w.norm() * test::kTick * i, w.normalized()));
        turning.pose(id, {Vec3::Zero(), q});
        turning.tick(hip);
        shading[0].step(*turning.scene, turning.proxy.holding(), Vec3::Zero(), turning.contact);
        const Vec3 seen = q.conjugate() * hip;
        resting.tick(seen);
        shading[1].step(*resting.scene, resting.proxy.holding(), Vec3::Zero(), resting.contact);
        const double jump = angleBetween(turning.contact.force, last);
        last = turning.contact.force;
        if (i < 200) continue;  // It sinks in at once, and is dragged until it slides.
        ASSERT_LT((last - q * resting.contact.force).norm(), mu > 0 ? 1e-2 : 1e-9) << i;
        ASSERT_LT(jump, mu > 0 ? 0.08 : 1e-3) << i;
      }
    }
  }
}

}  // namespace
}  // namespace hapticd
