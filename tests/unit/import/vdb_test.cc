// OpenVDB files, ours opened by OpenVDB and others by us; and OpenVDB's voxeliser beside ours.
#include <openvdb/openvdb.h>
#include <openvdb/tools/Diagnostics.h>
#include <openvdb/tools/MeshToVolume.h>
#include <sys/resource.h>

#include <fstream>

#include "daemon/builder/vdb/write_vdb.h"
#include "rt/volume/distance.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/test_volume.h"
#include "tests/unit/import/ball.h"
#include "tools/hapticctl-import/child.h"
#include "tools/hapticctl-import/format/vdb_file.h"
#include "tools/hapticctl-import/hand_over.h"
#include "tools/hapticctl-import/input.h"
#include "tools/hapticctl-import/isosurface.h"
#include "tools/hapticctl-import/model.h"

namespace hapticctl_import::test {
namespace {

using hapticd::Vec3;
using openvdb::FloatGrid;
using ::testing::HasSubstr;

/** A torus about z [m], in triangles fine enough that their chords are 0.04 mm. */
hapticd::test::TestMesh torus() {
  constexpr std::uint32_t n = 96, m = 48;
  hapticd::test::TestMesh mesh;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < m; ++j) {
      const double a = 2 * M_PI * i / n, b = 2 * M_PI * j / m, r = 0.05 + 0.02 * std::cos(b);
      mesh.addVertex(Vec3(r * std::cos(a), r * std::sin(a), 0.02 * std::sin(b)));
    }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < m; ++j)
      mesh.addQuad(i * m + j, (i + 1) % n * m + j, (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m);
  return mesh;
}

hapticd::test::TestVolume torusVolume(double voxel) {
  hapticd::VolumeOptions options;
  options.band_voxels = options.margin_voxels = 4;
  return hapticd::test::volumeOfMesh(torus(), voxel, options);
}

void write(const std::string& path, const hapticd::VolumeView& volume) {
  std::ofstream file(path, std::ios::binary);
  const auto written = hapticd::writeVdb(file, volume, nullptr, "a test");
  ASSERT_TRUE(written.ok()) << toString(written.error());
}

FloatGrid::Ptr readBack(const std::string& path) {
  openvdb::initialize();
  openvdb::io::File file(path);
  file.open(false);
  return openvdb::gridPtrCast<FloatGrid>(file.readGrid("surface"));
}

TEST(Vdb, whatIsWrittenIsTheVolumesNarrowBand) {
  const Folder folder;
  const auto volume = torusVolume(0.002);
  const std::string path = folder.path() + "/torus.vdb";
  write(path, volume.view);
  const auto grid = readBack(path);
  EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_NEAR(grid->background(), 0.006, 1e-9);
  const auto values = grid->getConstAccessor();
  std::uint64_t active = 0;
  const auto& cells = volume.view.cells;
  openvdb::Coord c;
  for (c.z() = -2; c.z() <= static_cast<int>(8 * cells[2]) + 2; ++c.z())
    for (c.y() = -2; c.y() <= static_cast<int>(8 * cells[1]) + 2; ++c.y())
      for (c.x() = -2; c.x() <= static_cast<int>(8 * cells[0]) + 2; ++c.x()) {
        const openvdb::Vec3d p = grid->indexToWorld(c);
        const double truth = std::hypot(std::hypot(p.x(), p.y()) - 0.05, p.z()) - 0.02;
        if (std::abs(std::abs(truth) - 0.006) > 2e-4) {
          ASSERT_EQ(values.isValueOn(c), std::abs(truth) < 0.006) << p;
        }
        const double want = std::clamp(truth, -0.006, 0.006);  // Inside beyond the band too.
        ASSERT_NEAR(values.getValue(c), want, 9e-5) << p;      // The mesh's chords, and 16 bits.
        active += values.isValueOn(c);
      }
  EXPECT_EQ(active, grid->activeVoxelCount());  // None elsewhere.
}

TEST(Vdb, whatIsWrittenPassesOpenVdbsOwnCheck) {
  const Folder folder;
  const std::string path = folder.path() + "/torus.vdb";
  for (const double voxel : {0.001, 0.002, 0.0017}) {  // As a float three times the first is less.
    write(path, torusVolume(voxel).view);
    EXPECT_EQ(openvdb::tools::checkLevelSet(*readBack(path), 9), "") << voxel;
  }
}

TEST(Vdb, statesAreTheOctreesAndTheFileSaysWhatItIs) {
  const Folder folder;
  const auto volume = torusVolume(0.002);
  const std::string path = folder.path() + "/torus.vdb";
  write(path, volume.view);
  openvdb::initialize();
  openvdb::io::File file(path);
  file.open(false);
  const auto meta = file.getMetadata();
  EXPECT_EQ(meta->metaValue<std::string>("hapticd_source"), "a test");
  EXPECT_EQ(meta->metaValue<std::int32_t>("hapticd_volume_version"), static_cast<int>(HD_VOLUME_VERSION));
  const auto grid = openvdb::gridPtrCast<openvdb::Int32Grid>(file.readGrid("states"));
  const Vec3 first = volume.view.originPoint() + Vec3::Constant(0.001);  // Voxels stand between lattice points.
  const openvdb::Vec3d place = grid->indexToWorld(openvdb::Vec3d(0, 0, 0));
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(place[k], first[k], 1e-9);
  const auto values = grid->getConstAccessor();
  std::array<std::uint64_t, 4> count{};
  openvdb::Coord c;
  for (c.z() = -1; c.z() <= 64; ++c.z())
    for (c.y() = -1; c.y() <= 80; ++c.y())
      for (c.x() = -1; c.x() <= 80; ++c.x()) {
        const int state = static_cast<int>(voxelState(volume.view.octree, c.x(), c.y(), c.z()));
        ASSERT_EQ(values.getValue(c), state) << c;
        ASSERT_EQ(values.isValueOn(c), state != 0) << c;
        ++count[static_cast<std::size_t>(state)];
      }
  EXPECT_EQ(count[2], volume.view.header->surface_voxels);
  EXPECT_GT(count[3], 1000u);
  EXPECT_GT(count[1], count[2] / 2);
  EXPECT_EQ(grid->activeVoxelCount(), count[1] + count[2] + count[3]);  // None elsewhere.
}

TEST(Vdb, whatIsWrittenIsReadAgain) {
  const Folder folder;
  const Image ball = ballImage();
  InputOptions options;
  options.file = folder.path() + "/ball.vdb";
  const Surface surface = isosurface(ball, 200);
  EXPECT_THAT(writeModel(surface, 0.5, options.file), HasSubstr("voxels of 0.5 mm"));
  Image image = readInput(options);  // Needs no scale: the file is ours.
  EXPECT_TRUE(image.distances);
  for (float& v : image.values) v = -v;
  const Surface again = isosurface(image, -*image.usual_iso);
  EXPECT_NEAR(volumeOf(again), volumeOf(surface), 0.005 * volumeOf(surface));
  for (const auto& v : again.vertices) ASSERT_NEAR(std::hypot(v[0] - 21.5, v[1] - 34.25, v[2] - 45), 8, 0.3);
}

// The surface's volume was told, of which the file held nothing.
TEST(Vdb, wallsThinnerThanItsVoxelsAreTold) {
  const Folder folder;
  Image plate = ballImage();
  for (std::size_t i = 0; i < plate.values.size(); ++i) plate.values[i] = i / 480 == 7 ? 1.0f : 0.0f;  // 2 mm.
  const Surface surface = isosurface(plate, 0.5f);
  EXPECT_THAT(writeModel(surface, 1, folder.path() + "/a.vdb"), testing::Not(HasSubstr("note")));
  EXPECT_THAT(writeModel(surface, 5, folder.path() + "/a.vdb"), HasSubstr("% of its surface is of walls so thin"));
}

TEST(Vdb, aPlaceThatCannotBeWrittenIsNamedWithTheReason) {
  Image ball;
  ball.size = kSize;
  ball.step = kPlain;
  for (std::size_t i = 0; i < std::size_t{24} * 20 * 16; ++i)
    ball.values.push_back(valueAt(i % 24, i / 24 % 20, i / 480));
  const Surface surface = isosurface(ball, 200);
  const Folder folder;
  const std::string file = folder.put("file", "");
  struct Place {
    std::string path, reason;
    bool early;  // Known before anything is read.
  };
  for (const Place& place :
       {Place{folder.path() + "/nowhere/x.vdb", "No such file", true}, Place{file + "/x.vdb", "Not a directory", true},
        Place{folder.path(), "Is a directory", true}, Place{"/dev/full", "No space left", false}}) {
    const std::string words = refusal([&] { return writeModel(surface, 1, place.path); });
    EXPECT_THAT(words, HasSubstr(place.path + ": cannot be written: " + place.reason));
    const std::string before = refusal([&] { return requireWritable(place.path), 0; });
    EXPECT_EQ(before, place.early ? words : "read");
  }
  const std::string fresh = folder.path() + "/fresh.vdb";
  requireWritable(fresh);
  EXPECT_FALSE(std::filesystem::exists(fresh));
  requireWritable(file);
  EXPECT_TRUE(std::filesystem::exists("/dev/full"));
}

/** A file as another program may write it: a fog ball of radius 5 units in a turned, scaled frame, and other grids. */
std::string strange(const Folder& folder) {
  openvdb::initialize();
  const auto fog = FloatGrid::create(0);
  for (int z = -8; z <= 8; ++z)
    for (int y = -8; y <= 8; ++y)
      for (int x = -8; x <= 8; ++x) {
        const double d = std::sqrt(x * x + y * y + z * z) / 2;
        if (d < 4) fog->getAccessor().setValue({x + 100, y - 50, z}, static_cast<float>(std::min(1.0, 3 - d + 0.5)));
      }
  const auto transform = openvdb::math::Transform::createLinearTransform(0.5);
  transform->postRotate(M_PI / 2, openvdb::math::Z_AXIS);
  transform->postTranslate({7, 8, 9});
  fog->setTransform(transform);
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  fog->setName("density");
  const auto heat = FloatGrid::create(20);
  heat->setName("heat");
  heat->getAccessor().setValue({0, 0, 0}, 30);
  heat->getAccessor().setValue({2, 2, 2}, 30);
  const auto wind = openvdb::Vec3SGrid::create();
  wind->setName("wind");
  const std::string path = folder.path() + "/strange.vdb";
  openvdb::io::File(path).write({fog, heat, wind});
  return path;
}

TEST(Vdb, gridsOfOthersAreListedAndPlaced) {
  const Folder folder;
  InputOptions options;
  options.file = strange(folder);
  EXPECT_TRUE(isVdb(options.file));
  const auto told = [&] { return refusal([&] { return readInput(options); }); };
  EXPECT_THAT(told(), HasSubstr("2 grids"));
  EXPECT_THAT(told(), HasSubstr("density, fog volume"));
  options.grid = "nothing";
  EXPECT_THAT(told(), HasSubstr("--grid"));
  options.grid = "density";
  EXPECT_THAT(told(), HasSubstr("does not say its unit"));
  options.scale = "cm";
  const Image image = readInput(options);
  EXPECT_FALSE(image.distances);
  // Half a centimetre; a quarter turn takes x to y and y to -x (right-handed), or the other way round.
  const double turn = image.step[0][1] / 5;
  EXPECT_NEAR(std::abs(turn), 1, 1e-9);
  const std::array<Double3, 3> step{{{0, 5 * turn, 0}, {-5 * turn, 0, 0}, {0, 0, 5}}};
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(image.step[k][a], step[k][a], 1e-9);
  const Surface surface = isosurface(image, *image.usual_iso);
  const double ball = 4.0 / 3 * M_PI * 30 * 30 * 30;  // Density 1/2 is 3 units from the middle: 30 mm.
  EXPECT_NEAR(volumeOf(surface), ball, 0.03 * ball);
  // The middle is voxel (100, -50, 0), at (50, -25, 0) before the turn.
  Double3 middle{};
  for (const auto& v : surface.vertices)
    for (std::size_t k = 0; k < 3; ++k)
      middle[k] += static_cast<double>(v[k]) / static_cast<double>(surface.vertices.size());
  EXPECT_NEAR(middle[0], 10 * (7 + 25 * turn), 0.5);
  EXPECT_NEAR(middle[1], 10 * (8 + 50 * turn), 0.5);
  EXPECT_NEAR(middle[2], 90, 0.5);
}

// The background stands beside the last voxel, and the surface half-way to it; it lay upon the voxel.
TEST(Vdb, aDenseFogEndsBetweenItsVoxelsAndTheBackground) {
  openvdb::initialize();
  const Folder folder;
  const auto grid = openvdb::FloatGrid::create(0);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(15)), 1, true);
  InputOptions options;
  options.file = folder.path() + "/cube.vdb";
  options.scale = "mm";
  openvdb::io::File(options.file).write(openvdb::GridPtrVec{grid});
  const Image image = readInput(options);
  EXPECT_THAT(image.origin, testing::Each(-1));
  EXPECT_NEAR(volumeOf(isosurface(image, *image.usual_iso)), 16 * 16 * 16, 40);  // Its edges are bevelled.
}

