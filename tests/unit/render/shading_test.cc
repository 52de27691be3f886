#include "rt/render/surface/shading.h"

#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "rt/base/rotation.h"
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/render/surface/smooth_normal.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

double degrees(double d) { return std::cos(d * std::numbers::pi / 180); }

/** A mesh of 1000 N/m whose edges below `angle` are shaded round. */
struct Shaded {
  TestScene scene;
  Shading shading;
  Vec3 plain = Vec3::Zero();  ///< Force before shading.

  Shaded(MeshView* mesh, double cosine, const hd_material& material = {1000, 0, 0, 0},
         std::uint32_t flags = HD_OBJECT_ENABLED) {
    const std::uint32_t id = scene.addMesh(mesh, {}, material, flags);
    SurfaceParameters surface{};
    surface.smooth_cosine = cosine;
    EXPECT_EQ(scene.setSurface(id, surface), ErrorCode::kOk);
  }
  const Vec3& at(const Vec3& hip, const Vec3& v = Vec3::Zero()) {
    scene.tick(hip, v);
    plain = scene.contact.force;
    shading.step(*scene.scene, scene.proxy.holding(), v, scene.contact);
    return scene.contact.force;
  }
};

double angleBetween(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/** The thesis's second sphere: 224 triangles, facets bend by 22 degrees; the ball's own normal is the truth. */
TEST(Shading, ACoarseSphereFeelsRound) {
  TestMesh mesh = test::sphereMesh(0.05, 8);
  Shaded t(mesh.view(), degrees(60));
  t.at({0, 0.001, 0.06});
  double plain = 0, shaded = 0;
  int felt = 0;
  for (int i = 0; i < 20000; ++i) {
    const double a = 0.002 * i, b = 0.00071 * i;
    const Vec3 n(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b));
    const Vec3 force = t.at(0.045 * n);
    if (force.norm() == 0 || std::abs(n.z()) > 0.9) continue;  // The poles' fans are no sphere's normals.
    ASSERT_NEAR(force.norm(), t.plain.norm(), 1e-12) << "it keeps its magnitude";
    plain = std::max(plain, angleBetween(t.plain, n));
    shaded = std::max(shaded, angleBetween(force, n));
    ++felt;
  }
  EXPECT_GT(felt, 10000);
  EXPECT_GT(plain, 0.18) << "the facets' own";
  EXPECT_LT(shaded, 0.35 * plain);
}

/** From tick to tick the direction turns as the hand does, where a facet's edge made it jump. */
TEST(Shading, NoEdgeIsFelt) {
  TestMesh mesh = test::sphereMesh(0.05, 8);
  Shaded t(mesh.view(), degrees(60));
  t.at({0.06, 0, 0.004});
  double plain = 0, shaded = 0;
  Vec3 last_plain, last_shaded;
  for (int i = 0; i < 8000; ++i) {
    const double a = 0.5e-3 * i;
    t.at(Vec3(0.0478 * std::cos(a), 0.0478 * std::sin(a), 0.004));
    if (i > 0 && t.plain.norm() > 0 && last_plain.norm() > 0) {
      plain = std::max(plain, angleBetween(t.plain, last_plain));
      shaded = std::max(shaded, angleBetween(t.scene.contact.force, last_shaded));
    }
    last_plain = t.plain;
    last_shaded = t.scene.contact.force;
  }
  EXPECT_GT(plain, 0.01);
  EXPECT_LT(shaded, 0.3 * plain);
}

/** Boxes have creases: whatever the angle below 90 degrees, each face keeps its own normal, edges and corners too. */
TEST(Shading, CreasesStaySharp) {
  TestMesh a = test::boxMesh(Vec3(0.03, 0.02, 0.01)), b = test::boxMesh(Vec3(0.03, 0.02, 0.01));
  Shaded shaded(a.view(), degrees(80)), plain(b.view(), 0);
  for (Shaded* t : {&shaded, &plain}) t->at(Vec3(0, 0, 0.02));
  for (int i = 0; i < 5000; ++i) {
    const double w = 0.003 * i;
    const Vec3 hip(0.033 * std::sin(w), 0.022 * std::sin(1.3 * w), 0.007 + 0.003 * std::cos(5 * w));
    ASSERT_LT((shaded.at(hip) - plain.at(hip)).norm(), 1e-9) << i;
  }
}

