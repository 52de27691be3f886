// What is true of shading's energy: docs/surfaces.md, "Round facets".
#include <gtest/gtest.h>

#include <numbers>

#include "rt/render/surface/shading.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

constexpr double kShadedStiffness = 1000, kRadius = 0.02;
constexpr int kSides = 12;
constexpr double kHalfAngle = std::numbers::pi / kSides;  // Between a facet's normal and those at its ends.

/** A long prism about z, without lids: each facet is flat along z and shaded round across it. */
test::TestMesh prism() {
  test::TestMesh mesh;
  std::vector<std::uint32_t> low, high;
  for (int i = 0; i < kSides; ++i) {
    const double a = (2 * i - 1) * kHalfAngle;  // The facet 0 faces +x.
    low.push_back(mesh.addVertex({kRadius * std::cos(a), kRadius * std::sin(a), -1}));
    high.push_back(mesh.addVertex({kRadius * std::cos(a), kRadius * std::sin(a), 1}));
  }
  for (std::size_t i = 0; i < kSides; ++i) {
    const std::size_t k = (i + 1) % kSides;
    mesh.addQuad(low[i], low[k], high[k], high[i]);
  }
  return mesh;
}

/** Work of the shaded force on a hand that goes round the corners, in small steps. */
double workAround(MeshView* mesh, const std::vector<Vec3>& corners) {
  test::TestScene t;
  const std::uint32_t id = t.addMesh(mesh, {}, {kShadedStiffness, 0, 0, 0});
  SurfaceParameters surface{};
  surface.smooth_cosine = std::cos(1.0);
  EXPECT_EQ(t.setSurface(id, surface), ErrorCode::kOk);
  t.tick(corners.front() + Vec3(0.01, 0, 0));
  Shading shading;
  double work = 0;
  Vec3 last_x = corners.front(), last_f = Vec3::Zero();
  constexpr int kSteps = 400;
  for (std::size_t c = 0; c < corners.size(); ++c) {
    for (int i = 0; i <= kSteps; ++i) {
      const Vec3 x = corners[c] + (corners[(c + 1) % corners.size()] - corners[c]) * i / kSteps;
      t.tick(x);
      shading.step(*t.scene, t.proxy.holding(), Vec3::Zero(), t.contact);
      if (c > 0 || i > 0) work += 0.5 * (t.contact.force + last_f).dot(x - last_x);
      last_x = x;
      last_f = t.contact.force;
    }
  }
  return work;
}

double facet() { return kRadius * std::cos(kHalfAngle); }      // Its place along x.
double width() { return 2 * kRadius * std::sin(kHalfAngle); }  // Along y.

TEST(ShadingProperty, ATourGainsNoMoreThanItsBound) {
  test::TestMesh mesh = prism();
  MeshView* view = mesh.view();
  for (const unsigned seed : seeds(20)) {
    Random random(seed);
    const double shallow = random.in(1e-4, 1e-3), deep = shallow + random.in(1e-4, 1e-3);
    const double reach = random.in(0.1, 0.42) * width(), z = random.in(-0.5, 0.5);
    // Out at one depth, back at the other, both ways round.
    const std::vector<Vec3> way = {
        {facet() - deep, 0, z}, {facet() - deep, reach, z}, {facet() - shallow, reach, z}, {facet() - shallow, 0, z}};
    const double there = workAround(view, way), back = workAround(view, {way[0], way[3], way[2], way[1]});
    const double bound = kShadedStiffness * (deep - shallow) * width() * std::sin(kHalfAngle) / 4;
    EXPECT_LE(there, bound) << seed;
    EXPECT_LE(back, bound) << seed;
    EXPECT_NEAR(there + back, 0, 1e-3 * bound) << "backwards it costs what it gave " << seed;
  }
}

/** The bound is no empty one: 84 % of the way to the edge a tour gains 70 % of it, less what the normal takes. */
TEST(ShadingProperty, TheBoundIsNoEmptyOne) {
  test::TestMesh mesh = prism();
  const double deep = 1e-3, shallow = 0.5e-3, reach = 0.42 * width();
  const double gained = workAround(
      mesh.view(),
      {{facet() - deep, 0, 0}, {facet() - deep, reach, 0}, {facet() - shallow, reach, 0}, {facet() - shallow, 0, 0}});
  const double bound = kShadedStiffness * (deep - shallow) * width() * std::sin(kHalfAngle) / 4;
  EXPECT_GT(gained, 0.6 * bound);
}

/** At one depth, to and fro over a facet, nothing is gained or lost. */
TEST(ShadingProperty, AtOneDepthNothingIsGained) {
  test::TestMesh mesh = prism();
  const double x = facet() - 8e-4;
  const double gained =
      workAround(mesh.view(), {{x, -0.4 * width(), 0}, {x, 0.45 * width(), 0.1}, {x, 0.1 * width(), 0.3}});
  EXPECT_NEAR(gained, 0, 1e-9);
}

/** Work on a hand that goes to and fro over a facet while it goes up and down, in a closed loop; b damps. */
double workOfLoop(MeshView* mesh, double b, double up, double rate) {
  test::TestScene t;
  const std::uint32_t id = t.addMesh(mesh, {}, {kShadedStiffness, b, 0, 0});
  SurfaceParameters surface{};
  surface.smooth_cosine = std::cos(1.0);
  EXPECT_EQ(t.setSurface(id, surface), ErrorCode::kOk);
  t.tick({facet() + 0.01, 0, 0});
  Shading shading;
  double work = 0;
  constexpr int kSteps = 4000;
  constexpr double kRound = 2 * std::numbers::pi;
  for (int i = 0; i < kSteps; ++i) {
    const double p = kRound * i / kSteps;
    const Vec3 x(facet() - 1e-3 + up * std::cos(2 * p), 0.42 * width() * std::sin(p), 0);
    const Vec3 v = rate * Vec3(-2 * up * std::sin(2 * p), 0.42 * width() * std::cos(p), 0);
    t.tick(x, v);
    shading.step(*t.scene, t.proxy.holding(), v, t.contact);
    work += t.contact.force.dot(v) * kRound / kSteps / rate;
  }
  return work;
}

/** Sliding turns the one into the other: damping of the facet's normal, turned, would give energy one way round. */
TEST(ShadingProperty, DampingTakesWhereItIsTurned) {
  test::TestMesh mesh = prism();
  MeshView* view = mesh.view();
  for (const double up : {-3e-4, -1e-4, 1e-4, 3e-4}) {
    for (const double rate : {10.0, 60.0}) {
      EXPECT_NEAR(workOfLoop(view, 0, up, rate), 0, 1e-9);
      for (const double b : {1.0, 5.0, 30.0})
        EXPECT_LT(workOfLoop(view, b, up, rate), 0) << b << " " << up << " " << rate;
    }
  }
}

}  // namespace
}  // namespace hapticd
