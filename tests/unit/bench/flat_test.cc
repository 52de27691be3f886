/** @file
 * Triangles without area: a stroke goes the same way over a mesh with them as over the mesh without.
 */
#include "tools/mesh_file/flat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "tests/support/seeds.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/shapes.h"
#include "tools/haptic-bench/trajectory/geodesic.h"

namespace haptic_bench {
namespace {

using hapticd_mesh_file::Triangle;
using ::testing::HasSubstr;

/** Closed, without symmetry, on a lattice so coarse that floats hold the eighths of its edges exactly. */
Model lattice() {
  Model m = sphere(0.05, 24);
  for (auto& v : m.vertices) {
    const float x = v[0], y = v[1], z = v[2];
    v = {1.4F * x + 3 * z * z, 0.8F * y + 4 * x * z, z + 5 * x * y};
    for (float& c : v) c = std::round(c * 0x1p13F) * 0x1p-13F;
  }
  return m;
}

Vec3 between(const Model& m, std::uint32_t a, std::uint32_t b, double share) {
  return m.vertex(a) + share * (m.vertex(b) - m.vertex(a));
}

/** The triangle that runs from a to b, turned so that it begins there. */
std::size_t turnTo(Model& m, std::uint32_t a, std::uint32_t b) {
  for (std::size_t t = 0; t < m.triangles.size(); ++t) {
    for (int turn = 0; turn < 3; ++turn) {
      Triangle& v = m.triangles[t];
      if (v[0] == a && v[1] == b) return t;
      std::rotate(v.begin(), v.begin() + 1, v.end());
    }
  }
  throw std::logic_error("no such edge");
}

/** The same surface twice: `plain` has areas everywhere, `flat` has triangles without. */
struct Pair {
  Model plain = lattice(), flat = plain;

  /** Three points on edge a b: in `plain` both sides meet them, in `flat` one side and three caps. */
  void cap(std::uint32_t a, std::uint32_t b) {
    std::array<std::uint32_t, 5> at{a, 0, 0, 0, b};
    for (std::uint32_t i = 1; i <= 3; ++i) {
      at[i] = plain.addVertex(between(plain, a, b, 0.25 * i));
      flat.addVertex(between(flat, a, b, 0.25 * i));
    }
    for (Model* m : {&plain, &flat}) split(*m, at);
    std::reverse(at.begin(), at.end());
    split(plain, at);
    // One over all, and two that stand on its sides.
    flat.triangles.push_back({a, b, at[2]});
    flat.triangles.push_back({a, at[2], at[3]});
    flat.triangles.push_back({at[2], b, at[1]});
  }

  /** Corner b of the triangle on the other side of a b becomes one of its own, at the same place. */
  void needle(std::uint32_t a, std::uint32_t b) {
    const std::size_t g = turnTo(flat, b, a);
    const std::uint32_t d = flat.triangles[g][2], other = flat.addVertex(flat.vertex(b));
    plain.addVertex(plain.vertex(b));
    flat.triangles[g][0] = other;
    flat.triangles.push_back({b, a, other});
    flat.triangles.push_back({other, d, b});
  }

