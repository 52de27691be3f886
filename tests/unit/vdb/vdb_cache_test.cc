// OpenVDB files beside cached volumes: made by the real program in its sandbox, read back, damaged, interrupted.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/ipc/cached_build.h"
#include "daemon/ipc/volume_memory.h"
#include "daemon/leash/spawn.h"
#include "daemon/scene/mesh/volume_cache.h"
#include "rt/volume/distance.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/unit/builder/built.h"
#include "tools/hapticctl-import/child.h"
#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/format/vdb_file.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
constexpr const char* kKey = "1000-0123456789abcdef-500-2.1.1";

VdbOptions realProgram() { return {HAPTICD_TEST_BUILDER_VDB}; }

class VdbCache : public ::testing::Test {
 protected:
  BuiltSnapshot build(const std::vector<std::byte>& upload) {
    BuildMonitor monitor;
    auto built = buildSnapshot(upload, monitor);
    EXPECT_TRUE(built.ok()) << toString(built.error());
    return std::move(*built);
  }
  void keep(VolumeCache& cache, const BuiltSnapshot& built, const char* key = kKey) {
    cache.keep(key, std::move(*built.memfd.share()), std::move(*built.volume.share()), {"a note"});
    cache.wait();
  }
  /** A program in the place of the real one. */
  VdbOptions script(const std::string& body) {
    const std::string path = scripts_.path() + "/program";
    std::ofstream(path) << "#!/bin/sh\n" << body;
    ::chmod(path.c_str(), 0700);
    return {path};
  }
  [[nodiscard]] std::string path(const char* ending) const { return directory_.path() + "/" + kKey + ending; }
  [[nodiscard]] hapticctl_import::Image read() const {
    const auto grids = hapticctl_import::gridsOf(path(kCachedVdbEnding));
    EXPECT_EQ(grids.size(), 1u) << "of floats";
    EXPECT_EQ(grids[0].name, "surface");
    EXPECT_EQ(grids[0].metres_per_unit, 1);
    return hapticctl_import::readVdb(path(kCachedVdbEnding), grids[0], 1);
  }
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(directory_.path())) names.push_back(entry.path().extension());
    std::sort(names.begin(), names.end());
    return names;
  }

  TemporaryDirectory directory_, scripts_;
};

/** Calls visit(place [m], value [m]) for every value of an image. */
template <class Visit>
void forEachValue(const hapticctl_import::Image& image, Visit&& visit) {
  std::size_t i = 0;
  for (std::uint32_t z = 0; z < image.size[2]; ++z)
    for (std::uint32_t y = 0; y < image.size[1]; ++y)
      for (std::uint32_t x = 0; x < image.size[0]; ++x, ++i) {
        Vec3 at;
        for (int a = 0; a < 3; ++a) {
          const auto k = static_cast<std::size_t>(a);
          at[a] = (image.origin[k] + x * image.step[0][k] + y * image.step[1][k] + z * image.step[2][k]) * 1e-3;
        }
        visit(at, double{image.values[i]});
      }
}

constexpr double kVoxel = 0.001;

/**
 * A box and a small one beside it, whose low end places the lattice: cell borders are 1.95 voxels behind the large
 * one's face. The cells behind them have no bricks, and their first layer of points is 2.95 voxels from the surface.
 */
struct TwoBoxes {
  struct Box {
    Vec3 low, high;
    [[nodiscard]] double distanceTo(const Vec3& x) const {
      const Vec3 q = (x - (low + high) / 2).cwiseAbs() - (high - low) / 2;
      return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
    }
  };
  Box large{Vec3::Zero(), Vec3::Constant(0.02)}, small{{-0.0081, 0.008, 0.008}, {-0.005, 0.012, 0.012}};

