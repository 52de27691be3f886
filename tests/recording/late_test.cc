// A servo that missed periods felt what its replay feels: how long a tick is, both know before its commands.
#include <gtest/gtest.h>

#include <future>
#include <optional>

#include "tests/recording/taken.h"
#include "tests/support/eventually.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {
namespace {

constexpr double kRise = 0.2;  ///< Of the cube's upper side [m/s].

/** A cube of 2 cm whose upper side a client moves up, vertex by vertex, under a hand that presses it. */
struct RisingSide {
  Bench bench;
  std::uint32_t object = 0;
  double z = 0.01;

  explicit RisingSide(const UploadMesh& shape = cube()) { object = add("cube", shape); }
  std::uint32_t add(const char* name, const UploadMesh& shape) {
    const Client root = bench.core.client(bench.administration);
    BuildMonitor monitor;
    auto snapshot = buildSnapshot(upload(shape, HD_MESH_DEFORMABLE), monitor);
    auto fd = snapshot->memfd.share();
    MeshInfo info;
    info.owner = root;
    const auto mesh = bench.core.meshes().add(std::move(*fd), info);
    EXPECT_TRUE(mesh.ok());
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {ShapeKind::kMesh, Vec3::Zero(), *mesh};
    spec.material = {500, 5, 0, 0};
    const auto id = bench.core.scene().create(spec, root);
    EXPECT_TRUE(id.ok());
    return *id;
  }
  /** A tick that comes `missed` periods late. */
  void rise(int missed) {
    bench.clock.advance(missed * kMs);
    z += kRise * 1e-3 * (1 + missed);
    hd_object_vertices moves{};
    moves.object = object;
    for (std::uint32_t v = 4; v < 8; ++v) {
      const float x = (v & 1) != 0 ? 0.01f : -0.01f, y = (v & 2) != 0 ? 0.01f : -0.01f;
      moves.move[moves.count++] = {v, {x, y, static_cast<float>(z)}};
    }
    std::uint64_t seq = 0;
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_VERTICES, std::as_bytes(std::span(&moves, 1)), 0, seq),
              ErrorCode::kOk);
    bench.scripted[0]->sample.p = {1e-3, 2e-3, z - 5e-4};
    bench.step();
  }
};

TEST(RecordingOfALateServo, MovesOfVerticesAreFeltAlike) {
  RisingSide side;
  Session* session = side.bench.live();
  ASSERT_NE(session, nullptr);
  side.bench.scripted[0]->sample.p = {1e-3, 2e-3, 0.02};
  side.bench.step(5);
  Taken taken(side.bench);
  ASSERT_TRUE(side.bench.arm(session->id).ok());
  side.bench.step(30);
  for (double z = 0.02; z > side.z - 5e-4; z -= 1e-4) {
    side.bench.scripted[0]->sample.p.z() = z;
    side.bench.step();
  }
  for (int i = 0; i < 60; ++i) side.rise(i % 10 == 0 ? 2 : 0);
  EXPECT_GT(side.bench.sample().force[2], 0.1) << "it must be felt";
  const auto verdict = verify(*replayerOf(taken.finish([&] { side.bench.step(); })));
  ASSERT_TRUE(verdict.ok());
  EXPECT_EQ(verdict->differing, 0u) << verdict->first;
}

TEST(RecordingOfADeformedMesh, BeginsWithItAsItIs) {
  RisingSide side;
  Session* session = side.bench.live();
  ASSERT_NE(session, nullptr);
  for (int i = 0; i < 40; ++i) side.rise(0);
  side.bench.scripted[0]->sample.p = {1e-3, 2e-3, 0.03};
  side.bench.step(5);
  Taken taken(side.bench);
  ASSERT_TRUE(side.bench.arm(session->id).ok());
  side.bench.step(30);
  for (double z = 0.03; z > side.z - 5e-4; z -= 1e-4) {
    side.bench.scripted[0]->sample.p.z() = z;
    side.bench.step();
  }
  EXPECT_GT(side.bench.sample().force[2], 0.1) << "it must be felt, and where it is now";
  const auto verdict = verify(*replayerOf(taken.finish([&] { side.bench.step(); })));
  ASSERT_TRUE(verdict.ok());
  EXPECT_EQ(verdict->differing, 0u) << verdict->first;
}