/** On a crease between round parts the support stays what it was; the side of a prism is round about its axis alone. */
TEST(Shading, OnlyEdgesThatBendLittleAreRounded) {
  TestMesh mesh;
  constexpr int kSides = 12;  // 30 degrees each; the lids bend by 90.
  std::vector<std::uint32_t> low, high;
  for (int i = 0; i < kSides; ++i) {
    const double a = 2 * std::numbers::pi * i / kSides;
    low.push_back(mesh.addVertex({0.02 * std::cos(a), 0.02 * std::sin(a), -0.02}));
    high.push_back(mesh.addVertex({0.02 * std::cos(a), 0.02 * std::sin(a), 0.02}));
  }
  for (std::size_t i = 0; i < kSides; ++i) {
    const std::size_t k = (i + 1) % kSides;
    mesh.addQuad(low[i], low[k], high[k], high[i]);
    if (k != 0 && i != 0) {
      mesh.addTriangle(high[0], high[i], high[k]);
      mesh.addTriangle(low[0], low[k], low[i]);
    }
  }
  Shaded t(mesh.view(), degrees(45));
  t.at({0.03, 0, 0});
  for (int i = 0; i < 4000; ++i) {
    const double a = 0.003 * i;
    const Vec3 force = t.at({0.017 * std::cos(a), 0.017 * std::sin(a), 0.013 * std::sin(0.01 * i)});
    ASSERT_NEAR(force.z(), 0, 1e-9) << "the lids do not shine through";
    ASSERT_LT(angleBetween(force, Vec3(std::cos(a), std::sin(a), 0)), 0.05) << i;
  }
  Shaded lid(mesh.view(), degrees(45));
  lid.at({0, 0, 0.03});
  for (int i = 0; i < 1000; ++i) {
    const Vec3 force = lid.at({0.01 * std::sin(0.01 * i), 0.01 * std::cos(0.02 * i), 0.0195});
    ASSERT_LT((force - Vec3(0, 0, 0.5)).norm(), 1e-6);
  }
}

/** Where the radii of a round side come together its normal is that of the last layer that is still long enough: three
 * quarters of the way in. Whichever corner of a triangle is the first. */
TEST(Shading, TooDeepTheNormalIsThatThreeQuartersOfTheWayIn) {
  constexpr int kSides = 12;
  constexpr double kRadius = 0.02, kHalf = std::numbers::pi / kSides;
  const auto radial = [](double azimuth) { return Vec3(std::cos(azimuth), std::sin(azimuth), 0); };
  for (std::size_t first = 0; first < 3; ++first) {
    TestMesh mesh;
    for (int i = 0; i < kSides; ++i)
      for (const double z : {-0.02, 0.02}) mesh.addVertex(kRadius * radial(2 * kHalf * i) + z * Vec3::UnitZ());
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kSides);
      for (const auto& v : {std::array{a, b, b + 1}, std::array{a, b + 1, a + 1}})
        mesh.addTriangle(v[first], v[(first + 1) % 3], v[(first + 2) % 3]);
    }
    const SmoothSheet sheet{*mesh.view(), degrees(45), 1};
    // There an edge is as long as the normals of its ends, which meet on the axis, have left of it.
    const double left = 1 - 0.75 / std::cos(kHalf), aside = 0.5 * left * kRadius * std::sin(kHalf);
    const Vec3 normal = radial(kHalf), across = radial(kHalf + std::numbers::pi / 2);
    for (const double depth : {0.751 * kRadius, 0.85 * kRadius, 0.95 * kRadius}) {
      const Vec3 x = (kRadius * std::cos(kHalf) - depth) * normal + aside * across + 0.003 * Vec3::UnitZ();
      for (std::uint32_t t = 0; t < 2 * kSides; ++t) {
        if (faceNormal(sheet.mesh, t).dot(normal) < 0.999) continue;
        std::uint32_t work = 0;
        const Vec3 expected = (0.25 * radial(0) + 0.75 * radial(2 * kHalf)).normalized();
        EXPECT_LT((sheet.normalToward(x, t, work) - expected).norm(), 1e-6) << first << ' ' << depth << ' ' << t;
      }
    }
  }
}

