/** @file
 * Triangles so thin that products of lengths tell nothing of their plane: against integers, long doubles, a box.
 */
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "rt/geometry/nearest/nearest.h"
#include "rt/geometry/triangle.h"
#include "tests/support/random.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

using test::TestMesh;

constexpr double kGrid = 0x1p-26;  // Corners lie on it, up to 2^-4 m: floats, and whole numbers for the oracle.

using Whole = std::array<std::int64_t, 3>;

Vec3 real(const Whole& x) { return kGrid * Vec3(double(x[0]), double(x[1]), double(x[2])); }
Whole minus(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/** Two corners anywhere, the third a few steps of the grid beside their edge. */
std::array<Whole, 3> needle(Random& random) {
  const auto any = [&] { return static_cast<std::int64_t>(random.in(-0x1p22, 0x1p22)); };
  const Whole a{any(), any(), any()}, b{any(), any(), any()};
  const double part = random.in(0, 1);
  Whole c{};
  for (int i = 0; i < 3; ++i) c[i] = std::llround(double(a[i]) + part * double(b[i] - a[i])) + random.below(7) - 3;
  switch (random.below(3)) {  // Each of them may be the first.
    case 0:
      return {a, b, c};
    case 1:
      return {c, a, b};
    default:
      return {b, c, a};
  }
}

Corners corners(const std::array<Whole, 3>& v) { return {real(v[0]), real(v[1]), real(v[2])}; }

/** Of whole numbers: nothing is rounded before the end. */
Vec3 exactNormal(const std::array<Whole, 3>& v) {
  const Whole e = minus(v[1], v[0]), f = minus(v[2], v[0]);
  Vec3 n;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    n[i] = static_cast<double>(e[j] * f[k] - e[k] * f[j]);  // Below 2^48.
  }
  return n.normalized();
}

TEST(Needle, ItsNormalIsThatOfWholeNumbers) {
  Random random(1);
  double worst = 0, worst_plain = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto v = needle(random);
    const Vec3 exact = exactNormal(v);
    if (!(exact.norm() > 0.5)) continue;  // In one line.
    // Somewhere else than on a grid, as rounding sees it: the edges are the same.
    const Vec3 e = real(minus(v[1], v[0])) * 1.1, f = real(minus(v[2], v[0])) * 1.1;
    worst = std::max(worst, (corners(v).normal().normalized() - exact).norm());
    worst_plain = std::max(worst_plain, (e.cross(f).normalized() - areaVector(e, f).normalized()).norm());
  }
  EXPECT_LT(worst, 1e-15);
  EXPECT_GT(worst_plain, 1e-10);  // So much a plain cross product loses.
}

/** Distance by edges and, over the inside, the plane, in long doubles. */
long double exactDistance(const std::array<Whole, 3>& v, const Vec3& x) {
  using Long = Eigen::Matrix<long double, 3, 1>;
  const auto at = [&](int k) { return Long(real(v[static_cast<std::size_t>(k % 3)]).cast<long double>()); };
  const Long p = x.cast<long double>(), n = exactNormal(v).cast<long double>();
  bool over = true;
  long double least = HUGE_VALL;
  for (int k = 0; k < 3; ++k) {
    const Long along = at(k + 1) - at(k), away = p - at(k);
    const long double t = std::clamp(along.dot(away) / along.squaredNorm(), 0.0L, 1.0L);
    least = std::min(least, (away - t * along).norm());
    over = over && along.cross(away).dot(n) >= 0;
  }
  return over ? std::abs(n.dot(p - at(0))) : least;
}

TEST(Needle, ItsNearestPointIsOnItAndNoneIsNearer) {
  Random random(2);
  int on_face = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto v = needle(random);
    if (!(exactNormal(v).norm() > 0.5)) continue;
    // Near it, by very little or much.
    const double part = random.in(-0.1, 1.1), third = random.in(-0.1, 1.1) * (1 - part);
    Vec3 x = part * real(v[0]) + third * real(v[1]) + (1 - part - third) * real(v[2]);
    const double far = std::pow(10, random.in(-11, -2));
    x += far * (random.once(2) ? exactNormal(v) : random.vector(1));
    const TriangleFoot foot = nearestOnTriangle(corners(v), x);
    on_face += foot.kind == FeatureKind::kFace;
    const double exact = static_cast<double>(exactDistance(v, x));
    ASSERT_NEAR((x - foot.point).norm(), exact, 1e-16 + 1e-14 * exact) << i;
    ASSERT_LT(static_cast<double>(exactDistance(v, foot.point)), 3e-17) << i;
  }
  EXPECT_GT(on_face, 100);
}

/**
 * A box, of each of whose faces' edges a corner more lies on it, but for rounding to floats: the triangle between the
 * edge and its two parts faces any way.
 */
TestMesh stitchedBox(const Vec3& half, Random& random) {
  TestMesh mesh = test::boxMesh(half);
  const auto faces = static_cast<std::uint32_t>(mesh.triangles.size());
  for (std::uint32_t f = 0; f < faces; ++f) {
    const auto [a, b, c] = mesh.triangles[f];
    const auto at = [&](std::uint32_t k) {
      return Vec3(mesh.vertices[k][0], mesh.vertices[k][1], mesh.vertices[k][2]);
    };
    const double part = random.in(0.1, 0.9);
    const std::uint32_t middle = mesh.addVertex((1 - part) * at(a) + part * at(b));
    for (float& x : mesh.vertices[middle]) {
      for (int steps = random.below(3) - 1; steps != 0; steps = 0) x = std::nextafter(x, steps > 0 ? 1.0F : -1.0F);
    }
    mesh.triangles[f] = {a, middle, c};
    mesh.addTriangle(middle, b, c);
    mesh.addTriangle(a, b, middle);
  }
  return mesh;
}

