// Walls thinner than a volume's voxels are lost to other volumes: whether that is told.
#include <algorithm>
#include <cmath>

#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

/** A square plate of 20 mm; tilted. */
UploadMesh plate(double thick) {
  UploadMesh mesh = cube();
  for (auto& v : mesh.vertices) {
    const double x = double{v[0]}, y = double{v[1]}, z = double{v[2]} * thick / 0.02;
    const double c = std::cos(0.4), s = std::sin(0.4), d = std::cos(0.7), e = std::sin(0.7);
    v = {static_cast<float>(d * (c * x - s * z) - e * y), static_cast<float>(e * (c * x - s * z) + d * y),
         static_cast<float>(s * x + c * z)};
  }
  return mesh;
}

bool isTold(const UploadMesh& mesh, float voxel_m) {
  BuildMonitor monitor;
  const auto built = buildSnapshot(volumeUpload(mesh, voxel_m), monitor);
  EXPECT_TRUE(built.ok()) << toString(built.error());
  return std::any_of(monitor.notes.begin(), monitor.notes.end(),
                     [](const std::string& note) { return note.find("of walls so thin") != std::string::npos; });
}

TEST(ThinWalls, AreTold) {
  for (const double thick : {0.0003, 0.0005, 0.0008}) EXPECT_TRUE(isTold(plate(thick), 0.001f)) << thick;
  for (const double thick : {0.0012, 0.002, 0.005}) EXPECT_FALSE(isTold(plate(thick), 0.001f)) << thick;
  EXPECT_FALSE(isTold(cube(), 0.002f));
  EXPECT_FALSE(isTold(torus(40, 24), 0.004f));
}

}  // namespace
}  // namespace hapticd::test
