// What subscribers are told of who comes and goes: clients, devices, objects.
#include <unistd.h>

#include "tests/session/bench.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {
namespace {

struct Told : testing::Test {
  /** What has been published of that kind since the last look. */
  std::vector<Event> heard(EventKind kind) {
    for (EventHub::Batch batch = hub().take(listener); !batch.events.empty(); batch = hub().take(listener))
      all_.insert(all_.end(), batch.events.begin(), batch.events.end());
    std::vector<Event> of_kind;
    std::erase_if(all_, [&](const Event& event) {
      if (event.kind == kind) of_kind.push_back(event);
      return event.kind == kind;
    });
    return of_kind;
  }
  EventHub& hub() { return bench.core.events(); }

  Bench bench;
  std::uint64_t listener = hub().subscribe(0, [] {});

 private:
  std::vector<Event> all_;
};

TEST_F(Told, AClientJoinsOnceAndLeavesOnce) {
  const std::uint64_t guest = *bench.core.connect(7, 1001, false);
  EXPECT_TRUE(heard(EventKind::kClientJoined).empty()) << "it has no name yet";
  bench.core.introduce(guest, "guest");
  const auto joined = heard(EventKind::kClientJoined);
  ASSERT_EQ(joined.size(), 1u);
  EXPECT_EQ(joined.front().text, "guest");
  EXPECT_EQ(joined.front().t_ns, bench.clock.now());
  bench.core.introduce(guest, "renamed");
  EXPECT_TRUE(heard(EventKind::kClientJoined).empty());
  EXPECT_EQ(bench.core.client(guest).name, "renamed");
  bench.core.disconnect(guest);
  const auto left = heard(EventKind::kClientLeft);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left.front().text, "renamed");
  bench.core.disconnect(guest);
  bench.core.introduce(guest, "ghost");
  EXPECT_TRUE(heard(EventKind::kClientLeft).empty());
  EXPECT_TRUE(heard(EventKind::kClientJoined).empty());
  EXPECT_EQ(bench.core.clients().all().count(guest), 0u);
}

TEST_F(Told, WhoNeverSaidANameComesAndGoesUnheard) {
  const std::uint64_t mute = *bench.core.connect(7, 1001, false);
  bench.core.disconnect(mute);
  EXPECT_TRUE(heard(EventKind::kClientLeft).empty());
}

/** However it was opened, and not when it is asked for again. */
TEST_F(Told, ADeviceIsAddedOnce) {
  const auto added = [&](const char* uri) {
    const auto events = heard(EventKind::kDeviceAdded);
    ASSERT_EQ(events.size(), 1u) << uri;
    EXPECT_EQ(events.front().text, uri);
    EXPECT_EQ(events.front().device, bench.core.devices().devices().back()->name);
  };
  ASSERT_TRUE(bench.core.openDevice("sim://default?mass=0.3", bench.connection).ok());
  added("sim://default?mass=0.3");
  ASSERT_TRUE(bench.core.openDevice("sim://default?mass=0.3", bench.connection).ok());
  ASSERT_TRUE(bench.core.openDevice("sim://default?mass=0.3").ok());
  EXPECT_TRUE(heard(EventKind::kDeviceAdded).empty());
  ASSERT_TRUE(bench.core.openDevice("sim://default?mass=0.5").ok());
  added("sim://default?mass=0.5");

  bool open = false;
  bench.core.openDevice("sim://default?mass=0.4", bench.connection, [&](const auto& device) { open = device.ok(); });
  for (int i = 0; i < 5000 && !open; ++i) {
    bench.step();
    ::usleep(1000);
  }
  ASSERT_TRUE(open);
  added("sim://default?mass=0.4");
  ASSERT_TRUE(bench.core.closeDevice("sim://default?mass=0.4", bench.administration).ok());
  EXPECT_EQ(heard(EventKind::kDeviceRemoved).size(), 1u);
}

/** Whoever asks for that again and again is heard in the moment in which the servo has disarmed it. */
TEST_F(Told, ADeviceThatIsClosedAsSoonAsItMayIsDisarmedBefore) {
  Session* const session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  bench.core.sessions().end(session->id, "test");
  bench.client.reset();
  bool closed = false;
  for (int i = 0; i < 2000 && !closed; ++i) {
    bench.core.poll();
    bench.core.devices().links().front()->group().step();
    closed = bench.core.closeDevice("test://first", bench.administration).ok();
  }
  ASSERT_TRUE(closed);
  bench.step(2);
  std::vector<EventKind> told;
  for (const Event& event : hub().take(listener).events) {
    if (event.kind == EventKind::kArmed || event.kind == EventKind::kDisarmed ||
        event.kind == EventKind::kDeviceRemoved)
      told.push_back(event.kind);
  }
  EXPECT_EQ(told, (std::vector{EventKind::kArmed, EventKind::kDisarmed, EventKind::kDeviceRemoved}));
}

TEST_F(Told, WhatTheAdministratorsOwnCodeOpenedStays) {
  ASSERT_TRUE(bench.core.openDevice("sim://default?mass=0.3").ok());
  bench.step(50);
  EXPECT_EQ(bench.core.devices().devices().size(), 2u);
}

