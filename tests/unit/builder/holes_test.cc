// What is told of a surface that is open.
#include <gmock/gmock.h>

#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Holes, NothingIsSaidOfAClosedSurface) {
  EXPECT_THAT(build(cube()).notes, IsEmpty());
  EXPECT_THAT(build(torus(12, 8)).notes, IsEmpty());
}

TEST(Holes, AMissingTriangleIsToldWithItsWidth) {
  UploadMesh mesh = cube();
  mesh.triangles.erase(
      mesh.triangles.begin());  // Half of a side of 2 cm: the open edges are its cathetes and diagonal.
  const Built built = build(mesh);
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, 0u);
  EXPECT_THAT(built.notes, ElementsAre("open along 3 edges: one hole or rim, 28.3 mm across, the first of triangle 0"));
}

TEST(Holes, OfSeveralTheWidestIsNamed) {
  UploadMesh mesh = cube();
  mesh.triangles.resize(11);  // Without 1, 7, 5: its neighbour of the lowest number is the third, 4, 5, 7.
  UploadMesh small = cube();
  small.triangles.erase(small.triangles.begin(), small.triangles.begin() + 2);
  UploadMesh both = small;
  for (Float3& p : both.vertices)
    for (float& x : p) x *= 0.1f;
  both.add(mesh, {0.1f, 0, 0});
  const Built built = build(both.soup());
  ASSERT_EQ(built.notes.size(), 2u);  // And that equal vertices were joined.
  // Ten triangles of the small cube, which lacks a whole side, come before.
  EXPECT_EQ(built.notes[1], "open along 7 edges: 2 holes or rims, the widest 28.3 mm across, the first of triangle 12");
}

TEST(Holes, WhereThreeTrianglesMeetIsNoHole) {
  UploadMesh mesh = cube();
  mesh.add(cube(), {0.02f, 0.02f, 0});  // Along one edge.
  const Built built = build(mesh.soup());
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, 0u);
  for (const std::string& note : built.notes) EXPECT_EQ(note.find("hole"), std::string::npos) << note;
}

TEST(Holes, ARimIsOne) {
  const Built built = build(terrain(10, 1));
  ASSERT_EQ(built.notes.size(), 1u);
  EXPECT_THAT(built.notes[0], testing::StartsWith("open along 40 edges: one hole or rim, 141 mm across"));
}

}  // namespace
}  // namespace hapticd::test
