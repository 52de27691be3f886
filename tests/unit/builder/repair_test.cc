// What is refused and what is repaired, each with the triangle or vertex by number.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

TEST(Refuse, NotFiniteVertexNamesVertexAndTriangle) {
  for (const float x : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                        -std::numeric_limits<float>::infinity()}) {
    UploadMesh mesh = cube();
    mesh.vertices[6][1] = x;
    const Error error = refusal(mesh);
    EXPECT_EQ(error.code, ErrorCode::kBadMesh);
    EXPECT_EQ(error.where, "vertex 6 (of triangle 3)");
    EXPECT_EQ(error.what.substr(0, 5), "y is ");
  }
}

TEST(Refuse, HugeVertex) {
  UploadMesh mesh = cube();
  for (Float3& p : mesh.vertices)
    for (float& x : p) x = std::copysign(100.0f, x);
  EXPECT_EQ(build(mesh).stats.triangles, 12u) << "the limit itself passes";
  mesh.vertices[0][2] = -100.1f;
  const Error error = refusal(mesh);
  EXPECT_EQ(error.where, "vertex 0 (of triangle 0)");
  EXPECT_EQ(error.remedy, "check the scale: coordinates are in metres");
  mesh = cube();
  mesh.vertices.push_back({0, 0, 1e9f});
  EXPECT_EQ(refusal(mesh).where, "vertex 8 (of no triangle)");
}

TEST(Refuse, IndexPastTheEndNamesTheTriangle) {
  UploadMesh mesh = cube();
  mesh.triangles[5][2] = 8;
  const Error error = refusal(mesh);
  EXPECT_EQ(toString(error), "triangle 5: index 8 is past the last vertex, 7 (export the mesh again)");
}

TEST(Refuse, EmptyAndMalformedUploads) {
  BuildMonitor monitor;
  const auto code = [&](const std::vector<std::byte>& bytes) { return buildSnapshot(bytes, monitor).error().code; };
  EXPECT_EQ(code({}), ErrorCode::kBadMesh);
  EXPECT_EQ(code(upload(UploadMesh{})), ErrorCode::kBadMesh);
  UploadMesh points = cube();
  points.triangles.clear();
  EXPECT_EQ(code(upload(points)), ErrorCode::kBadMesh);
  EXPECT_EQ(code(upload(cube(), 4)), ErrorCode::kBadMesh);
  auto longer = upload(cube());
  longer.resize(longer.size() + 12);
  EXPECT_EQ(code(longer), ErrorCode::kBadMesh);
  auto magic = upload(cube());
  magic[0] ^= std::byte{1};
  EXPECT_EQ(code(magic), ErrorCode::kBadMesh);
  auto many = upload(cube());
  const std::uint32_t count = HD_MAX_TRIANGLES + 1;
  std::memcpy(many.data() + offsetof(hd_mesh_upload, triangle_count), &count, 4);
  EXPECT_EQ(code(many), ErrorCode::kBadMesh);
  UploadMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  flat.triangles = {{0, 1, 2}};
  EXPECT_EQ(refusal(flat).what, "no triangle has an area");
}

TEST(Repair, AGoodMeshIsLeftAlone) {
  const Built built = build(cube());
  EXPECT_THAT(built.notes, IsEmpty());
  EXPECT_EQ(built.stats.vertices, 8u);
  EXPECT_EQ(built.stats.triangles, 12u);
  EXPECT_EQ(built.stats.flags, HD_MESH_CLOSED);
  EXPECT_NEAR(signedVolume(built.memory.view), 8e-6, 1e-12);
}

TEST(Repair, DegenerateTrianglesGo) {
  UploadMesh mesh = cube();
  mesh.triangles.insert(mesh.triangles.begin() + 3, {1, 1, 2});
  mesh.triangles.push_back({0, 0, 0});
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, ElementsAre("removed 2 triangles without area, the first is triangle 3"));
  EXPECT_EQ(built.stats.triangles, 12u);
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, HD_MESH_CLOSED);
}

TEST(Repair, DoubledTrianglesGoWhateverTheirWinding) {
  UploadMesh mesh = cube();
  mesh.triangles.push_back({3, 0, 2});  // as triangle 0, turned about
  mesh.triangles.push_back({7, 5, 4});  // as triangle 2, other way round
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, ElementsAre("removed 2 doubled triangles, the first is triangle 12"));
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, HD_MESH_CLOSED);
}

// The number is that of the upload, not of what is left after the slivers have gone.
TEST(Repair, ADoubledTriangleBehindASliverIsNamedByItsNumber) {
  UploadMesh mesh = cube();
  mesh.vertices.push_back({0, 0, 0});
  mesh.vertices.push_back({1, 0, 0});
  mesh.vertices.push_back({0.5f, 3e-8f, 0});  // lower than floats of that size can tell
  const auto v = static_cast<std::uint32_t>(mesh.vertices.size()) - 3;
  mesh.triangles.insert(mesh.triangles.begin(), {v, v + 1, v + 2});
  mesh.triangles.push_back(mesh.triangles[3]);
  EXPECT_THAT(build(mesh).notes, testing::IsSupersetOf({"removed 1 triangle without area, the first is triangle 0",
                                                        "removed 1 doubled triangle, the first is triangle 13"}));
}