// They were no grids of floats that can be used.
TEST(Vdb, aLevelSetOfDoublesIsOneToo) {
  openvdb::initialize();
  const Folder folder;
  const auto grid = openvdb::DoubleGrid::create(3);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  for (int z = -12; z <= 12; ++z)
    for (int y = -12; y <= 12; ++y)
      for (int x = -12; x <= 12; ++x)
        if (const double d = std::sqrt(x * x + y * y + z * z) - 8; std::abs(d) < 3)
          grid->tree().setValue({x, y, z}, d);
        else if (d < 0)
          grid->tree().setValueOff({x, y, z}, -3);
  InputOptions options;
  options.file = folder.path() + "/ball.vdb";
  options.scale = "mm";
  openvdb::io::File(options.file).write(openvdb::GridPtrVec{grid});
  Image image = readInput(options);
  EXPECT_TRUE(image.distances);
  for (float& v : image.values) v = -v;
  const double ball = 4.0 / 3 * M_PI * 512;
  EXPECT_NEAR(volumeOf(isosurface(image, 0)), ball, 0.02 * ball);
}

TEST(Vdb, damagedFilesAreRefusedOrMakeAnImage) {
  const Folder folder;
  const std::string path = strange(folder);
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  const auto outcome = [&](const std::string& bytes) {
    InputOptions options;
    options.file = folder.put("damaged.vdb", bytes);
    options.grid = "density";
    options.scale = "mm";
    try {
      return inChild(
          [&] {
            try {
              const Image image = readInput(options);
              for (const float v : image.values)
                if (!std::isfinite(v)) return 6;
              return 0;
            } catch (const std::exception&) {
              return 5;
            }
          },
          std::uint64_t{1} << 31);
    } catch (const ImportError&) {
      return 7;
    }
  };
  ASSERT_EQ(outcome(whole), 0);
  int refused = 0, died = 0;
  for (std::size_t n = 0; n < whole.size() / 2; n += 1 + whole.size() / 40) {
    const int code = outcome(whole.substr(0, n));
    EXPECT_TRUE(code == 5 || code == 7) << n << ": " << code;
  }
  hapticd::Random random(hapticd::seedOf(11));
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 80) {
    std::string bytes = whole;
    flip(bytes, at, random);
    const int code = outcome(bytes);
    EXPECT_NE(code, 6) << at;
    refused += code == 5;
    died += code == 7;
  }
  EXPECT_GT(refused, 3);
  RecordProperty("refused", refused);
  RecordProperty("died", died);
}

