// Volumes on disk: whole, damaged, too many; and an upload that was built before.
#include "daemon/scene/mesh/volume_cache.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <thread>

#include "daemon/ipc/volume_memory.h"
#include "daemon/scene/mesh/sync_in_parts.h"
#include "daemon/scene/upload/uploads.h"
#include "tests/support/eventually.h"
#include "tests/support/process/no_descriptors.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

class Cache : public testing::Test {
 protected:
  void SetUp() override {
    BuildMonitor monitor;
    auto built = buildSnapshot(upload_, monitor);
    ASSERT_TRUE(built.ok()) << toString(built.error());
    built_ = std::move(*built);
  }
  void keep(VolumeCache& cache, const std::string& key) {
    cache.keep(key, std::move(*built_.memfd.share()), std::move(*built_.volume.share()), {"first", "second"});
    cache.wait();
  }
  /** As an upload that holds `what` is named. */
  static std::string keyNamed(std::string_view what) {
    return VolumeCache::keyOf(std::as_bytes(std::span(what)), 1000);
  }
  [[nodiscard]] fs::path onlyFile() const { return *fs::directory_iterator(directory_.path()); }

  TemporaryDirectory directory_;
  std::vector<std::byte> upload_ = volumeUpload(torus(20, 12), 0.004f);
  BuiltSnapshot built_;
};

TEST_F(Cache, givesBackWhatItKept) {
  const std::string key = VolumeCache::keyOf(upload_, 1000);
  {
    VolumeCache cache(directory_.path(), 1 << 30);
    EXPECT_FALSE(cache.find(key).has_value());
    keep(cache, key);
  }
  VolumeCache cache(directory_.path(), 1 << 30);  // Another daemon, later.
  auto found = cache.find(key);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->notes, (std::vector<std::string>{"first", "second"}));
  const auto was = built_.volume.map(Memfd::Access::kRead);
  const auto volume = openVolume(std::move(found->volume), false);
  ASSERT_TRUE(volume.ok()) << toString(volume.error());
  ASSERT_EQ(volume->mapping.size(), was->size());
  EXPECT_EQ(std::memcmp(volume->mapping.data(), was->data(), was->size()), 0);
  EXPECT_TRUE(openSnapshot(std::move(found->snapshot), false).ok());
}

TEST_F(Cache, keysTellUploadsAndUsersApart) {
  const std::string key = VolumeCache::keyOf(upload_, 1000);
  EXPECT_NE(key, VolumeCache::keyOf(upload_, 1001));
  const std::string versions = "-" + std::to_string(HD_SNAPSHOT_VERSION) + "." + std::to_string(HD_VOLUME_VERSION) +
                               "." + std::to_string(kBuilderVersion);
  EXPECT_EQ(key.substr(key.size() - versions.size()), versions) << "what an older builder made is not found";
  for (std::size_t i = 0; i < upload_.size(); i += 101) {
    auto other = upload_;
    other[i] ^= std::byte{1};
    EXPECT_NE(key, VolumeCache::keyOf(other, 1000)) << "byte " << i;
  }
  for (std::size_t i = upload_.size() - 16; i < upload_.size(); ++i) {  // The request, last of all.
    auto other = upload_;
    other[i] ^= std::byte{1};
    EXPECT_NE(key, VolumeCache::keyOf(other, 1000)) << "byte " << i;
  }
}

TEST_F(Cache, damagedFilesAreNotBelieved) {
  VolumeCache cache(directory_.path(), 1 << 30);
  const std::string key = VolumeCache::keyOf(upload_, 1000);
  keep(cache, key);
  const fs::path path = onlyFile();
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-5000, std::ios::end);
    file.put('x').put('y').put('z');
  }
  auto found = cache.find(key);
  ASSERT_TRUE(found.has_value());
  EXPECT_FALSE(openVolume(std::move(found->volume), false).ok());
  fs::resize_file(path, fs::file_size(path) - 1);
  EXPECT_FALSE(cache.find(key).has_value()) << "cut short";
  fs::resize_file(path, 10);
  EXPECT_FALSE(cache.find(key).has_value()) << "not even a head";
  cache.drop(key);
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(Cache, aDamagedHeaderOfTheVolumeIsNotBelieved) {
  VolumeCache cache(directory_.path(), 1 << 30);
  const std::string key = VolumeCache::keyOf(upload_, 1000);
  keep(cache, key);
  const std::size_t header = sizeof(CachedBuildHead) + built_.memfd.size();
  for (const std::size_t at : {offsetof(hd_volume_header, voxel), offsetof(hd_volume_header, origin),
                               offsetof(hd_volume_header, fine_step), offsetof(hd_volume_header, mass)}) {
    std::fstream file(onlyFile(), std::ios::in | std::ios::out | std::ios::binary);
    const auto place = static_cast<std::streamoff>(header + at + 2);
    file.seekg(place);
    const auto was = static_cast<char>(file.get());
    const auto put = [&](char c) { file.seekp(place).put(c).flush(); };
    put(static_cast<char>(was ^ 1));
    EXPECT_FALSE(cache.find(key).has_value()) << at;
    put(was);
    EXPECT_TRUE(cache.find(key).has_value()) << at;
  }
}

