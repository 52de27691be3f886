// Cracks: edges cut on one side only.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "rt/geometry/nearest/nearest.h"
#include "rt/geometry/sweep/sweep.h"
#include "tests/support/random.h"
#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/** Cuts an edge of some triangles, on their side only, once or more often. */
UploadMesh cracked(const UploadMesh& whole, Random& random, double often) {
  UploadMesh mesh = whole;
  for (std::uint32_t f = 0; f < whole.triangles.size(); ++f) {
    if (!random.once(often)) continue;
    Index3 t = whole.triangles[f];
    std::rotate(t.begin(), t.begin() + random.below(3u), t.end());
    const std::uint32_t count = 1 + random.below(3u);
    std::uint32_t from = t[0];
    for (std::uint32_t i = 1; i <= count; ++i) {
      const double part = (i + random.in(-0.4, 0.4)) / (count + 1);
      Float3 p;
      for (int k = 0; k < 3; ++k)
        p[k] = static_cast<float>((1 - part) * whole.vertices[t[0]][k] + part * whole.vertices[t[1]][k]);
      const auto mid = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(p);
      if (i == 1) {
        mesh.triangles[f] = {from, mid, t[2]};
      } else {
        mesh.triangles.push_back({from, mid, t[2]});
      }
      from = mid;
    }
    mesh.triangles.push_back({from, t[1], t[2]});
  }
  return mesh;
}

TEST(Stitch, WhatItLeavesNothingOfIsRefused) {
  UploadMesh far;  // Ends within what rounding leaves of them become one.
  const float step = 0x1p-17f;
  far.vertices = {{99, 0, 0}, {99 + step, 0, 0}, {99, step, 0}};
  far.triangles = {{0, 1, 2}};
  EXPECT_EQ(refusal(far).code, ErrorCode::kBadMesh);
  EXPECT_EQ(refusal(far, HD_MESH_DEFORMABLE).code, ErrorCode::kBadMesh);
}

TEST(Stitch, ASheetWhoseSidesAreCutOtherwiseStays) {
  UploadMesh sheet;  // Below, the first triangle of the upper side is two.
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5f, 0, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 2, 4}, {4, 2, 1}, {0, 3, 2}};
  for (const std::size_t parts : {5u, 1u}) {  // The whole of it, and that triangle alone.
    if (parts == 1) sheet.triangles = {{0, 1, 2}, {0, 2, 4}, {4, 2, 1}};
    const Built built = build(sheet);
    const MeshView& view = built.memory.view;
    double area = 0;
    for (std::uint32_t t = 0; t < view.triangle_count; ++t)
      area += (view.vertex(t, 1) - view.vertex(t, 0)).cross(view.vertex(t, 2) - view.vertex(t, 0)).norm() / 2;
    EXPECT_NEAR(area, parts == 1 ? 0.5 : 1, 1e-6);
  }
}

/** A sheet of one side or two, or triangles through one another. */
UploadMesh anything(Random& random) {
  UploadMesh mesh;
  const auto count = 1 + random.below(5u);
  const bool sheet = random.once(2);
  for (std::uint32_t i = 0; i < (count + 1) * (count + 1); ++i) {
    if (sheet) {
      mesh.vertices.push_back({static_cast<float>(i % (count + 1)), static_cast<float>(i / (count + 1)), 0});
    } else {
      for (float& x : mesh.vertices.emplace_back()) x = static_cast<float>(random.below(5));
    }
  }
  const auto vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::uint32_t i = 0; sheet && i + count + 2 < vertices; ++i) {
    if (i % (count + 1) == count) continue;
    mesh.triangles.push_back({i, i + 1, i + count + 2});
    mesh.triangles.push_back({i, i + count + 2, i + count + 1});
  }
  for (std::uint32_t i = 0; !sheet && i < 4 * vertices; ++i)
    mesh.triangles.push_back({random.below(vertices), random.below(vertices), random.below(vertices)});
  if (const auto one_side = mesh.triangles; sheet && random.once(2))
    for (const Index3& t : one_side) mesh.triangles.push_back({t[0], t[2], t[1]});
  return mesh;
}

bool hasArea(const UploadMesh& mesh) {
  return std::ranges::any_of(mesh.triangles, [&](const Index3& t) {
    Vec3 p[3];
    for (int c = 0; c < 3; ++c) p[c] = Vec3(mesh.vertices[t[c]][0], mesh.vertices[t[c]][1], mesh.vertices[t[c]][2]);
    return (p[1] - p[0]).cross(p[2] - p[0]).norm() > 1e-2;
  });
}

