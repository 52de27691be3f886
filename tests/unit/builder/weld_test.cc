// Welding by distance, for scans whose seams do not quite meet.
#include <gmock/gmock.h>

#include <limits>
#include <random>

#include "daemon/builder/mesh/near_table.h"
#include "tests/support/seeds.h"
#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

double squared(const Float3& a, const Float3& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += (double{a[k]} - b[k]) * (double{a[k]} - b[k]);
  return sum;
}

/** As an STL file of a scan: each triangle with corners of its own, a little off. */
UploadMesh scanned(const UploadMesh& mesh, float off) {
  std::mt19937 random(seedOf(1));
  std::uniform_real_distribution<float> shift(-off, off);
  UploadMesh out = mesh.soup();
  for (Float3& p : out.vertices)
    for (float& x : p) x += shift(random);
  return out;
}

TEST(Weld, ClosesAScanWhoseSeamsDoNotMeet) {
  const UploadMesh mesh = scanned(torus(30, 20), 1e-6f);
  const Built open = build(mesh), closed = build(mesh, 0, 1e-5f);
  EXPECT_EQ(open.memory.view.flags & HD_MESH_CLOSED, 0u) << "exactly by default";
  EXPECT_EQ(open.stats.vertices, 3600u);
  EXPECT_NE(closed.memory.view.flags & HD_MESH_CLOSED, 0u);
  EXPECT_EQ(closed.stats.vertices, 600u);
  EXPECT_EQ(closed.stats.triangles, 1200u);
  EXPECT_THAT(closed.notes, testing::ElementsAre("welded 3600 vertices into 600 more than 1e-05 m apart"));
  EXPECT_NEAR(signedVolume(closed.memory.view), signedVolume(build(torus(30, 20)).memory.view), 1e-8);
}

TEST(Weld, AgreesWithASearchOfAll) {
  std::mt19937 random(seedOf(2));
  for (const float distance : {HD_MIN_WELD, 1e-4f, 1e-3f, 1e-2f}) {
    std::uniform_real_distribution<float> place(-0.02f, 0.02f);
    NearTable table(2000, distance);
    std::vector<Float3> kept, expected;
    for (int i = 0; i < 2000; ++i) {
      const Float3 p{place(random), place(random), i % 2 == 0 ? 0.0f : place(random)};
      std::size_t nearest = expected.size();
      for (std::size_t v = 0; v < expected.size(); ++v) {
        const bool within = squared(p, expected[v]) <= double{distance} * distance;
        if (within && (nearest == expected.size() || squared(p, expected[v]) < squared(p, expected[nearest])))
          nearest = v;
      }
      if (nearest == expected.size()) expected.push_back(p);
      ASSERT_EQ(table.findOrAdd(p, kept), nearest) << "vertex " << i << ", " << distance;
    }
    EXPECT_EQ(kept, expected);
  }
}

TEST(Weld, TrianglesThatCollapseGoAndAreNamed) {
  UploadMesh mesh = cube();
  mesh.vertices.push_back({0.01f, 0.01f, 0.0101f});  // near corner 7
  mesh.triangles.push_back({7, 8, 3});
  const Built built = build(mesh, 0, 2e-4f);
  EXPECT_EQ(built.stats.triangles, 12u);
  EXPECT_THAT(built.notes, testing::Contains("removed 1 triangle without area, the first is triangle 12"));
}

TEST(Weld, ADistanceThatCannotBeMeantIsRefused) {
  for (const float bad : {-1e-6f, 0.9e-6f, 0.0101f, std::numeric_limits<float>::quiet_NaN()}) {
    BuildMonitor monitor;
    const auto built = buildSnapshot(upload(cube(), 0, bad), monitor);
    ASSERT_FALSE(built.ok());
    EXPECT_EQ(built.error().where, "upload header");
    EXPECT_EQ(built.error().remedy, "give 0, or 1e-06 to 0.01 m");
  }
}

}  // namespace
}  // namespace hapticd::test