TEST(Needle, BetweenStitchedEdgesTellsNoSide) {
  Random random(3);
  int on_edge = 0;
  for (int run = 0; run < 50; ++run) {
    const Vec3 half{random.in(0.01, 0.05), random.in(0.01, 0.05), random.in(0.01, 0.05)};
    TestMesh mesh = stitchedBox(half, random);
    const MeshView& view = *mesh.view();
    const Shape box{ShapeKind::kBox, half};
    for (int i = 0; i < 400; ++i) {
      NearestQuery query;
      query.x = random.vector(0.06);
      query.limit = 1u << 30;
      if (std::abs(test::distanceTo(box, query.x)) < 1e-6) continue;
      Nearest nearest;
      ASSERT_EQ(nearestOnMesh(view, query, nearest), NearestResult::kFound);
      on_edge += nearest.kind == FeatureKind::kEdge;
      ASSERT_EQ(nearest.isInside(query.x), test::distanceTo(box, query.x) < 0) << run << " " << query.x.transpose();
    }
  }
  EXPECT_GT(on_edge, 1000);
}

/** Whether x is inside a closed mesh: its solid angle (van Oosterom and Strackee 1983). */
bool isWithin(const TestMesh& mesh, const Vec3& x) {
  const auto at = [&](std::uint32_t v) { return Vec3(mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2]); };
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = at(t[0]) - x, b = at(t[1]) - x, c = at(t[2]) - x;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum > 2 * M_PI;
}

/** A vertex in an edge, a few steps of the floats from one of its ends: the two triangles there become needles. */
void splitNearEnd(TestMesh& mesh, std::uint32_t a, std::uint32_t b, double part) {
  const auto at = [&](std::uint32_t v) { return Vec3(mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2]); };
  const std::uint32_t n = mesh.addVertex(at(a) + part * (at(b) - at(a)));
  if (mesh.vertices[n] == mesh.vertices[a]) return;
  for (std::size_t t = 0, count = mesh.triangles.size(); t < count; ++t) {
    for (int e = 0; e < 3; ++e) {
      const auto v = mesh.triangles[t];
      const std::uint32_t from = v[e], to = v[(e + 1) % 3], third = v[(e + 2) % 3];
      if (std::minmax(from, to) != std::minmax(a, b)) continue;
      mesh.triangles[t] = {from, n, third};
      mesh.addTriangle(n, to, third);
      break;
    }
  }
}

/** If a vertex of the mesh is nearest to x: it tells x inside where x is within `whole`, the mesh without needles. */
void sideAboutAVertex(const MeshView& mesh, const TestMesh& whole, const Vec3& x, int& asked) {
  NearestQuery query;
  query.x = x;
  query.limit = 100'000;
  Nearest near;
  ASSERT_EQ(nearestOnMesh(mesh, query, near), NearestResult::kFound);
  if (near.kind != FeatureKind::kVertex) return;
  ++asked;
  EXPECT_EQ(near.isInside(x), isWithin(whole, x)) << x.transpose();
}

/** What lies beyond a needle has its say about a vertex in the needle's place, at the needle's angle there. */
TEST(Needle, AboutAVertexDoesNotHideWhatLiesBeyond) {
  int asked = 0;
  std::vector<unsigned> all = seeds(200);
  all.push_back(5063);  // Of a soak: needles as wide as four floats that were not heard.
  for (const unsigned seed : all) {
    SCOPED_TRACE("HAPTICD_SEED=" + std::to_string(seed));
    Random random(seed);
    std::mt19937 engine(seed);
    TestMesh whole = test::crumpled(engine, 5);
    const Vec3 far = random.vector(0.3);
    for (auto& v : whole.vertices)
      for (int k = 0; k < 3; ++k) v[k] = static_cast<float>(0.01 * v[k] + far[k]);
    TestMesh split = whole;
    for (int i = 0; i < 12; ++i) {
      const auto& t = whole.triangles[random.below(static_cast<std::uint32_t>(whole.triangles.size()))];
      splitNearEnd(split, t[0], t[1], 3e-5 * random.in(0.3, 1));
    }
    const MeshView& mesh = *split.view();
    for (int i = 0; i < 400; ++i) sideAboutAVertex(mesh, whole, far + random.vector(0.02), asked);
    if (HasFailure()) return;
  }
  EXPECT_GT(asked, 1000);
}

/** Between a vertex and its double lie two triangles without area, about one that has some: it counts once. */
TEST(Needle, AboutADoubledVertexEachSheetCountsOnce) {
  int asked = 0;
  for (const unsigned seed : seeds(200)) {
    SCOPED_TRACE("HAPTICD_SEED=" + std::to_string(seed));
    Random random(seed);
    std::mt19937 engine(seed);
    const TestMesh whole = test::crumpled(engine, 5);
    TestMesh doubled = whole;
    for (std::size_t f = 0; f < whole.triangles.size(); ++f) {
      if (!random.once(4)) continue;
      const auto t = whole.triangles[f];
      const std::uint32_t twin =
          doubled.addVertex({doubled.vertices[t[0]][0], doubled.vertices[t[0]][1], doubled.vertices[t[0]][2]});
      doubled.triangles[f] = {t[0], twin, t[2]};
      doubled.addTriangle(twin, t[1], t[2]);
      doubled.addTriangle(t[0], t[1], twin);
    }
    const MeshView& mesh = *doubled.view();
    for (int i = 0; i < 100; ++i) sideAboutAVertex(mesh, whole, random.vector(2), asked);
    if (HasFailure()) return;
  }
  EXPECT_GT(asked, 1000);
}

}  // namespace
}  // namespace hapticd