TEST(Stitch, NoPlaceOfASurfaceIsLost) {
  for (const unsigned seed : seeds(300)) {
    SCOPED_TRACE("HAPTICD_SEED=" + std::to_string(seed));
    Random random(seed);
    const UploadMesh mesh = cracked(anything(random), random, random.in(1, 5));
    BuildMonitor monitor;
    const auto snapshot = buildSnapshot(upload(mesh), monitor);
    if (!snapshot) {
      EXPECT_EQ(snapshot.error().code, ErrorCode::kBadMesh);
      EXPECT_FALSE(hasArea(mesh)) << toString(snapshot.error());
      continue;
    }
    const auto opened = openSnapshot(std::move(*snapshot->memfd.share()), false);
    ASSERT_TRUE(opened.ok());
    for (const Index3& t : mesh.triangles) {
      Vec3 p[3];
      for (int c = 0; c < 3; ++c) p[c] = Vec3(mesh.vertices[t[c]][0], mesh.vertices[t[c]][1], mesh.vertices[t[c]][2]);
      if ((p[1] - p[0]).cross(p[2] - p[0]).norm() < 1e-2) continue;
      const double u = random.in(0, 1), v = random.in(0, 1 - u);
      NearestQuery query;
      query.x = p[0] + u * (p[1] - p[0]) + v * (p[2] - p[0]);
      query.reach = 1;
      query.limit = 100'000;
      Nearest nearest;
      ASSERT_EQ(nearestOnMesh(opened->view, query, nearest), NearestResult::kFound);
      EXPECT_LT(std::sqrt(nearest.squared_distance), 1e-3);
    }
  }
}

TEST(Stitch, ClosesWhatWasCutOnOneSide) {
  for (const unsigned seed : seeds(20)) {
    SCOPED_TRACE("HAPTICD_SEED=" + std::to_string(seed));
    Random random(seed);
    const UploadMesh whole = torus(8 + random.below(20u), 5 + random.below(10u));
    const double volume = signedVolume(build(whole).memory.view);
    const UploadMesh mesh = cracked(whole, random, random.in(1, 6));
    const Built built = build(random.once(2) ? mesh : mesh.soup());
    EXPECT_NE(built.stats.flags & HD_MESH_CLOSED, 0u);
    EXPECT_NEAR(signedVolume(built.memory.view), volume, 1e-6 * volume);
    // Into the torus, through its edges, where the cracks were.
    for (int i = 0; i < 500; ++i) {
      const Index3& t = whole.triangles[random.below(static_cast<std::uint32_t>(whole.triangles.size()))];
      const double part = random.in(0, 1);
      Vec3 x;
      for (int k = 0; k < 3; ++k) x[k] = (1 - part) * whole.vertices[t[0]][k] + part * whole.vertices[t[1]][k];
      const Vec3 core = 0.05 * Vec3(x.x(), x.y(), 0).normalized();
      Sweep sweep;
      sweep.a = core + 2 * (x - core);
      sweep.d = core - sweep.a;
      sweep.limit = 100'000;
      SweepHit hit;
      ASSERT_EQ(sweepMesh(built.memory.view, sweep, hit), SweepResult::kHit) << i;
    }
  }
}

/** As a program writes it that keeps six digits. */
double inSixDigits(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return std::strtod(text, nullptr);
}