TEST_F(Cache, thoseThatComeWhileOneIsWrittenAreKeptAfterIt) {
  VolumeCache cache(directory_.path(), 1 << 30);
  const std::string names = "abcdefgh";
  const auto keyOfOne = [](char name) { return keyNamed({&name, 1}); };
  for (const char name : names)
    cache.keep(keyOfOne(name), std::move(*built_.memfd.share()), std::move(*built_.volume.share()),
               {std::string(1, name)});
  cache.wait();
  for (const char name : names) {
    const auto found = cache.find(keyOfOne(name));
    ASSERT_TRUE(found.has_value()) << name;
    EXPECT_EQ(found->notes, std::vector<std::string>{std::string(1, name)});
  }
  EXPECT_EQ(cache.list().size(), names.size());
}

/** A disk that stands still with the first volume, until wake(): its file is a pipe that nobody reads. */
class StuckCache : public Cache {
 protected:
  void SetUp() override {
    Cache::SetUp();
    cache_ = std::make_unique<VolumeCache>(directory_.path(), 64 << 20);
    ASSERT_EQ(::mkfifo(stuck_.c_str(), 0600), 0);  // A cache that begins removes what has been left half written.
    ask("first");
  }
  void ask(std::string_view what) {
    cache_->keep(keyNamed(what), std::move(*built_.memfd.share()), std::move(*built_.volume.share()), {});
  }
  void wake() {
    std::ifstream pipe(stuck_, std::ios::binary);
    pipe.ignore(std::numeric_limits<std::streamsize>::max());  // To its end: the writer goes on.
  }
  [[nodiscard]] bool has(std::string_view what) const {
    return fs::exists(directory_.path() + "/" + keyNamed(what) + ".hvol");
  }

  std::string stuck_ = directory_.path() + "/" + keyNamed("first") + ".hvol.new";
  std::unique_ptr<VolumeCache> cache_;
};

TEST_F(StuckCache, tellsForWhichTooManyWait) {
  testing::internal::CaptureStderr();
  constexpr int kAsked = 20, kKept = 16;
  for (int i = 1; i < kAsked; ++i) ask(std::to_string(i));
  wake();
  cache_->wait();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("MB of 16 others wait to be written"), std::string::npos) << said;
  for (int i = 1; i < kAsked; ++i) EXPECT_EQ(has(std::to_string(i)), i < kKept) << i;
}

TEST_F(StuckCache, countsOneThatComesAgainOnce) {
  for (int i = 0; i < 20; ++i) ask("again");
  ask("another");
  wake();
  cache_->wait();
  EXPECT_TRUE(has("again") && has("another"));
}

TEST_F(StuckCache, doesNotFillTheMemoryWithWhatWaits) {
  const auto large = [](std::uint64_t bytes) { return std::move(*Memfd::create("large", bytes)->share()); };
  testing::internal::CaptureStderr();
  cache_->keep(keyNamed("large"), large(200'000'000), std::move(*built_.volume.share()), {});
  cache_->keep(keyNamed("too much"), large(100'000'000), std::move(*built_.volume.share()), {});
  ask("small");
  wake();
  cache_->wait();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("MB of 2 others wait to be written"), std::string::npos) << said;
  EXPECT_TRUE(has("small"));
}