  [[nodiscard]] double distanceTo(const Vec3& x) const { return std::min(large.distanceTo(x), small.distanceTo(x)); }
  [[nodiscard]] UploadMesh mesh() const {
    UploadMesh both;
    for (const Box& box : {large, small}) {
      UploadMesh one = cube();
      const auto base = static_cast<std::uint32_t>(both.vertices.size());
      for (auto& v : one.vertices) {
        for (int k = 0; k < 3; ++k)
          v[static_cast<std::size_t>(k)] =
              static_cast<float>(v[static_cast<std::size_t>(k)] < 0 ? box.low[k] : box.high[k]);
        both.vertices.push_back(v);
      }
      for (const auto& t : one.triangles) both.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    }
    return both;
  }
};

TEST_F(VdbCache, theProgramInItsSandboxMakesTheWholeBand) {
  const TwoBoxes boxes;
  const BuiltSnapshot built = build(volumeUpload(boxes.mesh(), static_cast<float>(kVoxel)));
  {
    VolumeCache cache(directory_.path(), 1 << 30, realProgram());
    keep(cache, built);
  }
  ASSERT_EQ(files(), (std::vector<std::string>{".hvol", ".vdb"}));
  const auto mapping = built.volume.map(Memfd::Access::kRead);
  const auto volume = validateVolume(mapping->bytes());
  ASSERT_TRUE(volume.ok());
  const auto image = read();
  int beyond = 0;
  forEachValue(image, [&](const Vec3& x, double value) {
    const double truth = boxes.distanceTo(x);
    beyond += std::abs(truth) < 3 * kVoxel && !distanceAt(*volume, x).fine ? 1 : 0;
    ASSERT_NEAR(value, std::clamp(truth, -3 * kVoxel, 3 * kVoxel), 1e-6) << x.transpose();
  });
  EXPECT_GT(beyond, 40) << "points that the volume itself does not hold";
  for (const std::size_t k : {0u, 1u, 2u}) {  // All of it.
    const auto a = static_cast<Eigen::Index>(k);
    EXPECT_LT(image.origin[k] * 1e-3, std::min(boxes.large.low[a], boxes.small.low[a]) - 2 * kVoxel + 1e-6);
  }
}

TEST_F(VdbCache, holesAreClosedAsTheVolumesAre) {
  UploadMesh open = cube();
  double low = 0, high = 0;
  for (const auto& v : open.vertices) {
    low = std::min<double>(low, v[0]);
    high = std::max<double>(high, v[0]);
  }
  open.triangles.resize(open.triangles.size() - 2);
  VolumeCache cache(directory_.path(), 1 << 30, realProgram());
  keep(cache, build(volumeUpload(open, static_cast<float>(kVoxel), HD_UPLOAD_FILL_HOLES)));
  const Vec3 half = Vec3::Constant((high - low) / 2), middle = Vec3::Constant((high + low) / 2);
  int inside = 0;
  forEachValue(read(), [&](const Vec3& x, double value) {
    const Vec3 q = (x - middle).cwiseAbs() - half;
    const double truth = q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
    inside += value < 0 ? 1 : 0;
    ASSERT_NEAR(value, std::clamp(truth, -3 * kVoxel, 3 * kVoxel), kVoxel) << x.transpose();
  });
  EXPECT_GT(inside, 500);
}

