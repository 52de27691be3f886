// Local models from a mesh: the nearest point against all triangles, patches against the mesh they stand for.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <hapticclient/patch.hpp>
#include <limits>
#include <numbers>
#include <random>

#include "tests/support/seeds.h"

namespace haptic {
namespace {

using namespace detail;  // NOLINT(google-build-using-namespace)

struct Arrays {
  std::vector<float> vertices;
  std::vector<std::uint32_t> triangles;

  [[nodiscard]] SurfaceMesh mesh() const { return SurfaceMesh::make(vertices, triangles).value(); }
};

/** z = height(x, y) over |x|, |y| <= 1 cm, facing up, in square cells. */
constexpr int kFine = 40, kCoarse = 10;
template <class Height>
Arrays sheet(Height height, int cells = kFine) {
  Arrays a;
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      const double x = 0.02 * i / cells - 0.01, y = 0.02 * j / cells - 0.01;
      for (const double c : {x, y, height(x, y)}) a.vertices.push_back(static_cast<float>(c));
      if (i == cells || j == cells) continue;
      const auto at = static_cast<std::uint32_t>(i * (cells + 1) + j);
      const std::uint32_t right = at + cells + 1;
      a.triangles.insert(a.triangles.end(), {at, right, at + 1, right, right + 1, at + 1});
    }
  }
  return a;
}
constexpr double kRadius = 0.03;
double bulge(double x, double y) { return std::sqrt(kRadius * kRadius - x * x - y * y) - kRadius; }
double hollow(double x, double y) { return -bulge(x, y); }

haptic_local_model fit(const SurfaceMesh& mesh, const Vector& p, const Vector& v) {
  haptic_local_model model{};
  fitPatch(mesh, p, v, {0.005, 0.04, 1e-3}, model);
  return model;
}

/** Way out of a patch, its edges sharp. For a corner by the deepest plane: right to second order in their angles. */
Vector wayOut(const haptic_local_model& m, const Vector& x) {
  Vector best{};
  double depth = 0;
  for (std::uint32_t i = 0; i < m.count; ++i) {
    const Vector n{m.halfspace[i][0], m.halfspace[i][1], m.halfspace[i][2]};
    const double d = m.halfspace[i][3] - dot(n, x - Vector{m.origin[0], m.origin[1], m.origin[2]});
    if (i > 0 && (d < depth) != (m.kind == HAPTIC_MODEL_HALFSPACES)) continue;
    depth = d;
    best = std::max(0.0, d) * n;
  }
  return best;
}

TEST(SurfaceMesh, NearestIsTheNearestOfAllTriangles) {
  std::mt19937 random(hapticd::seedOf(1));
  std::uniform_real_distribution<double> in(-0.015, 0.015);
  const Arrays a = sheet([](double x, double y) { return 0.004 * std::sin(400 * x) * std::cos(300 * y); });
  const SurfaceMesh mesh = a.mesh();
  for (int n = 0; n < 300; ++n) {
    const Vector x{in(random), in(random), in(random)};
    double least = 1e300;
    for (std::size_t t = 0; t < a.triangles.size(); t += 3) {
      // Projected gradient on the barycentric triangle by its corners, edges and inside: every candidate there is.
      std::array<Vector, 3> c;
      for (std::size_t k = 0; k < 3; ++k) {
        const float* p = &a.vertices[3 * std::size_t{a.triangles[t + k]}];
        c[k] = {p[0], p[1], p[2]};
      }
      const Vector normal = cross(c[1] - c[0], c[2] - c[0]);
      const Vector inside = x - dot(x - c[0], normal) / dot(normal, normal) * normal;
      bool within = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector edge = c[(k + 1) % 3] - c[k];
        within = within && dot(cross(edge, inside - c[k]), normal) >= 0;
        const double part = std::clamp(dot(x - c[k], edge) / dot(edge, edge), 0.0, 1.0);
        least = std::min(least, length(x - (c[k] + part * edge)));
      }
      if (within) least = std::min(least, length(x - inside));
    }
    const SurfaceMesh::Foot foot = mesh.nearest(x);
    // Of places whose distances differ by a part in 1e9 the one that is faced most; those may follow on each other.
    ASSERT_NEAR(foot.distance, least, 3e-9 * least + 1e-15);
    ASSERT_NEAR(length(x - foot.point), foot.distance, 1e-12);
  }
}

TEST(SurfaceMesh, AboveIsPositiveOutsideAlsoBeyondEdgesAndCorners) {
  // A flat octahedron: beyond its sharp edges one of the two faces is seen from behind.
  const Arrays a{{0.01f, 0, 0, 0, 0.01f, 0, -0.01f, 0, 0, 0, -0.01f, 0, 0, 0, 0.001f, 0, 0, -0.001f},
                 {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5}};
  const SurfaceMesh mesh = a.mesh();
  std::mt19937 random(hapticd::seedOf(2));
  std::uniform_real_distribution<double> in(-0.02, 0.02);
  for (int n = 0; n < 3000; ++n) {
    const Vector x{in(random), in(random), 0.1 * in(random)};
    const bool outside = std::abs(x[0]) + std::abs(x[1]) + 10 * std::abs(x[2]) > 0.01;
    ASSERT_EQ(SurfaceMesh::above(mesh.nearest(x), x) > 0, outside);
  }
}