TEST(Repair, EqualVerticesAreWeldedAndZerosHaveNoSign) {
  UploadMesh mesh = cube();
  for (Float3& p : mesh.vertices) p[0] = p[0] > 0 ? 0.02f : 0.0f;
  mesh = mesh.soup();
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 2)
    if (mesh.vertices[i][0] == 0) mesh.vertices[i][0] = -0.0f;
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, ElementsAre("welded 36 vertices into 8 of equal place"));
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, HD_MESH_CLOSED);
}

TEST(Repair, UnusedVerticesGo) {
  UploadMesh mesh = cube();
  mesh.vertices.insert(mesh.vertices.begin(), {5, 5, 5});
  for (Index3& t : mesh.triangles)
    for (std::uint32_t& v : t) ++v;
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, ElementsAre("dropped 1 vertex of no triangle"));
  EXPECT_EQ(built.stats.vertices, 8u);
  EXPECT_LT(built.stats.upper[0], 0.011f);
}

TEST(Repair, TheFewerTrianglesTurn) {
  UploadMesh mesh = torus(20, 10);
  for (const int t : {7, 8, 99}) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  const double good = signedVolume(build(torus(20, 10)).memory.view);
  ASSERT_GT(good, 0);
  const Built few = build(mesh);
  EXPECT_THAT(few.notes, ElementsAre("turned 3 triangles to the winding of the neighbours, the first is triangle 7"));
  EXPECT_DOUBLE_EQ(signedVolume(few.memory.view), good);
  EXPECT_EQ(few.stats.flags & HD_MESH_CLOSED, HD_MESH_CLOSED);
  // All but three the wrong way round: the three turn first, then the whole.
  const Built most = build(mesh.flipAll());
  EXPECT_THAT(most.notes, ElementsAre("turned 3 triangles to the winding of the neighbours, the first is triangle 7",
                                      "turned 1 closed part outside out, the first begins at triangle 0"));
  EXPECT_DOUBLE_EQ(signedVolume(most.memory.view), good);
}

TEST(Repair, OpenSurfacesKeepTheirMajority) {
  UploadMesh mesh = terrain(5, 1).flipAll();
  std::swap(mesh.triangles[30][0], mesh.triangles[30][1]);
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, Contains("turned 1 triangle to the winding of the neighbours, the first is triangle 30"));
  EXPECT_EQ(built.stats.flags & HD_MESH_CLOSED, 0u);
  const MeshView& view = built.memory.view;
  for (std::uint32_t t = 0; t < view.triangle_count; ++t)
    EXPECT_LT((view.vertex(t, 1) - view.vertex(t, 0)).cross(view.vertex(t, 2) - view.vertex(t, 0)).z(), 0);
}

TEST(Repair, HollowsKeepLookingInward) {
  UploadMesh shell = cube();
  UploadMesh hollow = cube();
  shell.add(hollow.flipAll(), {0, 0, 0}, 0.5f);
  const Built cavity = build(shell);
  EXPECT_THAT(cavity.notes, IsEmpty());
  EXPECT_NEAR(signedVolume(cavity.memory.view), 7e-6, 1e-12);
  // A solid within the hollow looks outward again; wound inward it is wrong.
  UploadMesh nested = shell;
  nested.add(hollow, {0, 0, 0}, 0.2f);  // hollow is wound inward now
  const Built inner = build(nested);
  EXPECT_THAT(inner.notes, ElementsAre("turned 1 closed part outside out, the first begins at triangle 24"));
  EXPECT_NEAR(signedVolume(inner.memory.view), 7e-6 + 0.064e-6, 1e-12);
  // Beside, not within: no hollow.
  UploadMesh beside = cube();
  beside.add(hollow, {0.1f, 0, 0}, 0.5f);
  EXPECT_THAT(build(beside).notes, ElementsAre("turned 1 closed part outside out, the first begins at triangle 12"));
}

// Only the outer part was turned, and the hollow became a second solid within the first.
TEST(Repair, ASolidInsideOutAsAWholeKeepsItsHollow) {
  UploadMesh shell = cube(), hollow = cube();
  shell.add(hollow.flipAll(), {0, 0, 0}, 0.5f);
  shell.add(cube(), {0, 0, 0}, 0.2f);  // Solid in the hollow, hollow again.
  shell.add(hollow, {0, 0, 0}, 0.1f);
  const double right = 7e-6 + (0.064e-6 - 0.008e-6);
  EXPECT_NEAR(signedVolume(build(shell).memory.view), right, 1e-12);
  const Built turned = build(shell.flipAll());
  EXPECT_THAT(turned.notes, ElementsAre("turned 4 closed parts outside out, the first begins at triangle 0"));
  EXPECT_NEAR(signedVolume(turned.memory.view), right, 1e-12);
  // What stands beside is judged by itself.
  shell.add(cube(), {0.1f, 0, 0}).add(hollow, {0.1f, 0, 0}, 0.5f);
  const Built beside = build(shell);
  EXPECT_THAT(beside.notes, ElementsAre("turned 4 closed parts outside out, the first begins at triangle 0"));
  EXPECT_NEAR(signedVolume(beside.memory.view), right + 7e-6, 1e-11);
}

