// Files on a disk, however slow or broken, of a daemon that may be told to end.
#include "daemon/scene/mesh/sync_in_parts.h"

#include <gtest/gtest.h>
#include <sys/syscall.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "daemon/ipc/unique_fd.h"
#include "daemon/scene/mesh/vdb_maker.h"
#include "daemon/scene/upload/uploads.h"
#include "tests/support/eventually.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/unit/builder/built.h"

namespace {

/** What a played disk says of the part that begins there: 0, or the number of an error. */
std::function<int(off64_t at)> g_disk;

}  // namespace

/** In place of the C library's, for all of this program. */
extern "C" int sync_file_range(int fd, off64_t at, off64_t bytes, unsigned flags) {
  if (!g_disk) return static_cast<int>(::syscall(SYS_sync_file_range, fd, at, bytes, flags));
  errno = g_disk(at);
  return errno == 0 ? 0 : -1;
}

namespace hapticd::test {
namespace {

struct PlayedDisk {
  explicit PlayedDisk(std::function<int(off64_t at)> disk) { g_disk = std::move(disk); }
  ~PlayedDisk() { g_disk = {}; }
};

UniqueFd fileOf(const std::string& path, std::streamoff parts) {
  std::ofstream(path).seekp(parts * kDiskPart_bytes - 1).put('x');
  return UniqueFd(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
}

TEST(SyncInParts, HearsBeforeEachPartWhetherToGoOn) {
  const TemporaryDirectory directory;
  const UniqueFd file = fileOf(directory.path() + "/file", 11);
  ASSERT_TRUE(file.valid());
  int asked = 0;
  EXPECT_TRUE(syncInParts(file.get(), [&] { return ++asked > 0; }));
  EXPECT_EQ(asked, 11);
  asked = 0;
  errno = 0;
  EXPECT_FALSE(syncInParts(file.get(), [&] { return ++asked < 3; }));
  EXPECT_EQ(errno, ECANCELED);
  EXPECT_EQ(asked, 3);
  EXPECT_FALSE(syncInParts(-1, [] { return true; }));
  EXPECT_EQ(errno, EBADF);
}

/** Which is told once: of a part, and by fsync() no more. */
TEST(SyncInParts, HearsOfWhatTheDiskCouldNotTake) {
  const TemporaryDirectory directory;
  const UniqueFd file = fileOf(directory.path() + "/file", 3);
  ASSERT_TRUE(file.valid());
  for (const int number : {EIO, ENOSPC, EDQUOT}) {
    const PlayedDisk disk([&](off64_t at) { return at == kDiskPart_bytes ? number : 0; });
    EXPECT_FALSE(syncInParts(file.get(), [] { return true; }));
    EXPECT_EQ(errno, number);
  }
  for (const int number : {ENOSYS, EINVAL, ESPIPE}) {
    const PlayedDisk disk([&](off64_t) { return number; });
    EXPECT_TRUE(syncInParts(file.get(), [] { return true; })) << "fsync() is left, and is content";
  }
}

/** Of as many parts, by a program in the place of the real one. */
struct MadeFile {
  explicit MadeFile(int parts) {
    const std::string program = directory.path() + "/program";
    std::ofstream(program) << "#!/bin/sh\nexec truncate -s " << parts * kDiskPart_bytes << " /dev/fd/4\n";
    ::chmod(program.c_str(), 0700);
    std::ofstream(directory.path() + "/cached") << "a volume";
    maker = std::make_unique<VdbMaker>(VdbOptions{program}, [this] { ++made; });
    maker->want(directory.path() + "/cached", vdb, true);
  }
  [[nodiscard]] bool isThere() const { return ::access(vdb.c_str(), F_OK) == 0; }
  [[nodiscard]] bool leftAPart() const { return ::access((vdb + ".new").c_str(), F_OK) == 0; }

  TemporaryDirectory directory;
  const std::string vdb = directory.path() + "/made";
  std::atomic<int> made{0};
  std::unique_ptr<VdbMaker> maker;
};

TEST(SyncInParts, AnOpenVdbFileThatTheDiskCouldNotTakeIsNotThere) {
  for (const int number : {0, EIO}) {
    const PlayedDisk disk([&](off64_t at) { return at == kDiskPart_bytes ? number : 0; });
    MadeFile file(3);
    file.maker->wait();
    EXPECT_EQ(file.isThere(), number == 0);
    EXPECT_EQ(file.made, number == 0 ? 1 : 0);
    EXPECT_FALSE(file.leftAPart());
  }
}

TEST(SyncInParts, AnOpenVdbFileIsGivenUpBetweenTwoPartsAsTheDaemonEnds) {
  constexpr int kParts = 400;
  std::atomic<int> parts{0};
  const PlayedDisk disk([&](off64_t) {
    ++parts;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return 0;
  });
  MadeFile file(kParts);
  ASSERT_TRUE(eventually([&] { return parts > 0 || file.isThere(); }));
  file.maker = nullptr;
  EXPECT_GT(parts, 0);
  EXPECT_LT(parts, kParts);
  EXPECT_FALSE(file.isThere());
  EXPECT_FALSE(file.leftAPart());
}

/** Which is waited for: what is read aside from a slow disk would go on to its end. */
TEST(SyncInParts, WhatIsReadAsideHearsThatTheDaemonEnds) {
  const TemporaryDirectory directory;
  BuildMonitor monitor;
  const auto upload = volumeUpload(torus(20, 12), 0.004f);
  const auto built = buildSnapshot(upload, monitor);
  ASSERT_TRUE(built.ok()) << toString(built.error());
  const std::string key = VolumeCache::keyOf(upload, 1000);
  MeshStore meshes;
  TextureStore textures;
  std::atomic<bool> begun{false};
  bool heard = false;
  {
    Uploads uploads(meshes, textures, [](auto, auto, auto) { return Result<void>(); });
    uploads.setCache(std::make_unique<VolumeCache>(directory.path(), 1 << 30));
    VolumeCache& cache = *uploads.cache();
    cache.keep(key, std::move(*built->memfd.share()), std::move(*built->volume.share()), {});
    cache.wait();
    uploads.aside().start(
        [&]() -> Result<int> {
          begun = cache.find(key).has_value();
          heard = begun && eventually([&] { return !cache.find(key).has_value(); });
          return 0;
        },
        [](const Result<int>&) {});
    ASSERT_TRUE(eventually([&] { return begun.load(); }));
  }
  EXPECT_TRUE(heard);
}

}  // namespace
}  // namespace hapticd::test