TEST(SurfaceMesh, RefusalsNameTheirPlace) {
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};
  EXPECT_EQ(SurfaceMesh::make(corners, std::vector<std::uint32_t>{0, 1, 3}).error().where, "triangle 0");
  EXPECT_EQ(SurfaceMesh::make(corners, std::vector<std::uint32_t>{0, 1, 1}).code(), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(SurfaceMesh::make(std::vector<float>{0, 0, 0, 1, NAN, 0}, {}).error().where, "vertex 1");
  EXPECT_EQ(SurfaceMesh::make(corners, std::vector<std::uint32_t>{0, 1, 2, 0}).error().where, "triangle 1");
  EXPECT_EQ(SurfaceMesh::make(std::vector<float>{0, 0, 0, 1}, {}).error().where, "vertex 1");
}

/** Largest difference, over the way of the hand and half a millimetre beside it, between patch and mesh [m]. */
double worstDifference(const SurfaceMesh& mesh, const haptic_local_model& m, const Vector& p, const Vector& v) {
  double worst = 0;
  for (double t = 0.005; t < 0.04; t += 0.001) {
    for (const double aside : {-5e-4, 0.0, 5e-4}) {
      const Vector y = p + t * v + Vector{0, aside, 0};
      const SurfaceMesh::Foot top = mesh.nearest(y);
      const Vector x = top.point - 1e-3 * top.normal;
      worst = std::max(worst, length(wayOut(m, x) - (mesh.nearest(x).point - x)));
    }
  }
  return worst;
}

constexpr double kFaceAngle = 0.02 / kFine * std::numbers::sqrt2 / kRadius;  ///< Between faces of the fine sheet.

TEST(Patch, IsTheMeshWhereItBulges) {
  const Vector p{-0.003, 0.0001, bulge(-0.003, 0) - 0.001}, v{0.06, 0, 0};  // 2.1 mm in 35 ms
  for (const int cells : {kCoarse, kFine}) {
    const SurfaceMesh mesh = sheet(bulge, cells).mesh();
    const haptic_local_model m = fit(mesh, p, v);
    EXPECT_EQ(m.kind, HAPTIC_MODEL_HALFSPACES);
    EXPECT_GT(m.count, 3u);
    // All faces that matter; of more than sixteen, a neighbour of the right one.
    EXPECT_LT(worstDifference(mesh, m, p, v), cells == kCoarse ? 1e-6 : 1.1e-3 * kFaceAngle);
  }
}

TEST(Patch, IsACornerWhereTheMeshIsHollow) {
  const SurfaceMesh mesh = sheet(hollow).mesh();
  const Vector p{-0.003, 0.0001, hollow(-0.003, 0) - 0.001}, v{0.06, 0, 0};
  const haptic_local_model m = fit(mesh, p, v);
  EXPECT_EQ(m.kind, HAPTIC_MODEL_CORNER);
  EXPECT_LT(worstDifference(mesh, m, p, v), 1.1e-3 * kFaceAngle);
}

TEST(Patch, FitsBetterThanAPlaneOnASaddleToo) {
  // Sixteen planes that all bulge or all sink: the other curvature is left to their middle.
  const SurfaceMesh mesh = sheet([](double x, double y) { return 10 * (x * x - y * y); }).mesh();
  const Vector p{-0.003, 0.001, -0.001}, v{0.1, 0.02, 0};
  haptic_local_model plane{};
  fitPlane(mesh, p, v, {0.005, 0.04, 1e-3}, plane);
  EXPECT_EQ(plane.kind, HAPTIC_MODEL_PLANE);
  plane.count = 1;
  for (std::size_t k = 0; k < 3; ++k) plane.halfspace[0][k] = static_cast<float>(plane.normal[k]);
  EXPECT_LT(worstDifference(mesh, fit(mesh, p, v), p, v), 0.8 * worstDifference(mesh, plane, p, v));
}

/** Whatever a program hands in, its own memory behind the model stays as it was. */
TEST(Patch, HasNeverMoreFacesThanAModelHasRoomFor) {
  const SurfaceMesh flat = sheet([](double, double) { return 0.0; }).mesh();
  const SurfaceMesh round = sheet(bulge).mesh();
  const double nan = std::numeric_limits<double>::quiet_NaN(), far = std::numeric_limits<double>::infinity();
  for (const SurfaceMesh* mesh : {&flat, &round}) {
    for (const double z : {0.001, 0.0, -0.001, nan, far}) {
      for (const double reach : {1e-3, 0.0, 1e-30, nan}) {
        for (const double speed : {0.0, 0.1, nan}) {
          struct {
            haptic_local_model model{};
            std::array<std::byte, 64> behind{};
          } memory;
          memory.behind.fill(std::byte{0x5a});
          const auto before = memory.behind;
          fitPatch(*mesh, {0.001, 0.002, z}, {speed, 0, 0}, {0.005, 0.04, reach}, memory.model);
          ASSERT_LE(memory.model.count, unsigned{HAPTIC_HALFSPACES}) << z << " " << reach << " " << speed;
          ASSERT_EQ(memory.behind, before);
        }
      }
    }
  }
}

TEST(Patch, ThatMayNotStrayIsStillThePlaneOfAFlatSheet) {
  haptic_local_model model{};
  fitPatch(sheet([](double, double) { return 0.0; }).mesh(), {0, 0, 0.001}, {0.1, 0, 0}, {0.005, 0.04, 0}, model);
  EXPECT_EQ(model.count, 1u);
  EXPECT_EQ(model.halfspace[0][2], 1.0f);
}

TEST(Patch, OfAFlatSheetIsItsPlane) {
  const haptic_local_model m = fit(sheet([](double, double) { return 0.002; }).mesh(), {0, 0, 0.001}, {0, 0, 0});
  EXPECT_EQ(m.count, 1u);
  EXPECT_NEAR(m.halfspace[0][2], 1, 1e-6);
  EXPECT_NEAR(m.origin[2] + m.halfspace[0][3], 0.002, 1e-7);
}

}  // namespace
}  // namespace haptic