/** A two-sided sheet is round from behind too. */
TEST(Shading, TheBackOfASheetIsShadedLikeItsFront) {
  TestMesh mesh = test::heightMesh(0.05, 6, [](double x, double y) { return -4 * (x * x + y * y); });
  Shaded front(mesh.view(), degrees(60), {1000, 0, 0, 0}, HD_OBJECT_ENABLED | HD_OBJECT_TWO_SIDED);
  Shaded back(mesh.view(), degrees(60), {1000, 0, 0, 0}, HD_OBJECT_ENABLED | HD_OBJECT_TWO_SIDED);
  front.at({0.0113, 0.0071, 0.02});
  back.at({0.0113, 0.0071, -0.04});
  const Vec3 f = front.at({0.0113, 0.0071, -0.003}), b = back.at({0.0113, 0.0071, 0.003});
  ASSERT_GT(f.z(), 0);
  ASSERT_LT(b.z(), 0);
  const Vec3 normal = Vec3(8 * 0.0113, 8 * 0.0071, 1).normalized();
  EXPECT_LT(angleBetween(f, normal), 0.7 * angleBetween(front.plain, normal) + 1e-3);
  EXPECT_LT(angleBetween(b, -normal), 0.1);
  double plain = 0, shaded = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = 0.02 * std::sin(0.01 * i), y = 0.02 * std::cos(0.013 * i);
    const Vec3 there = Vec3(8 * x, 8 * y, 1).normalized();
    const Vec3 force = back.at({x, y, 0.003 - 4 * (x * x + y * y)});
    plain = std::max(plain, angleBetween(back.plain, -there));
    shaded = std::max(shaded, angleBetween(force, -there));
  }
  EXPECT_LT(shaded, 0.6 * plain);
}

/** A groove that bends by 30 degrees, shaded up to 20: a hand below its line is held by both sides, straight up. */
TEST(Shading, ACreaseKeepsItsSupport) {
  const double slope = std::tan(15 * std::numbers::pi / 180);
  TestMesh mesh = test::heightMesh(0.05, 4, [&](double x, double) { return slope * std::abs(x); });
  Shaded t(mesh.view(), degrees(20)), round(mesh.view(), degrees(40));
  for (Shaded* s : {&t, &round}) s->at({0, 0.006, 0.01});
  for (int i = -10; i <= 10; ++i) {
    ASSERT_LT((t.at({1e-5 * i, 0.006, -0.002}) - t.plain).norm(), 1e-12);
    ASSERT_GT(t.plain.z(), 1.5);
    ASSERT_NEAR(t.plain.x(), -0.01 * i, 1e-9) << "held by both";
  }
  const std::uint32_t before = round.scene.contact.work;
  ASSERT_NEAR(round.at({0, 0.006, -0.002}).x(), 0, 1e-9) << "rounded, and even";
  EXPECT_GT(round.scene.contact.work, before) << "what shading takes is counted";
}

/** On a mesh's floor before another object's wall: the support is that of both, and each keeps its share. */
TEST(Shading, InACornerOfTwoSurfacesEachKeepsItsShare) {
  TestMesh mesh = test::heightMesh(0.05, 4, [](double, double) { return 0.0; });
  Shaded t(mesh.view(), degrees(60));
  t.scene.add(ShapeKind::kPlane, Vec3::Zero(),
              {{0.011, 0, 0}, fromRotationVector(-std::numbers::pi / 2 * Vec3::UnitY())});
  t.at({0.003, 0.004, 0.01});
  for (int i = 0; i <= 4; ++i) {
    const double depth = (1 + i) * 1e-3;
    t.at({0.011 + 1e-3, 0.004, -depth});
    ASSERT_NEAR(t.plain.x(), -1, 1e-6);
    ASSERT_NEAR(t.plain.z(), 1000 * depth, 1e-6);
    ASSERT_LT((t.scene.contact.force - t.plain).norm(), 1e-12) << "the wall is felt to the full";
  }
}