TEST_F(StuckCache, endsWithTheOneThatIsBeingWritten) {
  for (const char* const what : {"second", "third"}) ask(what);
  const std::string told = directory_.path() + "/told";
  const int before = ::dup(STDERR_FILENO), file = ::open(told.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  ::dup2(file, STDERR_FILENO);
  std::thread ending([this] { cache_.reset(); });
  const auto said = [&] {
    std::stringstream all;
    all << std::ifstream(told).rdbuf();
    return all.str();
  };
  const bool heard = eventually([&] { return said().find("2 volumes that were still to be written") != said().npos; });
  wake();
  ending.join();
  ::dup2(before, STDERR_FILENO);
  ::close(before);
  ::close(file);
  EXPECT_TRUE(heard) << said();
  EXPECT_FALSE(has("second") || has("third"));
}

TEST_F(Cache, longestUnusedFilesGoFirst) {
  const std::uint64_t one = built_.memfd.size() + built_.volume.size();
  VolumeCache cache(directory_.path(), 2 * one + one / 2);
  const std::string a = keyNamed("a"), b = keyNamed("b"), c = keyNamed("c");
  for (const std::string& key : {a, b}) keep(cache, key);
  const auto past = fs::file_time_type::clock::now() - std::chrono::hours(1);
  for (const auto& entry : fs::directory_iterator(directory_.path())) fs::last_write_time(entry.path(), past);
  EXPECT_TRUE(cache.find(a).has_value());  // Used now.
  keep(cache, c);
  EXPECT_TRUE(cache.find(a).has_value());
  EXPECT_FALSE(cache.find(b).has_value());
  EXPECT_TRUE(cache.find(c).has_value());
}

TEST_F(Cache, neitherAreThereMoreThanWhoListsThemHasTimeFor) {
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(1);
  std::string oldest;
  for (std::size_t i = 0; i < VolumeCache::kMostVolumes; ++i) {
    const std::string key = keyNamed("volume " + std::to_string(i)), path = directory_.path() + "/" + key + ".hvol";
    std::ofstream(path) << "x";
    fs::last_write_time(path, i == 7 ? old - std::chrono::hours(1) : old);
    if (i == 7) oldest = key;
  }
  VolumeCache cache(directory_.path(), 1 << 30);
  ASSERT_EQ(cache.list().size(), VolumeCache::kMostVolumes);
  ASSERT_EQ(cache.list().front().key, oldest);
  const std::string key = keyNamed("newest");
  keep(cache, key);
  EXPECT_EQ(cache.list().size(), VolumeCache::kMostVolumes);
  EXPECT_FALSE(fs::exists(directory_.path() + "/" + oldest + ".hvol"));
  EXPECT_TRUE(cache.find(key).has_value());
}

TEST_F(Cache, aClockThatWasAheadDoesNotHaveNewFilesGoFirst) {
  const std::uint64_t one = built_.memfd.size() + built_.volume.size();
  VolumeCache cache(directory_.path(), 2 * one + one / 2);
  const std::string a = keyNamed("a"), b = keyNamed("b"), c = keyNamed("c"), d = keyNamed("d");
  for (const std::string& key : {a, b}) keep(cache, key);
  const auto ahead = fs::file_time_type::clock::now() + std::chrono::hours(24 * 365);
  for (const auto& entry : fs::directory_iterator(directory_.path())) fs::last_write_time(entry.path(), ahead);
  for (const std::string& key : {c, d}) {
    keep(cache, key);
    EXPECT_TRUE(cache.find(key).has_value());
  }
  EXPECT_TRUE(cache.find(c).has_value());
  for (const std::string& key : {a, b}) EXPECT_FALSE(cache.find(key).has_value());
}

TEST_F(Cache, oneThatIsTooLargeIsToldAndPushesNothingOut) {
  const std::uint64_t one = built_.memfd.size() + built_.volume.size();
  VolumeCache cache(directory_.path(), 2 * one);
  keep(cache, keyNamed("a"));
  BuildMonitor monitor;
  auto large = buildSnapshot(volumeUpload(torus(20, 12), 0.0015f), monitor);
  ASSERT_TRUE(large.ok()) << toString(large.error());
  ASSERT_GT(large->volume.size(), 2 * one);
  testing::internal::CaptureStderr();
  cache.keep(keyNamed("b"), std::move(*large->memfd.share()), std::move(*large->volume.share()), {});
  cache.wait();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("a volume is not kept on disk: it has "), std::string::npos) << said;
  EXPECT_FALSE(cache.find(keyNamed("b")).has_value());
  EXPECT_TRUE(cache.find(keyNamed("a")).has_value());
}

TEST_F(Cache, whatOthersKeepInItsFolderIsLeftAlone) {
  const std::vector<std::string> others{"bunny.vdb",
                                        "2024-01.v2.vdb",
                                        "scan.hvol",
                                        "report.new",
                                        "1000-abc.hvol",
                                        "x" + keyNamed("a") + ".vdb",
                                        keyNamed("a") + ".vdb.bak"};
  for (const std::string& name : others) std::ofstream(directory_.path() + "/" + name) << std::string(5000, 'x');
  const std::string gone = keyNamed("gone");
  for (const char* ending : {".vdb", ".v1.vdb", ".v2.vdb.new", ".hvol.new"})
    std::ofstream(directory_.path() + "/" + gone + ending) << "of ours";
  VolumeCache cache(directory_.path(), 1);
  keep(cache, keyNamed("a"));  // Does not fit: it goes, and all that is no longer used with it.
  EXPECT_FALSE(cache.find(keyNamed("a")).has_value());
  EXPECT_TRUE(cache.list().empty());
  for (const std::string& name : others) EXPECT_TRUE(fs::exists(directory_.path() + "/" + name)) << name;
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_.path()), {}), std::ssize(others));
}

