// What is too large for its field is told when it is held or begins to move, with voxels that are large enough.
#include <cstdlib>
#include <cstring>

#include "daemon/builder/volume/mesh_volume.h"
#include "daemon/scene/body.h"
#include "rt/collide/scene_contacts.h"
#include "tests/session/bench.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {
namespace {

struct LargeTool : testing::Test {
  /** The torus with a volume; `patch_points`: 1 makes as many patches of few points as a large one has of many. */
  std::uint64_t mesh(double voxel, std::uint32_t patch_points) {
    BuildMonitor monitor;
    auto snapshot = buildSnapshot(upload(shape), monitor);
    VolumeOptions options;
    options.patch_points = patch_points;
    options.octree = OctreeShape::kEight;  // The finest patches of all.
    const auto image = buildMeshVolume(shape.vertices, shape.triangles, voxel, options, monitor);
    if (!snapshot || !image) {
      ADD_FAILURE() << toString(snapshot ? image.error() : snapshot.error());
      return 0;
    }
    const auto bytes = bytesOf(*image);
    auto created = Memfd::create("volume", bytes.size());
    const Memfd memfd = std::move(*created);
    std::memcpy(memfd.map(Memfd::Access::kWrite)->data(), bytes.data(), bytes.size());
    EXPECT_TRUE(memfd.seal(Seals::kFrozen).ok());
    const auto id = bench.core.meshes().add(std::move(*snapshot->memfd.share()), std::move(*memfd.share()), {});
    EXPECT_TRUE(id.ok()) << toString(id.error());
    return id.ok() ? *id : 0;
  }
  void add(const char* name, std::uint64_t mesh_id) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {ShapeKind::kMesh, Vec3::Zero(), mesh_id};
    spec.material = kDefaultMaterial;
    ASSERT_TRUE(bench.core.scene().create(spec, anybody).ok());
  }
  /** What the last event says. */
  std::string told() {
    const auto events = bench.core.events().take(listener).events;
    return events.empty() ? "" : events.back().text;
  }

  UploadMesh shape = torus(24, 16);
  Bench bench;
  Client anybody{.uid = 1000};
  std::uint64_t listener = bench.core.events().subscribe(0, [] {});
};

TEST_F(LargeTool, IsToldOfTheToolAndOfWhatMoves) {
  OpenDevice& device = bench.device();
  const auto attached = [&](const char* name) {
    EXPECT_TRUE(bench.core.attachTool(device, {.object = name, .mass = 0.1}, anybody).ok());
    return device.tool.note;
  };
  add("small", mesh(0.002, 48));
  EXPECT_EQ(attached("small").find("vertices"), std::string::npos) << device.tool.note;
  add("middle", mesh(0.0014, 1));
  EXPECT_EQ(attached("middle").find("vertices"), std::string::npos) << device.tool.note;
  add("large", mesh(0.0007, 1));
  EXPECT_NE(attached("large").find("'large' is too large for its field"), std::string::npos) << device.tool.note;
  EXPECT_NE(device.tool.note.find("--voxel"), std::string::npos);
  EXPECT_NE(told().find("too large"), std::string::npos);
  ASSERT_TRUE(bench.core.detachTool(device, anybody).ok());

  ASSERT_TRUE(bench.core.scene().setBody("small", {.mass = 0.1}).ok());
  EXPECT_EQ(told(), "body");
  ASSERT_TRUE(bench.core.scene().setBody("middle", {.mass = 0.1}).ok());  // A quarter of what a tool may have.
  EXPECT_NE(told().find("body; 'middle' is too large"), std::string::npos);
  ASSERT_TRUE(bench.core.scene().setBody("middle", {}).ok());
  EXPECT_EQ(told(), "body") << "it moves no more";
}

TEST_F(LargeTool, TheVoxelsThatItNamesAreLargeEnough) {
  constexpr double kVoxel = 0.0015;
  const ShapeSpec fine{ShapeKind::kMesh, Vec3::Zero(), mesh(kVoxel, 48)};
  for (const std::uint32_t most : {40u, 70u, 200u}) {
    const std::string why = withoutField("it", fine, bench.core.meshes(), most);
    const std::size_t at = why.find("voxels of ");
    ASSERT_NE(at, std::string::npos) << why;
    const double enough = std::strtod(why.c_str() + at + 10, nullptr) * 1e-3;
    const ShapeSpec coarse{ShapeKind::kMesh, Vec3::Zero(), mesh(enough, 48)};
    EXPECT_EQ(withoutField("it", coarse, bench.core.meshes(), most), "") << why;
    EXPECT_LT(enough, 8 * kVoxel) << why;
  }
}

}  // namespace
}  // namespace hapticd::test