/** A cone with `sides` facets, its tip at the origin, open below. */
TestMesh coneMesh(int sides, double radius, double height) {
  TestMesh mesh;
  const std::uint32_t tip = mesh.addVertex(Vec3::Zero());
  const auto count = static_cast<std::uint32_t>(sides);
  for (int i = 0; i < sides; ++i) {
    const double a = 2 * std::numbers::pi * i / sides;
    mesh.addVertex({radius * std::cos(a), radius * std::sin(a), -height});
  }
  for (std::uint32_t i = 0; i < count; ++i) mesh.addTriangle(tip, tip + 1 + i, tip + 1 + (i + 1) % count);
  return mesh;
}

/** Near the tip the corners' normals are those of the axis: on a blunt cone that is round, on a needle a lie. */
TEST(Shading, NoForceIsTurnedByMoreThanSixtyDegrees) {
  for (const double slope : {40.0, 75.0}) {
    SCOPED_TRACE(slope);
    TestMesh mesh = coneMesh(24, 0.02, 0.02 * std::tan(slope * std::numbers::pi / 180));
    Shaded t(mesh.view(), degrees(60));
    const double tilt = slope * std::numbers::pi / 180, out = std::numbers::pi / 24;  // the middle of a facet
    const Vec3 normal(std::sin(tilt) * std::cos(out), std::sin(tilt) * std::sin(out), std::cos(tilt));
    const Vec3 along(std::cos(tilt) * std::cos(out), std::cos(tilt) * std::sin(out), -std::sin(tilt));
    t.at(2e-4 * along + 2e-3 * normal);
    t.at(2e-4 * along - 2e-5 * normal);
    ASSERT_GT(t.plain.norm(), 0.01);
    ASSERT_LT(angleBetween(t.plain, normal), 0.05);
    const double turned = angleBetween(t.plain, t.scene.contact.force);
    if (slope < 60) {
      EXPECT_GT(turned, 0.3) << "toward the axis";
    } else {
      EXPECT_LT(turned, 1e-12);
    }
  }
}

/** Of thousands of facets about one corner those next to the one touched are taken, and counted. */
TEST(Shading, WorkIsBounded) {
  for (const int sides : {100, 8000}) {
    SCOPED_TRACE(sides);
    TestMesh mesh = coneMesh(sides, 0.02, 0.01);
    Shaded t(mesh.view(), degrees(60));
    const Vec3 normal = Vec3(0.01, 1e-7, 0.02).normalized(), along = Vec3(0.02, 1e-7, -0.01).normalized();
    t.at(1e-3 * along + 1e-3 * normal);
    t.scene.tick(1e-3 * along - 1e-4 * normal);
    const std::uint32_t before = t.scene.contact.work;
    t.shading.step(*t.scene.scene, t.scene.proxy.holding(), Vec3::Zero(), t.scene.contact);
    EXPECT_GT(t.scene.contact.work, before + 100);
    EXPECT_LT(t.scene.contact.work, before + 2 * SmoothSheet::kMaxWork);
  }
}

/** The friction cone turns with the normal: the part across it keeps its size. */
TEST(Shading, FrictionStaysWithinItsCone) {
  TestMesh mesh = test::sphereMesh(0.05, 8);
  Shaded t(mesh.view(), degrees(60), {1000, 0, 0.5, 0.4});
  t.at({0.06, 0, 0.004});
  for (int i = 0; i < 4000; ++i) {
    const double a = 1e-3 * i;
    t.at(Vec3(0.047 * std::cos(a), 0.047 * std::sin(a), 0.004));
    if (t.plain.norm() == 0) continue;
    ASSERT_NEAR(t.scene.contact.force.norm(), t.plain.norm(), 1e-12);
    const double along = t.plain.dot(t.scene.contact.normal);
    ASSERT_LE((t.plain - along * t.scene.contact.normal).norm(), 0.5 * along * (1 + 1e-9));
  }
}

}  // namespace
}  // namespace hapticd
