// What counts against a user's memory and triangles, and what the servos keep locked: to the byte, and given back.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <optional>

#include "daemon/builder/build.h"
#include "tests/session/bench.h"
#include "tests/session/holding_device.h"
#include "tests/support/shape/texture_upload.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {
namespace {

constexpr std::uint64_t kMB = 1'000'000;

struct Accounting : testing::Test {
  static Config small() {
    Config config = Bench::relaxed();
    config.quotas.memory_mb = static_cast<double>(kMost / kMB);
    config.quotas.triangles = 1000;
    config.quotas.objects = 2;
    return config;
  }
  [[nodiscard]] Client mine() const { return bench.core.client(bench.connection); }
  [[nodiscard]] std::uint64_t bytes() const { return bench.core.bytesOf(mine().uid); }

  MeshInfo addMesh(const Client& by) {
    BuildMonitor monitor;
    auto snapshot = buildSnapshot(upload(torus(12, 8)), monitor);
    EXPECT_TRUE(snapshot.ok());
    MeshInfo info;
    info.owner = by;
    auto fd = snapshot->memfd.share();
    EXPECT_TRUE(fd.ok());
    const auto id = bench.core.meshes().add(std::move(*fd), info);
    EXPECT_TRUE(id.ok()) << toString(id.error());
    return *bench.core.meshes().find(*id);
  }
  TextureInfo addTexture(const Client& by) {
    auto texture = parseTexture(vibrationUpload());
    EXPECT_TRUE(texture.ok());
    const auto id = bench.core.scene().textures().add(std::move(*texture), by);
    EXPECT_TRUE(id.ok()) << toString(id.error());
    return *bench.core.scene().textures().find(*id);
  }
  [[nodiscard]] ErrorCode check(std::uint64_t more, std::uint64_t triangles = 0) const {
    const auto may = bench.core.checkQuota(mine().uid, more, triangles);
    return may ? ErrorCode::kOk : may.error().code;
  }
  /** Steps until the recorder's thread has ended, too. */
  void untilNoRecording() {
    for (int i = 0; i < 5000 && bench.core.recordings().size() != 0; ++i) {
      bench.step();
      ::usleep(1000);
    }
    EXPECT_EQ(bench.core.recordings().size(), 0u);
  }