/** A turned box whose faces were meshed one by one: each edge has vertices of its own for either side. */
UploadMesh boxOfSixMeshes(Random& random, const Vec3& half, const Vec3& middle, bool in_six_digits) {
  const Quat turn = Quat(random.in(-1, 1), random.in(-1, 1), random.in(-1, 1), random.in(-1, 1)).normalized();
  UploadMesh mesh;
  const auto add = [&](const Vec3& p) {
    const Vec3 x = turn * p + middle;
    Float3 at;
    for (int k = 0; k < 3; ++k) at[k] = static_cast<float>(in_six_digits ? inSixDigits(x[k]) : x[k]);
    mesh.vertices.push_back(at);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  };
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, sign = face % 2 == 0 ? 1 : -1;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    if (sign < 0) std::swap(u, v);
    const auto at = [&](double x, double y) {
      Vec3 p;
      p[axis] = sign * half[axis], p[u] = x * half[u], p[v] = y * half[v];
      return p;
    };
    const Vec3 corner[4] = {at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)};
    std::vector<std::uint32_t> rim;
    for (std::size_t i = 0; i < 4; ++i) {
      rim.push_back(add(corner[i]));
      std::vector<double> parts(random.below(4u));
      for (double& part : parts) part = random.in(0, 1);
      std::sort(parts.begin(), parts.end());
      for (const double part : parts) rim.push_back(add(corner[i] + part * (corner[(i + 1) % 4] - corner[i])));
    }
    const std::uint32_t hub = add(at(random.in(-1, 1), random.in(-1, 1)));
    for (std::size_t i = 0; i < rim.size(); ++i) mesh.triangles.push_back({rim[i], rim[(i + 1) % rim.size()], hub});
  }
  return mesh;
}

// Open were: of the thin ones far away 13 %, of those in six digits all but 0.1 %.
TEST(Stitch, FacesThatWereMeshedOneByOneAreASolid) {
  for (const unsigned seed : seeds(200)) {
    SCOPED_TRACE("HAPTICD_SEED=" + std::to_string(seed));
    for (const bool in_six_digits : {false, true}) {
      Random random(seed);
      const double ratio = in_six_digits ? 10 : 1000;
      Vec3 half, middle = Vec3::Zero();
      for (int k = 0; k < 3; ++k) half[k] = 0.05 * std::pow(ratio, -random.in(0, 1));
      if (!in_six_digits) middle = Vec3(random.in(-1, 1), random.in(-1, 1), random.in(-1, 1));
      const Built built = build(boxOfSixMeshes(random, half, middle, in_six_digits));
      EXPECT_NE(built.stats.flags & HD_MESH_CLOSED, 0u) << in_six_digits;
      EXPECT_NEAR(signedVolume(built.memory.view) / (8 * half.prod()), 1, 2e-3) << in_six_digits;
    }
  }
}

/** A needle in a face, two edges of which the same vertex cuts on their other sides: it has no inside left there. */
TEST(Stitch, AVertexOnTwoEdgesOfANeedleCutsBoth) {
  UploadMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1e-3F, 2e-6F, 0}, {0.5F, 5e-7F, 0}};
  // A tetrahedron; its bottom holds a vertex by the edge along x, whose middle cuts this edge and that of the needle.
  mesh.triangles = {{1, 3, 5}, {5, 3, 0}, {1, 2, 3}, {0, 3, 2}, {0, 4, 1}, {0, 2, 4}, {4, 2, 5}, {5, 2, 1}};
  const Built built = build(mesh);
  EXPECT_NE(built.stats.flags & HD_MESH_CLOSED, 0u);
  EXPECT_NEAR(signedVolume(built.memory.view), 1.0 / 6, 1e-6);
}

/** Its two sides would be those of a solid that has no inside. */
TEST(Stitch, ATriangleThatIsThereTwiceButForRoundingStaysOpen) {
  UploadMesh mesh = cube();
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const float x : {5.1F, std::nextafter(5.1F, 6.0F)}) {
    mesh.vertices.insert(mesh.vertices.end(), {{x, 0, 0}, {x, 1.1F, 0}, {x, 0, 1.3F}});
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first + 3, first + 4, first + 5});
  const Built built = build(mesh);
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, 0u);
  EXPECT_EQ(built.stats.triangles, 13u);
}

TEST(Stitch, ATriangleWithoutAreaLeavesNoCrack) {
  UploadMesh mesh = cube();
  // Triangle 0 is cut in the middle of its longest edge, and what is between the halves and the neighbour has no area.
  Index3 t = mesh.triangles[0];
  const auto length2 = [&](std::uint32_t a, std::uint32_t b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::pow(double{mesh.vertices[a][k]} - mesh.vertices[b][k], 2);
    return sum;
  };
  while (length2(t[0], t[1]) < std::max(length2(t[1], t[2]), length2(t[2], t[0])))
    std::rotate(t.begin(), t.begin() + 1, t.end());
  Float3 middle;
  for (int k = 0; k < 3; ++k) middle[k] = (mesh.vertices[t[0]][k] + mesh.vertices[t[1]][k]) / 2;
  mesh.vertices.push_back(middle);
  mesh.triangles[0] = {t[0], 8, t[2]};
  mesh.triangles.push_back({8, t[1], t[2]});
  mesh.triangles.push_back({t[0], t[1], 8});
  const Built built = build(mesh);
  EXPECT_THAT(built.notes,
              ElementsAre("removed 1 triangle without area, the first is triangle 13",
                          "cut 1 edge at vertices that lay on them, the first of triangle 1: else they are cracks"));
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, HD_MESH_CLOSED);
  EXPECT_EQ(built.stats.triangles, 14u);
}