TEST(Vdb, itsVoxeliserAgreesWithOursWithinHalfAVoxel) {
  constexpr double kVoxel = 0.002;
  hapticd::test::TestMesh mesh = torus();
  const auto volume = torusVolume(kVoxel);
  const hapticd::VolumeView& ours = volume.view;
  openvdb::initialize();
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  for (const auto& v : mesh.vertices) {  // In voxels of our lattice.
    const Vec3 p = (Vec3(v[0], v[1], v[2]) - ours.originPoint()) / kVoxel;
    points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(points, triangles);
  const auto transform = openvdb::math::Transform::createLinearTransform(kVoxel);
  const auto theirs = openvdb::tools::meshToVolume<FloatGrid>(adapter, *transform, 3, 3);
  const hapticd::MeshView& view = *mesh.view();
  double apart = 0, our_error = 0, their_error = 0;
  int compared = 0, measured = 0;
  for (auto value = theirs->cbeginValueOn(); value; ++value) {
    const openvdb::Coord c = value.getCoord();
    const Vec3 x = ours.originPoint() + kVoxel * Vec3(c.x(), c.y(), c.z());
    const auto sample = hapticd::distanceAt(ours, x);
    ASSERT_TRUE(sample.fine);
    apart = std::max(apart, std::abs(sample.value - static_cast<double>(*value)));
    if (++compared % 97 != 0) continue;
    const double truth = hapticd::test::distanceTo(view, x);  // By brute force.
    ++measured;
    our_error = std::max(our_error, std::abs(std::abs(sample.value) - truth));
    their_error = std::max(their_error, std::abs(std::abs(static_cast<double>(*value)) - truth));
  }
  EXPECT_GT(compared, 20000);
  EXPECT_GT(measured, 200);
  EXPECT_LT(apart, 0.5 * kVoxel);
  EXPECT_LT(our_error, 0.001 * kVoxel);
  EXPECT_GT(their_error, 10 * our_error);
  RecordProperty("apart_um", std::to_string(apart * 1e6));
  RecordProperty("our_error_um", std::to_string(our_error * 1e6));
  RecordProperty("their_error_um", std::to_string(their_error * 1e6));
}

}  // namespace
}  // namespace hapticctl_import::test