TEST_F(VdbCache, whatIsFoundWithoutOneGetsOneAndDamageHarmsNothing) {
  const BuiltSnapshot built = build(volumeUpload(torus(12, 8), 0.008f));
  {
    VolumeCache cache(directory_.path(), 1 << 30);
    keep(cache, built);
    EXPECT_EQ(files(), (std::vector<std::string>{".hvol"})) << "not wanted";
  }
  VolumeCache cache(directory_.path(), 1 << 30, realProgram());
  ASSERT_TRUE(cache.find(kKey).has_value());
  cache.wait();
  ASSERT_EQ(files(), (std::vector<std::string>{".hvol", ".vdb"}));
  // OpenVDB trusts a file; so it is read in a process that may die.
  const auto outcome = [&] {
    try {
      return hapticctl_import::inChild(
          [&] {
            try {
              (void)read();
            } catch (const std::exception&) {
              return 5;
            }
            return 0;
          },
          std::uint64_t{1} << 31);
    } catch (const hapticctl_import::ImportError&) {
      return 7;
    }
  };
  ASSERT_EQ(outcome(), 0);
  const auto size = static_cast<std::streamoff>(fs::file_size(path(kCachedVdbEnding)));
  const auto flip = [&](std::streamoff at) {
    std::fstream file(path(kCachedVdbEnding), std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(at);
    const int byte = file.get();
    file.seekp(at);
    file.put(static_cast<char>(byte ^ 0x10));
  };
  int refused = 0;
  for (int n = 1; n < 8; ++n) {  // Behind the metadata.
    flip(size * n / 8);
    refused += outcome() != 0 ? 1 : 0;
    auto found = cache.find(kKey);
    ASSERT_TRUE(found.has_value());
    EXPECT_TRUE(openVolume(std::move(found->volume), false).ok());
    flip(size * n / 8);
  }
  ASSERT_EQ(outcome(), 0);
  EXPECT_GE(refused, 4) << "what lies in the surface is never taken for whole; the states are not read";
}

TEST_F(VdbCache, oneOfAnotherVersionIsMadeAnew) {
  const BuiltSnapshot built = build(volumeUpload(torus(12, 8), 0.008f));
  {
    VolumeCache cache(directory_.path(), 1 << 30);
    keep(cache, built);
  }
  for (const char* old : {".vdb", ".v1.vdb", ".v987.vdb"}) {  // The first version had no number.
    std::ofstream(path(old)) << "of another version";
    VolumeCache cache(directory_.path(), 1 << 30, realProgram());
    EXPECT_EQ(cache.openVdb(kKey).error().code, ErrorCode::kNotFound);
    ASSERT_TRUE(cache.find(kKey).has_value());
    cache.wait();
    EXPECT_FALSE(fs::exists(path(old))) << "nobody would ever remove it";
    EXPECT_EQ(files(), (std::vector<std::string>{".hvol", ".vdb"}));
    EXPECT_TRUE(cache.openVdb(kKey).ok());
    EXPECT_FALSE(read().values.empty());
    fs::remove(path(kCachedVdbEnding));
  }
  // Those of this version stay, and where none are made any more the old ones go all the same.
  std::ofstream(path(kCachedVdbEnding)) << "of this version";
  std::ofstream(path(".v1.vdb")) << "of another version";
  VolumeCache cache(directory_.path(), 1 << 30);
  EXPECT_TRUE(fs::exists(path(kCachedVdbEnding)));
  EXPECT_FALSE(fs::exists(path(".v1.vdb")));
  EXPECT_EQ(cache.list().at(0).vdb_bytes, 15u);
}

TEST_F(VdbCache, whatDiesOrHangsLeavesNothingAndIsNotTriedAgain) {
  const BuiltSnapshot built = build(volumeUpload(torus(12, 8), 0.008f));
  const std::string runs = scripts_.path() + "/runs";
  const auto count = [&] { return fs::exists(runs) ? fs::file_size(runs) : 0; };
  {
    VolumeCache cache(directory_.path(), 1 << 30, script("printf x >> " + runs + "; printf half >&4; kill -SEGV $$\n"));
    keep(cache, built);
    EXPECT_EQ(files(), (std::vector<std::string>{".hvol"}));
    EXPECT_EQ(count(), 1u);
    EXPECT_TRUE(cache.find(kKey).has_value());
    cache.wait();
    EXPECT_EQ(count(), 1u) << "once is enough";
    keep(cache, built);
    EXPECT_EQ(count(), 2u) << "but another file is another try";
  }
  VdbOptions slow = script("printf x >> " + runs + "; printf half >&4; exec sleep 1000\n");
  slow.timeout_ns = 50'000'000;
  {
    VolumeCache cache(directory_.path(), 1 << 30, slow);
    EXPECT_TRUE(cache.find(kKey).has_value());
    cache.wait();
    EXPECT_EQ(files(), (std::vector<std::string>{".hvol"}));
    EXPECT_EQ(count(), 3u);
  }
  slow.timeout_ns = 1'000'000'000'000;
  {
    VolumeCache cache(directory_.path(), 1 << 30, slow);
    EXPECT_TRUE(cache.find(kKey).has_value());
    while (count() < 4) ::usleep(1000);  // It is under way, and the cache goes.
  }
  EXPECT_EQ(files(), (std::vector<std::string>{".hvol"}));
  // What a daemon left that was killed.
  std::ofstream(path(".vdb.new")) << "half";
  std::ofstream(path(".hvol.new")) << "half";
  const VolumeCache cache(directory_.path(), 1 << 30);
  EXPECT_EQ(files(), (std::vector<std::string>{".hvol"}));
}

TEST_F(VdbCache, aFullDiskAndADamagedVolumeAreErrors) {
  {
    VolumeCache cache(directory_.path(), 1 << 30);
    keep(cache, build(volumeUpload(torus(12, 8), 0.008f)));
  }
  const auto exitOf = [&](const char* to) {
    const UniqueFd from(::open(path(".hvol").c_str(), O_RDONLY | O_CLOEXEC)), out(::open(to, O_WRONLY | O_CLOEXEC));
    const int fds[] = {from.get(), out.get()};
    const auto pid = spawnProgram(HAPTICD_TEST_BUILDER_VDB, {"2000000000"}, fds);
    EXPECT_TRUE(pid.ok());
    int status = 0;
    ::waitpid(*pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  };
  EXPECT_EQ(exitOf("/dev/null"), 0);
  EXPECT_EQ(exitOf("/dev/full"), 1);
  std::fstream file(path(".hvol"), std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(fs::file_size(path(".hvol")) / 2));
  file.put('x').put('y').put('z');
  file.close();
  EXPECT_EQ(exitOf("/dev/null"), 1);
}

TEST_F(VdbCache, bothCountAndGoTogether) {
  const BuiltSnapshot built = build(volumeUpload(torus(12, 8), 0.008f));
  // A file of a known size beside each.
  const std::uint64_t beside = 300'000, ours = built.memfd.size() + built.volume.size() + 1000;
  const VdbOptions options = script("head -c " + std::to_string(beside) + " /dev/zero >&4\n");
  VolumeCache cache(directory_.path(), 2 * (ours + beside) + ours, options);
  const char *const a = "1000-000000000000000a-5-2.1.1", *const b = "1000-000000000000000b-5-2.1.1";
  for (const char* key : {a, b}) {
    keep(cache, built, key);
    fs::last_write_time(directory_.path() + "/" + key + ".hvol",
                        fs::file_time_type::clock::now() - std::chrono::hours(key == a ? 2 : 1));
  }
  EXPECT_EQ(files(), (std::vector<std::string>{".hvol", ".hvol", ".vdb", ".vdb"}));
  keep(cache, built, "1000-000000000000000c-5-2.1.1");
  EXPECT_FALSE(cache.find(a).has_value());
  EXPECT_TRUE(cache.find(b).has_value());
  EXPECT_EQ(files(), (std::vector<std::string>{".hvol", ".hvol", ".vdb", ".vdb"}));
  cache.drop(b);
  EXPECT_EQ(files(), (std::vector<std::string>{".hvol", ".vdb"}));
  // Where only one of the two has room it is the volume.
  const TemporaryDirectory small;
  VolumeCache narrow(small.path(), ours + beside / 2, options);
  keep(narrow, built);
  EXPECT_TRUE(narrow.find(kKey).has_value());
  narrow.wait();
  EXPECT_FALSE(fs::exists(small.path() + "/" + kKey + kCachedVdbEnding));
}

TEST_F(VdbCache, aFileThatIsTooLargePushesNothingOut) {
  const BuiltSnapshot built = build(volumeUpload(torus(12, 8), 0.008f));
  const std::uint64_t ours = built.memfd.size() + built.volume.size() + 1000;
  VolumeCache cache(directory_.path(), 2 * ours, script("head -c " + std::to_string(3 * ours) + " /dev/zero >&4\n"));
  for (const char* key : {"1000-000000000000000a-5-2.1.1", "1000-000000000000000b-5-2.1.1"}) keep(cache, built, key);
  EXPECT_EQ(files(), (std::vector<std::string>{".hvol", ".hvol"}));
}

}  // namespace
}  // namespace hapticd::test