/** A square column whose lower and upper half are cut into cells of their own along the line where they meet. */
UploadMesh column(int below, int above) {
  UploadMesh mesh;
  const auto corner = [](int side, float z) {
    return Float3{(side + 1) % 4 < 2 ? -0.05f : 0.05f, side % 4 < 2 ? -0.05f : 0.05f, z};
  };
  const auto add = [&](const Float3& a, const Float3& b, const Float3& c) {
    const auto at = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.push_back({at, at + 1, at + 2});
  };
  for (const bool up : {false, true}) {
    const int cells = up ? above : below;
    const float z = up ? 0.05f : -0.05f;
    for (int side = 0; side < 4; ++side) {
      const auto between = [&](int i) {
        const float part = static_cast<float>(i) / static_cast<float>(cells);
        const Float3 from = corner(side, 0), to = corner(side + 1, 0);
        return Float3{(1 - part) * from[0] + part * to[0], (1 - part) * from[1] + part * to[1], 0};
      };
      for (int i = 0; i < cells; ++i) add(corner(side, z), between(i), between(i + 1));
      add(corner(side, z), corner(side + 1, 0), corner(side + 1, z));
    }
    add(corner(0, z), corner(1, z), corner(2, z));
    add(corner(0, z), corner(2, z), corner(3, z));
  }
  return mesh;
}

TEST(Stitch, HalvesThatShareNoVertexAlongALineAreJoined) {
  const Built built = build(column(41, 58));
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, HD_MESH_CLOSED);
  // Each of the vertices of one half, but the corners, is one more for the other.
  EXPECT_EQ(built.stats.triangles, 2u * (4 * (41 + 58 - 1) + 4 + 2));
}

TEST(Stitch, GivesUpInBoundedTimeAndSaysWhatToDo) {
  constexpr std::uint32_t kMany = 300;
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5f, -1, 0}};
  std::uint32_t from = 0;
  for (std::uint32_t i = 1; i <= kMany; ++i) {
    const float part = static_cast<float>(i) / kMany;
    const auto at = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{part, 0, 0}, {0.5f, part, 1}});
    mesh.triangles.push_back({from, at, 2});
    mesh.triangles.push_back({0, 1, at + 1});  // All of them over one edge, with all those vertices on it.
    from = at;
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) mesh.source_triangle.push_back(t);
  BuildMonitor monitor;
  connect(mesh, monitor);
  // Each edge with all the vertices on it is kMany times kMany steps and more in all.
  for (const std::int64_t work : {std::int64_t{0}, std::int64_t{10'000}, std::int64_t{kMany} * kMany}) {
    Mesh tried = mesh;
    BuildMonitor told;
    stitch(tried, 0, told, work);
    EXPECT_THAT(told.notes, Contains(HasSubstr("--weld"))) << work;
    EXPECT_LE(static_cast<std::int64_t>(tried.triangles.size() - mesh.triangles.size()), work / 32) << work;
  }
  stitch(mesh, 0, monitor);
  EXPECT_THAT(monitor.notes, Not(Contains(HasSubstr("--weld"))));
}

TEST(Stitch, WhatMerelyTouchesIsLeftAlone) {
  UploadMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5f, 0, 0}, {0.2f, -1, 0}, {0.7f, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, Not(Contains(HasSubstr("cut"))));
  EXPECT_EQ(built.stats.triangles, 2u);
}

TEST(Stitch, TheWeldingDistanceSaysWhatLiesOnAnEdge) {
  UploadMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5f, -1e-4f, 0}, {0.5f, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 4, 3}, {4, 1, 3}};
  EXPECT_THAT(build(mesh).notes, Not(Contains(HasSubstr("cut"))));
  EXPECT_THAT(build(mesh, 0, 2e-4f).notes,
              Contains("cut 1 edge at vertices that lay on them, the first of triangle 0: else they are cracks"));
}

}  // namespace
}  // namespace hapticd::test