// It was turned into a second solid, which holes that are filled for a volume did not undo.
TEST(Repair, AHollowInAnOpenSolidKeepsLookingInward) {
  UploadMesh hollow = cube();
  hollow.flipAll();
  UploadMesh open = cube();
  open.triangles.pop_back();
  UploadMesh mesh = open;
  mesh.add(hollow, {0, 0, 0}, 0.5f);
  EXPECT_THAT(build(mesh).notes, ElementsAre(StartsWith("open along 3 edges")));
  UploadMesh beside = open;  // Within nothing.
  beside.add(hollow, {0.1f, 0, 0}, 0.5f);
  EXPECT_THAT(build(beside).notes, Contains("turned 1 closed part outside out, the first begins at triangle 11"));
  UploadMesh room = open;  // Whose walls look inward: the solid in it is one.
  room.flipAll().add(hollow, {0, 0, 0}, 0.5f);
  EXPECT_THAT(build(room).notes, Contains("turned 1 closed part outside out, the first begins at triangle 11"));
}

// One triangle the wrong way round says nothing of the others: the hollow was filled for it.
TEST(Repair, AHollowWithAWrongTriangleStaysAHollow) {
  UploadMesh hollow = torus(20, 10);
  hollow.flipAll();
  UploadMesh mesh = cube();
  for (Float3& p : mesh.vertices)
    for (float& x : p) x *= 8;
  mesh.add(hollow);
  const double right = signedVolume(build(mesh).memory.view);
  std::swap(mesh.triangles[12 + 7][0], mesh.triangles[12 + 7][1]);
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, ElementsAre("turned 1 triangle to the winding of the neighbours, the first is triangle 19"));
  EXPECT_DOUBLE_EQ(signedVolume(built.memory.view), right);
}

TEST(Repair, EdgesOfThreeTrianglesAreBorders) {
  UploadMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, Contains("1 edge belongs to more than two triangles, the first at triangle 0; "
                                    "each counts as a border"));
  const MeshView& view = built.memory.view;
  for (std::uint32_t t = 0; t < 3; ++t)
    EXPECT_THAT(view.neighbours[t], ElementsAre(HD_NO_INDEX, HD_NO_INDEX, HD_NO_INDEX));
}

TEST(Repair, AMoebiusStripIsCutAndNamed) {
  constexpr std::uint32_t kSteps = 20;
  UploadMesh mesh;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double a = 2 * std::numbers::pi * i / kSteps;
    for (const double side : {-0.01, 0.01}) {
      const double r = 0.05 + side * std::cos(a / 2);
      mesh.vertices.push_back({static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)),
                               static_cast<float>(side * std::sin(a / 2))});
    }
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const bool last = i + 1 == kSteps;
    const std::uint32_t a = 2 * i, b = 2 * i + 1, c = last ? 1 : 2 * i + 2, d = last ? 0 : 2 * i + 3;
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({b, c, d});
  }
  const Built built = build(mesh);
  EXPECT_THAT(built.notes, Contains(testing::HasSubstr("has one side only")));
  EXPECT_EQ(built.stats.triangles, 2 * kSteps);
}

TEST(Repair, DeformableFansAreBounded) {
  for (const std::uint32_t n : {HD_MAX_DEFORM_VALENCE, HD_MAX_DEFORM_VALENCE + 1}) {
    UploadMesh fan;
    fan.vertices.push_back({0, 0, 0.01f});
    for (std::uint32_t i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n;
      fan.vertices.push_back({static_cast<float>(std::cos(a)), static_cast<float>(std::sin(a)), 0});
      fan.triangles.push_back({0, i + 1, (i + 1) % n + 1});
    }
    EXPECT_EQ(build(fan).stats.triangles, n) << "rigid fans are free";
    if (n <= HD_MAX_DEFORM_VALENCE) {
      EXPECT_EQ(build(fan, HD_MESH_DEFORMABLE).stats.triangles, n);
    } else {
      EXPECT_EQ(refusal(fan, HD_MESH_DEFORMABLE).where, "vertex 0");
    }
  }
}

TEST(Build, StopsWhenTold) {
  for (int stop = 0; stop < 8; ++stop) {
    BuildMonitor monitor;
    float last = 0;
    int calls = 0;
    monitor.progress = [&](float fraction, const char*) {
      EXPECT_GE(fraction, last);
      EXPECT_LE(fraction, 1.0f);
      last = fraction;
      return calls++ < stop;
    };
    const auto built = buildSnapshot(upload(terrain(200, 3)), monitor);
    ASSERT_FALSE(built.ok()) << stop;
    EXPECT_EQ(built.error().code, ErrorCode::kCancelled);
  }
}

}  // namespace
}  // namespace hapticd::test