/** Pages for many triangles take 0.2 s, in which somebody may want to stop a device. */
TEST(RecordingOfADeformedMesh, WaitsForCopiesOfWhatIsLarge) {
  RisingSide side(torus(300, 200));
  ASSERT_NE(side.bench.live(), nullptr);
  side.rise(0);
  side.bench.step(5);
  std::promise<void> go;
  side.bench.core.recordings().copies().start(
      [wait = go.get_future().share()]() -> Result<int> {
        wait.wait();
        return 0;
      },
      [](const Result<int>&) {});
  std::optional<bool> began;
  side.bench.core.record("", side.bench.administration,
                         [&](const Result<Recordings::Started>& started) { began = started.ok(); });
  side.bench.step(10);
  EXPECT_FALSE(began.has_value());
  EXPECT_EQ(side.bench.core.recordings().copies().size(), 2u);
  go.set_value();
  EXPECT_TRUE(eventually([&] {
    side.bench.step();
    return began.has_value();
  }));
  EXPECT_EQ(began, true);
}

/** Who may not record is told so before anything is copied for him. */
TEST(RecordingOfADeformedMesh, IsRefusedAtOnceWhereItMayNotBegin) {
  RisingSide side(torus(300, 200));
  Session* const session = side.bench.live();
  ASSERT_NE(session, nullptr);
  side.rise(0);
  side.bench.step(50);  // The hand has come to rest.
  ASSERT_TRUE(side.bench.arm(session->id).ok());
  Core& core = side.bench.core;
  const auto ask = [&](std::uint64_t by) {
    std::optional<ErrorCode> answer;
    core.record("", by, [&](const Result<Recordings::Started>& started) {
      answer = started ? ErrorCode::kOk : started.error().code;
    });
    return answer;
  };
  EXPECT_EQ(ask(side.bench.administration), ErrorCode::kInvalidArgument) << "it is armed";
  EXPECT_EQ(ask(*core.connect(102, 1001, false)), ErrorCode::kPermissionDenied) << "another user has a session there";
  EXPECT_EQ(core.recordings().copies().size(), 0u);
}

/** Else what is deformed while another is copied would be copied by who must be there to stop a device. */
TEST(RecordingOfADeformedMesh, WaitsForCopiesOfWhatWasDeformedMeanwhile) {
  RisingSide side(torus(300, 200));
  const std::uint32_t other = side.add("other", torus(300, 201));
  ASSERT_NE(side.bench.live(), nullptr);
  side.rise(0);
  side.bench.step(5);
  Core& core = side.bench.core;
  Aside& copies = core.recordings().copies();
  std::promise<void> first, second, first_copied;
  const auto hold = [&](std::promise<void>& until, std::promise<void>* begun) {
    copies.start(
        [begun, wait = until.get_future().share()]() -> Result<int> {
          if (begun != nullptr) begun->set_value();
          wait.wait();
          return 0;
        },
        [](const Result<int>&) {});
  };
  hold(first, nullptr);
  std::optional<bool> began;
  core.record("", side.bench.administration, [&](const Result<Recordings::Started>& started) { began = started.ok(); });
  hold(second, &first_copied);
  side.object = other;
  side.rise(0);
  side.bench.step();
  first.set_value();
  first_copied.get_future().wait();
  for (int i = 0; i < 3; ++i) core.poll();  // The clock stands: the wish has time.
  EXPECT_FALSE(began.has_value());
  EXPECT_EQ(copies.size(), 2u) << "what holds them up, and the copy of the other";
  second.set_value();
  EXPECT_TRUE(eventually([&] {
    core.poll();
    return began.has_value();
  }));
  EXPECT_EQ(began, true);
}

}  // namespace
}  // namespace hapticd::test