 private:
  static void split(Model& m, const std::array<std::uint32_t, 5>& at) {
    const std::size_t f = turnTo(m, at[0], at[4]);
    const std::uint32_t c = m.triangles[f][2];
    for (std::size_t i = 0; i < 4; ++i) {
      const Triangle part{at[i], at[i + 1], c};
      if (i == 0) {
        m.triangles[f] = part;
      } else {
        m.triangles.push_back(part);
      }
    }
  }
};

/** Flat triangles at every second or so of the mesh's edges. */
Pair wild() {
  Pair p;
  std::mt19937 random(hapticd::seedOf(4));
  std::set<std::uint32_t> taken;  // Triangles that have been changed.
  const std::size_t whole = p.plain.triangles.size();
  for (int i = 0; i < 400; ++i) {
    const Triangle v = p.plain.triangles[random() % whole];
    const auto f = static_cast<std::uint32_t>(turnTo(p.plain, v[0], v[1]));
    const auto g = static_cast<std::uint32_t>(turnTo(p.plain, v[1], v[0]));
    if (f >= whole || g >= whole || !taken.insert(f).second || !taken.insert(g).second) continue;
    if (i % 2 == 0) {
      p.cap(v[0], v[1]);
    } else {
      p.needle(v[0], v[1]);
    }
  }
  p.flat.triangles.push_back({5, 5, 9});
  p.flat.triangles.push_back({7, 7, 7});
  return p;
}

Model withoutFlatTriangles(Model m) {
  m.triangles = hapticd_mesh_file::withoutFlatTriangles(m.vertices, std::move(m.triangles));
  return m;
}

std::size_t flatOf(const Model& m) {
  std::size_t n = 0;
  for (std::uint32_t t = 0; t < m.triangles.size(); ++t)
    n += hapticd_mesh_file::isFlat(m.vertices, m.triangles[t]) ? 1 : 0;
  return n;
}

TEST(FlatTriangles, LeaveTheWayAndItsNormalsAsTheyAre) {
  const Pair p = wild();
  ASSERT_EQ(flatOf(p.plain), 0u);
  ASSERT_GT(flatOf(p.flat), 200u);
  for (const double azimuth : {0.9, 2.0, 4.4}) {
    const Pace pace{8, 500, 1};
    const auto plain = geodesic(p.plain, pace, 0.15, azimuth, Vec3(0, 0.01, 1));
    const auto flat = geodesic(p.flat, pace, 0.15, azimuth, Vec3(0, 0.01, 1));
    ASSERT_EQ(plain.size(), flat.size());
    for (std::size_t i = 0; i < plain.size(); ++i) {
      ASSERT_LT((plain[i].point - flat[i].point).norm(), 1e-9) << azimuth << " at " << plain[i].t_s << " s";
      ASSERT_LT((plain[i].normal - flat[i].normal).norm(), 1e-9) << azimuth << " at " << plain[i].t_s << " s";
    }
  }
}

TEST(FlatTriangles, GoAndTheSurfaceStaysClosed) {
  const Pair p = wild();
  const Model mended = withoutFlatTriangles(p.flat);
  EXPECT_EQ(flatOf(mended), 0u);
  EXPECT_EQ(mended.triangles.size(), p.plain.triangles.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  double area = 0, plain_area = 0;
  for (std::uint32_t t = 0; t < mended.triangles.size(); ++t) {
    const Triangle& v = mended.triangles[t];
    for (std::size_t c = 0; c < 3; ++c) ++edges[{v[c], v[(c + 1) % 3]}];
    area += (mended.corner(t, 1) - mended.corner(t, 0)).cross(mended.corner(t, 2) - mended.corner(t, 0)).norm();
  }
  for (std::uint32_t t = 0; t < p.plain.triangles.size(); ++t) {
    const Vec3 a = p.plain.corner(t, 0);
    plain_area += (p.plain.corner(t, 1) - a).cross(p.plain.corner(t, 2) - a).norm();
  }
  EXPECT_NEAR(area, plain_area, 1e-9 * plain_area);
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
  }
}

TEST(FlatTriangles, AmidAPlaneLeaveTheWayStraight) {
  Model m = plane(0.05, 1);
  m.addVertex({0, 0, 0});  // Amid the diagonal: between the halves lies a triangle without area.
  m.triangles = {{0, 1, 3}, {0, 3, 4}, {4, 3, 2}, {0, 4, 2}};
  const auto line = geodesic(m, {1, 1000, 1}, 0.05, 2.0, Vec3(0.05, -0.05, 0));
  for (const SurfaceSample& s : line) {
    ASSERT_NEAR((s.point - line.front().point - 0.05 * s.t_s * Vec3(std::cos(2), std::sin(2), 0)).norm(), 0, 1e-7);
    ASSERT_NEAR(s.normal.z(), 1, 1e-12);
  }
}

TEST(FlatTriangles, AtTheBorderTurnTheWayBackAsTheBorderDoes) {
  Model m = plane(0.05, 1);
  const std::uint32_t amid = m.addVertex(between(m, 0, 1, 0.5));
  const auto way = [&m](std::vector<Triangle> triangles) {
    m.triangles = std::move(triangles);
    return geodesic(m, {3, 1000, 1}, 0.1, 2.0, Vec3(-0.05, 0.05, 0));
  };
  const auto plain = way({{0, 3, 2}, {0, amid, 3}, {amid, 1, 3}});
  for (const auto& flat : {way({{0, 3, 2}, {0, amid, 3}, {amid, 1, 3}, {amid, 0, 1}}),  // Its longest side is a border,
                           way({{0, 3, 2}, {0, 1, 3}, {1, 0, amid}})}) {                // or the two others are.
    for (std::size_t i = 0; i < plain.size(); ++i) ASSERT_LT((plain[i].point - flat[i].point).norm(), 1e-9);
  }
}

std::string fault(const Model& m) {
  try {
    (void)geodesic(m, {2, 1000, 1}, 0.1, 2.0, Vec3(0.05, -0.05, 0));
  } catch (const Failure& failure) {
    return failure.what();
  }
  return {};
}

TEST(FlatTriangles, ThatCannotBeMendedAreToldWithTheirPlace) {
  Model m = plane(0.05, 1);
  m.addVertex({0, 0, 0});
  m.addVertex({0, 0, 0.01});
  m.triangles = {{0, 1, 3}, {0, 3, 4}, {4, 3, 2}, {0, 4, 2}, {4, 1, 5}};  // The edge 4 1 belongs to a fin.
  EXPECT_EQ(flatOf(withoutFlatTriangles(m)), 1u);
  EXPECT_THAT(fault(m), HasSubstr("cannot be mended"));
  m.triangles = {{0, 3, 4}, {0, 0, 1}};
  EXPECT_THAT(fault(m), HasSubstr("no triangle has an area"));
}

TEST(FlatTriangles, OfAnySoupAreMendedInBoundedTime) {
  std::mt19937 random(hapticd::seedOf(9));
  for (int round = 0; round < 2000; ++round) {
    Model m;
    const auto side = static_cast<int>(2 + random() % 3);
    const auto vertices = static_cast<std::uint32_t>(3 + random() % 12);
    const auto place = [&](int most) { return static_cast<double>(random() % static_cast<unsigned>(most)); };
    for (std::uint32_t v = 0; v < vertices; ++v)
      m.addVertex(Vec3(place(side), place(side), place(2)));  // Many in one place, many in a line.
    const auto any = [&] { return static_cast<std::uint32_t>(random() % vertices); };
    for (auto t = random() % 40; t > 0; --t) m.triangles.push_back({any(), any(), any()});
    const Model mended = withoutFlatTriangles(m);
    EXPECT_LE(mended.triangles.size(), m.triangles.size());
    for (const Triangle& v : mended.triangles) EXPECT_LT(std::max({v[0], v[1], v[2]}), vertices);
  }
}

}  // namespace
}  // namespace haptic_bench