TEST_F(Cache, whatTheDiskHasNoRoomForIsToldAndLeavesNothing) {
  VolumeCache cache(directory_.path(), 1 << 30);
  UniqueFd snapshot = std::move(*built_.memfd.share()), volume = std::move(*built_.volume.share());
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit all{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &all), 0);
  const rlimit little{1000, all.rlim_max};
  testing::internal::CaptureStderr();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
  cache.keep("key", std::move(snapshot), std::move(volume), {});
  cache.wait();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &all), 0);
  (void)std::signal(SIGXFSZ, before);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("a volume is not kept on disk: " + directory_.path() + "/key.hvol.new: write: File too large"),
            std::string::npos)
      << said;
  EXPECT_TRUE(fs::is_empty(directory_.path()));
  const auto trouble = cache.trouble();
  ASSERT_TRUE(trouble.has_value());
  EXPECT_EQ(trouble->where, directory_.path() + "/key.hvol.new");
  EXPECT_NE(trouble->remedy.find("make room"), std::string::npos) << trouble->remedy;
  keep(cache, "key");
  EXPECT_TRUE(cache.find("key").has_value()) << "there is room again";
  EXPECT_FALSE(cache.trouble().has_value());
}

TEST_F(Cache, aFullDiskIsNoTroubleOnceThereIsRoom) {
  bool may = false;
  std::thread([&] {  // With mounts of its own, as the cache's writer then has.
    may = ::unshare(CLONE_NEWNS) == 0 && ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
          ::mount("none", directory_.path().c_str(), "tmpfs", 0, "size=1m") == 0;
    if (!may) return;
    const std::string other = directory_.path() + "/other";
    std::ofstream(other) << std::string(900'000, 'x');
    VolumeCache cache(directory_.path(), 1 << 30);
    keep(cache, "key");
    auto trouble = cache.trouble();
    ASSERT_TRUE(trouble.has_value());
    EXPECT_EQ(trouble->what, "write: No space left on device");
    EXPECT_EQ(trouble->remedy, "make room on the disk, or see builder.cache_mb");
    EXPECT_FALSE(fs::exists(directory_.path() + "/key.hvol.new"));
    EXPECT_TRUE(cache.trouble().has_value());
    fs::remove(other);
    EXPECT_FALSE(cache.trouble().has_value()) << "although none has been kept since";
  })
      .join();
  if (!may) GTEST_SKIP() << "it may mount nothing";
}

TEST_F(Cache, wantOfDescriptorsIsNoTroubleOnceThereAreSome) {
  VolumeCache cache(directory_.path(), 1 << 30);
  UniqueFd snapshot = std::move(*built_.memfd.share()), volume = std::move(*built_.volume.share());
  std::optional<Error> trouble;
  {
    const NoDescriptors none;
    cache.keep("key", std::move(snapshot), std::move(volume), {});
    cache.wait();
    trouble = cache.trouble();
  }
  ASSERT_TRUE(trouble.has_value());
  EXPECT_NE(trouble->remedy.find("LimitNOFILE"), std::string::npos) << trouble->remedy;
  EXPECT_FALSE(cache.trouble().has_value());
}

TEST_F(Cache, whatCannotTakeItsPlaceIsToldAndLeavesNothing) {
  VolumeCache cache(directory_.path(), 1 << 30);
  fs::create_directories(directory_.path() + "/key.hvol/in the way");
  testing::internal::CaptureStderr();
  keep(cache, "key");
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("a volume is not kept on disk: " + directory_.path() + "/key.hvol: Is a directory"),
            std::string::npos)
      << said;
  EXPECT_FALSE(fs::exists(directory_.path() + "/key.hvol.new"));
  EXPECT_FALSE(cache.find("key").has_value());
}