  static constexpr std::uint64_t kMost = (sizeof(CycleLog) / kMB + 4) * kMB;
  Bench bench{small()};
  const std::uint64_t other = *bench.core.connect(102, 1001, false);
};

/** Each is counted for its user alone, the user may have just as much more as is left, and it comes back. */
TEST_F(Accounting, EachThingCountsForItsUserUntilItIsGone) {
  struct Counted {
    const char* what;
    std::function<std::uint64_t()> take;  ///< How many bytes it is to count for.
    std::uint64_t locked;                 ///< [bytes], 1 for the same.
    std::function<void()> give_back;
  };
  std::uint64_t id = 0;
  const auto session = [&] {
    const auto made = bench.core.openSession("", bench.connection, "t", HD_SHM_MAJOR, HD_SHM_MINOR);
    EXPECT_TRUE(made.ok());
    id = (*made)->id;
    return kSessionBytes;
  };
  const auto upload = [&] {
    id = *bench.core.uploads().begin(123'456, mine());
    return std::uint64_t{123'456};
  };
  const auto mesh = [&] {
    const MeshInfo info = addMesh(mine());
    id = info.id;
    return info.bytes;
  };
  const auto texture = [&] {
    const TextureInfo info = addTexture(mine());
    id = info.id;
    return 2 * info.bytes;  // As it was uploaded, and as the one servo reads it.
  };
  const auto recording = [&] {
    auto started = bench.core.record("", bench.connection);
    EXPECT_TRUE(started.ok()) << toString(started.error());
    id = started->id;
    return std::uint64_t{sizeof(CycleLog)};
  };
  const std::uint64_t of_texture = layOutBytes(*parseTexture(vibrationUpload()));
  const Counted all[] = {
      {"session", session, 1, [&] { bench.core.sessions().end(id, "test"); }},
      {"upload", upload, 0, [&] { bench.core.uploads().cancel(id); }},
      {"mesh", mesh, 1, [&] { EXPECT_TRUE(bench.core.meshes().drop(id, mine()).ok()); }},
      {"texture", texture, of_texture, [&] { EXPECT_TRUE(bench.core.scene().textures().drop(id, mine()).ok()); }},
      {"recording", recording, 1, [&] { bench.core.recordings().drop(id), untilNoRecording(); }},
  };
  const std::uint64_t locked = bench.core.lockedBytes();
  for (const Counted& one : all) {
    ASSERT_EQ(bytes(), 0u) << one.what;
    const std::uint64_t taken = one.take();
    EXPECT_EQ(bytes(), taken) << one.what;
    EXPECT_EQ(bench.core.lockedBytes() - locked, one.locked == 1 ? taken : one.locked) << one.what;
    EXPECT_EQ(check(kMost - taken), ErrorCode::kOk) << one.what;
    EXPECT_EQ(check(kMost - taken + 1), ErrorCode::kQuotaExceeded) << one.what;
    EXPECT_EQ(bench.core.bytesOf(bench.core.client(other).uid), 0u) << one.what;
    one.give_back();
    bench.step(100);
    EXPECT_EQ(bytes(), 0u) << one.what;
    EXPECT_EQ(bench.core.lockedBytes(), locked) << one.what;
  }
}

TEST_F(Accounting, AGroupsMonitorIsLocked) {
  const std::uint64_t before = bench.core.lockedBytes();
  ASSERT_TRUE(bench.core.openDevice("sim://default?mass=0.3", bench.connection).ok());
  EXPECT_EQ(bench.core.lockedBytes() - before, GroupLink::monitorBytes());
}

/** Whether it is waited for or not; who may not have it has none open, and hears what to do. */
TEST_F(Accounting, ARecordedMotionCountsForWhoeverHasAskedForIt) {
  const auto open = std::make_shared<std::atomic<int>>(0);
  std::size_t holds = 0;
  bench.core.devices().setFactory([&](std::string_view uri) -> Result<std::unique_ptr<Device>> {
    return std::unique_ptr<Device>(std::make_unique<HoldingDevice>(std::string(uri), holds, open));
  });
  const auto ask = [&](const char* uri, std::uint64_t by, bool waits) -> Result<void> {
    if (waits) {
      const auto device = bench.core.openDevice(uri, by);
      return device ? Result<void>() : device.error();
    }
    std::optional<Result<void>> answer;
    bench.core.openDevice(
        uri, by, [&](const Result<OpenDevice*>& device) { answer = device ? Result<void>() : device.error(); });
    while (!answer) bench.step();
    return *answer;
  };
  const std::uint64_t others = bench.core.client(other).uid;
  for (const bool waits : {true, false}) {
    SCOPED_TRACE(waits);
    holds = kMost + 1;
    const auto refused = ask("sim://default?mass=0.1", bench.connection, waits);
    ASSERT_EQ(refused.error().code, ErrorCode::kQuotaExceeded);
    EXPECT_NE(refused.error().remedy.find("thin the file out"), std::string::npos) << refused.error().remedy;
    EXPECT_EQ(*open, 0);
    EXPECT_EQ(bench.core.devices().devices().size(), 1u);
    holds = kMost;
    const std::uint64_t locked = bench.core.lockedBytes();
    ASSERT_TRUE(ask("sim://default?mass=0.2", bench.connection, waits).ok());
    EXPECT_EQ(bytes(), holds);
    EXPECT_EQ(bench.core.lockedBytes() - locked, holds + GroupLink::monitorBytes());
    EXPECT_EQ(check(1), ErrorCode::kQuotaExceeded);
    EXPECT_EQ(ask("sim://default?mass=0.3", bench.connection, waits).error().code, ErrorCode::kQuotaExceeded);
    ASSERT_TRUE(ask("sim://default?mass=0.2", other, waits).ok());
    EXPECT_EQ(bench.core.bytesOf(others), 0u) << "it is there once";
    ASSERT_TRUE(bench.core.closeDevice("sim://default?mass=0.2", bench.administration).ok());
    EXPECT_EQ(bytes(), 0u);
    EXPECT_EQ(bench.core.lockedBytes(), locked);
    EXPECT_EQ(*open, 0);
    holds = kMost + 1;
    ASSERT_TRUE(ask("sim://default?mass=0.4", bench.administration, waits).ok()) << "his own choice";
    EXPECT_EQ(bench.core.bytesOf(0), 0u);
    ASSERT_TRUE(bench.core.closeDevice("sim://default?mass=0.4", bench.administration).ok());
  }
  holds = kMost;
  ASSERT_TRUE(ask("sim://default?mass=0.5", bench.connection, true).ok());
  ASSERT_TRUE(ask("sim://default?mass=0.5", other, true).ok());
  bench.core.disconnect(bench.connection);
  EXPECT_EQ(bench.core.bytesOf(others), holds) << "who stays has it from then on";
}

/** Servos read one copy of a relief, and each its own of a mesh that can be deformed: all of them must fit. */
TEST_F(Accounting, CopiesForServosAreAskedForBeforeTheyAreMade) {
  for (const char* uri : {"test://two", "test://three"}) ASSERT_TRUE(bench.core.openDevice(uri, bench.connection).ok());
  constexpr std::uint32_t kSide = 512;
  const auto pixels = reliefUpload(kSide, kSide, std::vector<std::uint16_t>(std::size_t{kSide} * kSide));
  const auto commit = [&](std::uint64_t filled) {
    const auto other_upload = filled > 0 ? bench.core.uploads().begin(filled, mine()) : Result<std::uint64_t>(0);
    EXPECT_TRUE(other_upload.ok());
    const std::uint64_t id = *bench.core.uploads().begin(pixels.size(), mine());
    EXPECT_EQ(::pwrite(bench.core.uploads().region(id)->get(), pixels.data(), pixels.size(), 0), std::ssize(pixels));
    std::optional<Result<std::uint64_t>> made;
    EXPECT_TRUE(bench.core.uploads().commitTexture(id, [&](Result<std::uint64_t> r) { made = std::move(r); }).ok());
    for (int i = 0; i < 5000 && !made; ++i) {
      EXPECT_LE(bytes(), kMost);
      bench.step();
      ::usleep(1000);
    }
    EXPECT_LE(bytes(), kMost);
    if (!made) return ErrorCode::kTimeout;
    if (filled > 0) bench.core.uploads().cancel(*other_upload);
    return *made ? ErrorCode::kOk : made->error().code;
  };
  const std::uint64_t needed = 2 * layOutBytes(*parseTexture(pixels));  // With what was uploaded.
  EXPECT_EQ(commit(kMost - needed + 1), ErrorCode::kQuotaExceeded);
  EXPECT_EQ(commit(kMost - needed), ErrorCode::kOk);
  EXPECT_EQ(bytes(), needed);

  for (const std::uint32_t flags : {0u, static_cast<std::uint32_t>(HD_MESH_DEFORMABLE)}) {
    const std::uint64_t before = bytes();
    BuildMonitor monitor;
    const auto built = buildSnapshot(upload(torus(12, 8), flags), monitor);
    ASSERT_TRUE(built.ok());
    UniqueFd snapshot = std::move(*built->memfd.share());
    const std::uint64_t told = bench.core.meshes().bytesFor(snapshot, UniqueFd());
    MeshInfo info;
    info.owner = mine();
    ASSERT_TRUE(bench.core.meshes().add(std::move(snapshot), info).ok());
    EXPECT_EQ(told, bytes() - before) << flags;
  }
}

TEST_F(Accounting, NoSumOverflows) {
  EXPECT_EQ(check(kMost), ErrorCode::kOk);
  EXPECT_EQ(check(UINT64_MAX), ErrorCode::kQuotaExceeded);
  const auto upload = bench.core.uploads().begin(1000, mine());
  ASSERT_TRUE(upload.ok());
  EXPECT_EQ(check(UINT64_MAX), ErrorCode::kQuotaExceeded);
  EXPECT_EQ(check(0, UINT64_MAX), ErrorCode::kQuotaExceeded);
}

TEST_F(Accounting, TrianglesAreCountedPerUser) {
  const std::uint64_t each = addMesh(mine()).triangles;
  ASSERT_EQ(each, 192u);
  EXPECT_EQ(check(0, 1000 - each), ErrorCode::kOk);
  EXPECT_EQ(check(0, 1000 - each + 1), ErrorCode::kQuotaExceeded);
  EXPECT_EQ(bench.core.checkQuota(mine().uid, 0, 1000).error().where, "triangles");
  EXPECT_TRUE(bench.core.checkQuota(bench.core.client(other).uid, 0, 1000).ok());
}

TEST_F(Accounting, ObjectsAreCountedPerUser) {
  const auto add = [&](const char* name, const Client& by) {
    ObjectSpec spec;
    spec.name = name;
    spec.material = kDefaultMaterial;
    const auto made = bench.core.scene().create(spec, by);
    return made ? ErrorCode::kOk : made.error().code;
  };
  EXPECT_EQ(add("a", mine()), ErrorCode::kOk);
  EXPECT_EQ(add("b", mine()), ErrorCode::kOk);
  EXPECT_EQ(add("c", mine()), ErrorCode::kQuotaExceeded);
  EXPECT_EQ(add("c", bench.core.client(other)), ErrorCode::kOk);
}

/** A recording that does not fit is refused before anything of it begins. */
TEST_F(Accounting, ARecordingTakesItsRoomFromTheUsersMemory) {
  const auto filled = bench.core.uploads().begin(kMost - sizeof(CycleLog) + 1, mine());
  ASSERT_TRUE(filled.ok()) << toString(filled.error());
  const auto refused = bench.core.record("", bench.connection);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kQuotaExceeded);
  EXPECT_EQ(refused.error().where, "memory");
  EXPECT_EQ(bench.core.recordings().size(), 0u);
  bench.core.uploads().cancel(*filled);
  ASSERT_TRUE(bench.core.uploads().begin(kMost - sizeof(CycleLog), mine()).ok());
  const auto fits = bench.core.record("", bench.connection);
  ASSERT_TRUE(fits.ok()) << toString(fits.error());
  bench.core.recordings().drop(fits->id);
  untilNoRecording();
}

/** Its client may die with anything half done. */
TEST_F(Accounting, WhoLeavesLeavesNothing) {
  const std::uint64_t locked = bench.core.lockedBytes();
  ASSERT_TRUE(bench.core.openSession("", bench.connection, "t", HD_SHM_MAJOR, HD_SHM_MINOR).ok());
  const Session* live = bench.live();
  ASSERT_NE(live, nullptr);
  (void)addMesh(mine());
  (void)addTexture(mine());
  const Client theirs = bench.core.client(other);
  const std::uint64_t kept = addMesh(theirs).bytes;
  const std::uint32_t user = mine().uid;
  bench.core.disconnect(bench.connection);
  bench.client.reset();
  bench.step(200);
  EXPECT_EQ(bench.core.bytesOf(user), 0u);
  EXPECT_TRUE(bench.core.scene().textures().list().empty());
  ASSERT_EQ(bench.core.meshes().list().size(), 1u) << "of whoever is still there";
  EXPECT_EQ(bench.core.lockedBytes(), locked + kept);
  EXPECT_EQ(bench.core.meshes().trianglesOf(user), 0u);
  bench.core.disconnect(bench.connection);  // Once is enough.
  EXPECT_EQ(bench.core.lockedBytes(), locked + kept);
}

/** What is checked aside counts all the while, and is forgotten with its upload. */
TEST_F(Accounting, ATextureThatIsGivenUpWhileItIsCheckedLeavesNothing) {
  const auto pixels = reliefUpload(64, 64, std::vector<std::uint16_t>(64 * 64));
  const std::uint64_t id = *bench.core.uploads().begin(pixels.size(), mine());
  EXPECT_EQ(::pwrite(bench.core.uploads().region(id)->get(), pixels.data(), pixels.size(), 0), std::ssize(pixels));
  bool told = false;
  ASSERT_TRUE(bench.core.uploads().commitTexture(id, [&](const Result<std::uint64_t>&) { told = true; }).ok());
  EXPECT_EQ(bench.core.uploads().commitTexture(id, [](const Result<std::uint64_t>&) {}).error().code,
            ErrorCode::kAlreadyExists);
  EXPECT_EQ(bytes(), pixels.size());
  bench.core.uploads().cancel(id);
  EXPECT_EQ(bytes(), pixels.size()) << "who fills and gives up one after the other has all the machine's memory else";
  bench.core.uploads().cancel(id);
  EXPECT_EQ(bench.core.uploads().commitTexture(id, [](const Result<std::uint64_t>&) {}).error().code,
            ErrorCode::kNotFound);
  for (int i = 0; i < 5000 && bench.core.uploads().busy(); ++i) {
    bench.step();
    ::usleep(1000);
  }
  EXPECT_FALSE(bench.core.uploads().busy());
  EXPECT_FALSE(told);
  EXPECT_EQ(bytes(), 0u);
  EXPECT_TRUE(bench.core.scene().textures().list().empty());
}

/** Each client has its turn, and what nobody waits for any more is not worked on. */
TEST_F(Accounting, AFloodOfTexturesDelaysItsOwnClients) {
  constexpr int kEach = 4;
  const auto pixels = reliefUpload(64, 64, std::vector<std::uint16_t>(64 * 64));
  std::vector<std::uint64_t> told;
  const auto commit = [&](std::uint64_t connection) {
    const std::uint64_t id = *bench.core.uploads().begin(pixels.size(), bench.core.client(connection));
    EXPECT_EQ(::pwrite(bench.core.uploads().region(id)->get(), pixels.data(), pixels.size(), 0), std::ssize(pixels));
    EXPECT_TRUE(bench.core.uploads()
                    .commitTexture(id,
                                   [&told, connection](const Result<std::uint64_t>& made) {
                                     EXPECT_TRUE(made.ok()) << toString(made.error());
                                     told.push_back(connection);
                                   })
                    .ok());
  };
  std::promise<void> go;
  bench.core.uploads().aside().start(
      [&]() -> Result<int> {
        go.get_future().wait();
        return 0;
      },
      [](const Result<int>&) {});
  for (int i = 0; i < 4; ++i) {
    const std::uint64_t flood = *bench.core.connect(200 + i, static_cast<std::uint32_t>(2000 + i), false);
    for (int j = 0; j < kEach; ++j) commit(flood);
  }
  commit(bench.connection);
  go.set_value();
  for (int i = 0; i < 5000 && told.size() < 4 * kEach + 1; ++i) {
    bench.step();
    ::usleep(1000);
  }
  ASSERT_EQ(told.size(), 4u * kEach + 1);
  EXPECT_LE(std::find(told.begin(), told.end(), bench.connection) - told.begin(), 4) << "one of each flood before it";
}

/** Else one would take the last place of all. */
TEST_F(Accounting, NobodyTakesAllPlacesOfTextures) {
  const auto add = [&](std::uint64_t by) {
    const auto made = bench.core.scene().textures().add(*parseTexture(vibrationUpload()), bench.core.client(by));
    return made ? ErrorCode::kOk : made.error().code;
  };
  for (std::uint32_t i = 0; i < kMaxTextures * 3 / 4; ++i) ASSERT_EQ(add(bench.connection), ErrorCode::kOk) << i;
  EXPECT_EQ(add(bench.connection), ErrorCode::kQuotaExceeded);
  for (std::uint32_t i = 0; i < kMaxTextures / 4; ++i) ASSERT_EQ(add(other), ErrorCode::kOk) << i;
  EXPECT_EQ(add(other), ErrorCode::kQuotaExceeded) << "there are no more";
}

}  // namespace
}  // namespace hapticd::test