TEST_F(Told, AnObjectsChangesWithItsName) {
  ObjectSpec spec;
  spec.name = "ball";
  spec.shape = {ShapeKind::kSphere, Vec3(0.02, 0, 0), 0};
  spec.material = kDefaultMaterial;
  ASSERT_TRUE(bench.core.scene().create(spec, bench.core.client(bench.connection)).ok());
  const auto made = heard(EventKind::kObjectChanged);
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made.front().object, "ball");
  EXPECT_EQ(made.front().text, "created");
  EXPECT_EQ(made.front().t_ns, bench.clock.now());
  bench.core.disconnect(bench.connection);
  const auto gone = heard(EventKind::kObjectChanged);
  ASSERT_EQ(gone.size(), 1u);
  EXPECT_EQ(gone.front().object, "ball");
}

/** By ingest, which checks values, and by the servo, which knows the scene. */
TEST_F(Told, WhatAClientPushedAndWasRefused) {
  const Session* const session = bench.live();
  ASSERT_NE(session, nullptr);
  std::uint64_t seq = 0;
  const auto push = [&](std::uint32_t object, double qw) {
    hd_object_pose pose{};
    pose.object = object;
    pose.q[0] = qw;
    const auto bytes = std::as_bytes(std::span(&pose, 1));
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, bytes, 0, seq), ErrorCode::kOk);
  };
  push(77, 1);
  bench.step(5);
  auto refused = heard(EventKind::kRefused);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_EQ(refused.front().session, session->id);
  EXPECT_EQ(refused.front().value, static_cast<std::uint32_t>(ErrorCode::kNotFound));
  EXPECT_EQ(refused.front().text, "a pose: no object, device, mesh or path of that name");

  push(77, 2);
  bench.step(5);
  refused = heard(EventKind::kRefused);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_EQ(refused.front().session, session->id);
  EXPECT_EQ(refused.front().value, static_cast<std::uint32_t>(ErrorCode::kInvalidArgument));
  EXPECT_EQ(refused.front().text.find("command 2: "), 0u) << refused.front().text;

  for (int i = 0; i < 100; ++i) {
    push(77, 1);
    bench.step();
  }
  EXPECT_LT(heard(EventKind::kRefused).size(), 6u) << "a flood of one is not everybody's";
  bench.step(1000);
  push(77, 1);
  bench.step(5);
  refused = heard(EventKind::kRefused);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused.front().text.find("suppressed"), std::string::npos) << refused.front().text;
}

TEST_F(Told, NothingOfWhatAClientStillMovedAsItLeftWithItsObjects) {
  ASSERT_NE(bench.live(), nullptr);
  ObjectSpec spec;
  spec.name = "ball";
  const auto ball = bench.core.scene().create(spec, bench.core.client(bench.connection));
  ASSERT_TRUE(ball.ok());
  bench.step(5);
  hd_object_pose pose{};
  pose.object = *ball;
  pose.q[0] = 1;
  std::uint64_t seq = 0;
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&pose, 1)), 0, seq),
              ErrorCode::kOk);
  }
  bench.core.disconnect(bench.connection);
  bench.step(100);
  EXPECT_EQ(heard(EventKind::kRefused).size(), 0u);
}

TEST_F(Told, OfItsLastMistakeWhoEndsItsSessionAlone) {
  const Session* const session = bench.live();
  ASSERT_NE(session, nullptr);
  hd_object_pose pose{};
  pose.object = 77;
  pose.q[0] = 1;
  std::uint64_t seq = 0;
  ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&pose, 1)), 0, seq),
            ErrorCode::kOk);
  bench.core.sessions().end(session->id, "for the test");
  bench.step(100);
  EXPECT_EQ(heard(EventKind::kRefused).size(), 1u);
}

TEST_F(Told, AVertexThatTheObjectDoesNotHaveIsNotTakenForTheObject) {
  ASSERT_NE(bench.live(), nullptr);
  BuildMonitor monitor;
  const auto built = buildSnapshot(upload(cube(), HD_MESH_DEFORMABLE), monitor);
  ASSERT_TRUE(built.ok());
  const auto mesh = bench.core.meshes().add(std::move(*built->memfd.share()), {});
  ASSERT_TRUE(mesh.ok());
  ObjectSpec spec;
  spec.name = "cube";
  spec.shape = {ShapeKind::kMesh, Vec3::Zero(), *mesh};
  const auto object = bench.core.scene().create(spec, bench.core.client(bench.administration));
  ASSERT_TRUE(object.ok());
  std::uint64_t seq = 0;
  for (const std::uint32_t id : {*object, 77u}) {
    hd_object_vertices moves{id, 1, {}};
    moves.move[0].index = 8;
    const auto bytes = std::as_bytes(std::span(&moves, 1));
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_VERTICES, bytes, 0, seq), ErrorCode::kOk);
  }
  bench.step(5);
  const auto refused = heard(EventKind::kRefused);
  ASSERT_EQ(refused.size(), 2u);
  EXPECT_EQ(refused[0].text,
            "moves of vertices of object 'cube': it has no vertex of that number, or the servo has yet to hear of it");
  EXPECT_EQ(refused[1].text, "moves of vertices: no object, device, mesh or path of that name");
}

}  // namespace
}  // namespace hapticd::test