TEST_F(Cache, whatIsBeingWrittenAsTheDaemonEndsHearsItWithinAPart) {
  constexpr std::size_t kBytes = 64 << 20, kRead = 1 << 20;
  const std::string file = directory_.path() + "/" + keyNamed("large") + ".hvol.new";
  VolumeCache cache(directory_.path(), 1 << 30);
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  cache.keep(keyNamed("large"), std::move(*built_.memfd.share()), std::move(*Memfd::create("large", kBytes)->share()),
             {});
  std::ifstream disk(file, std::ios::binary);
  std::vector<char> read(kRead);
  disk.read(read.data(), kRead);
  cache.stop(0);
  disk.ignore(std::numeric_limits<std::streamsize>::max());  // To its end.
  EXPECT_LT(disk.gcount(), 2 * kDiskPart_bytes) << "of " << kBytes;
  cache.wait();
  EXPECT_TRUE(fs::is_empty(directory_.path())) << "nothing half written is left";
  EXPECT_FALSE(cache.trouble().has_value());
}

TEST_F(Cache, nothingIsReadAnyMoreForADaemonThatEnds) {
  VolumeCache cache(directory_.path(), 1 << 30);
  keep(cache, keyNamed("one"));
  ASSERT_TRUE(cache.find(keyNamed("one")).has_value());
  cache.stop();
  EXPECT_FALSE(cache.find(keyNamed("one")).has_value());
}

TEST_F(Cache, anUploadBuiltBeforeIsThereAtOnce) {
  MeshStore meshes;
  meshes.setLock(false);
  TextureStore textures;
  const Uploads* counted = nullptr;
  Uploads uploads(meshes, textures, [&](std::uint32_t uid, auto, std::uint64_t triangles) {
    EXPECT_TRUE(triangles == 0 || counted->bytesOf(uid) == 0) << "an upload does not count beside what it became";
    return Result<void>();
  });
  counted = &uploads;
  BuilderOptions options;
  options.program = HAPTICD_TEST_BUILDER;
  auto leash = BuilderLeash::start(options);
  ASSERT_TRUE(leash.ok()) << toString(leash.error());
  uploads.setBuilder(std::move(*leash));
  const auto send = [&](std::optional<Result<MeshInfo>>& done) {
    auto id = uploads.begin(upload_.size(), Client{});
    ASSERT_TRUE(id.ok()) << toString(id.error());
    auto memfd = Memfd::adopt(std::move(*uploads.region(*id)));
    ASSERT_TRUE(memfd.ok());
    {
      auto mapping = memfd->map(Memfd::Access::kWrite);
      std::memcpy(mapping->data(), upload_.data(), upload_.size());
    }
    ASSERT_TRUE(uploads.commit(*id, {}, [&](Result<MeshInfo> r) { done = std::move(r); }).ok());
  };
  const auto newCache = [&] {
    if (uploads.cache() != nullptr) uploads.cache()->wait();  // Its unfinished file a new one would remove.
    uploads.setCache(nullptr);
    uploads.setCache(std::make_unique<VolumeCache>(directory_.path(), 1 << 30));
  };
  newCache();
  std::optional<Result<MeshInfo>> first, second, third;
  const auto pollUntil = [&](auto done) {
    for (int i = 0; i < 10'000 && !done(); ++i) {
      pollfd ready{uploads.builder()->fd(), POLLIN, 0};
      (void)::poll(&ready, 1, 2);
      uploads.poll();
    }
  };
  send(first);
  EXPECT_FALSE(first.has_value()) << "nobody waits while it is looked up, built and checked";
  pollUntil([&] { return first.has_value(); });
  ASSERT_TRUE(first && first->ok()) << toString(first->error());
  EXPECT_GT(first->value().build_ns, 0);
  newCache();
  send(second);
  pollUntil([&] { return second.has_value(); });
  ASSERT_TRUE(second && second->ok()) << toString(second->error());
  EXPECT_EQ(second->value().build_ns, 0) << "no builder";
  const MeshInfo &a = first->value(), &b = second->value();
  EXPECT_NE(a.id, b.id);
  EXPECT_EQ(a.bytes, b.bytes);
  EXPECT_EQ(a.notes, b.notes);
  EXPECT_EQ(a.voxel, b.voxel);
  EXPECT_NE(meshes.volumes().get(meshes.entryOf(b.id)), nullptr);
  EXPECT_EQ(uploads.size(), 0u);

  // A damaged file costs a build, nothing else.
  const fs::path path = onlyFile();
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-5000, std::ios::end);
    file.put('x').put('y').put('z');
  }
  send(third);
  pollUntil([&] { return !uploads.busy(); });
  EXPECT_FALSE(third.has_value());
  EXPECT_FALSE(fs::exists(path));
  EXPECT_EQ(uploads.bytesOf(Client{}.uid), upload_.size()) << "the builder has it";
}

}  // namespace
}  // namespace hapticd::test
