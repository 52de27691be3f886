// The flag by which an upload has its holes filled.
#include <algorithm>

#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

UploadMesh openCube() {
  UploadMesh mesh = cube();
  mesh.triangles.resize(mesh.triangles.size() - 2);  // Without the side at +x.
  return mesh;
}

TEST(FillHoles, anUploadGetsItsVolumeOnlyIfItAsks) {
  BuildMonitor monitor;
  const auto refused = buildSnapshot(volumeUpload(openCube(), 0.001f), monitor);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kBadMesh);
  const auto built = buildSnapshot(volumeUpload(openCube(), 0.001f, HD_UPLOAD_FILL_HOLES), monitor);
  ASSERT_TRUE(built.ok()) << toString(built.error());
  EXPECT_TRUE(built->volume.valid());
  EXPECT_EQ(built->stats.flags & HD_MESH_CLOSED, 0u);  // The mesh that is touched keeps its hole.
  EXPECT_EQ(built->stats.triangles, 10u);
  const auto& notes = monitor.notes;
  EXPECT_EQ(std::count_if(notes.begin(), notes.end(), [](const auto& n) { return n.rfind("holes: closed", 0) == 0; }),
            1);
}

TEST(FillHoles, aPartThatIsInsideOutIsRefusedInWords) {
  UploadMesh both = openCube();
  for (const Float3& v : cube().vertices) both.vertices.push_back({v[0] / 2 - 0.03f, v[1] / 2, v[2] / 2});
  for (const Index3& t : openCube().triangles) both.triangles.push_back({t[0] + 8, t[2] + 8, t[1] + 8});
  BuildMonitor monitor;
  const auto refused = buildSnapshot(volumeUpload(both, 0.001f, HD_UPLOAD_FILL_HOLES), monitor);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kBadMesh);
  EXPECT_EQ(refused.error().remedy, "turn all its parts outward, and give what is a sheet a thickness");
}

TEST(FillHoles, withoutAVolumeThereIsNothingToFill) {
  BuildMonitor monitor;
  const auto refused = buildSnapshot(upload(openCube(), HD_UPLOAD_FILL_HOLES), monitor);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace hapticd::test
