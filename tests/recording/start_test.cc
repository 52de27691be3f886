// Where a recording begins: the group's state is kept, who may not record is refused, nothing is left behind.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "daemon/resource/resource_tree.h"
#include "tests/recording/taken.h"
#include "tests/support/stepped/messages.h"

namespace hapticd::test {
namespace {

ObjectSpec ball(const char* name, const Vec3& p) {
  ObjectSpec spec;
  spec.name = name;
  spec.shape = {ShapeKind::kSphere, Vec3(0.02, 0, 0), 0};
  spec.X_PO.p = p;
  spec.material = {700, 1, 0.5, 0.3};
  return spec;
}

template <class T>
void push(Bench& bench, std::uint32_t kind, const T& payload, std::uint64_t at_tick = 0) {
  std::uint64_t seq = 0;
  ASSERT_EQ(bench.client->producer->push(kind, std::as_bytes(std::span(&payload, 1)), at_tick, seq), ErrorCode::kOk);
}

const Cycle& cycleOf(Bench& bench) { return bench.core.devices().links().front()->group().servo().cycle(); }

/** Whether it comes to that while the servo goes on. */
template <class Condition>
bool stepUntil(Bench& bench, Condition&& condition) {
  return eventually([&] {
    if (!condition()) bench.step();
    return condition();
  });
}

TEST(RecordingStart, KeepsSceneSessionsLimitsAndFaults) {
  Bench bench;
  const Client root = bench.core.client(bench.administration);
  const auto near = bench.core.scene().create(ball("near", Vec3(0, 0, 0.1)), root);
  ObjectSpec child = ball("child", Vec3(0.05, 0, 0));
  child.parent = "near";
  const auto below = bench.core.scene().create(child, root);
  ASSERT_TRUE(near.ok() && below.ok());
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  hd_object_pose pose = goodPose();
  pose.object = *near;
  push(bench, HD_COMMAND_OBJECT_POSE, pose);
  push(bench, HD_COMMAND_LIMITS, goodLimits());
  hd_local_model model = goodModel(HD_MODEL_PLANE);
  model.lease_ns = 1'000 * kMs;
  push(bench, HD_COMMAND_LOCAL_MODEL, model);
  hd_client_force force = goodForce();
  force.lease_ns = 1'000 * kMs;
  push(bench, HD_COMMAND_CLIENT_FORCE, force);
  bench.step(5);
  const std::uint64_t tick = bench.sample().tick;
  hd_object_material waits{*below, 0, {900, 2, 0.7, 0.6}};
  push(bench, HD_COMMAND_OBJECT_MATERIAL, waits, tick + 40);
  GuardLimits lowered = bench.device().limits;
  lowered.force = 1.25;
  ASSERT_TRUE(bench.core.setLimits("", lowered, bench.administration).ok());
  bench.scripted.front()->sample.status = kDeviceError;
  bench.step(3);
  bench.scripted.front()->sample.status = kDeviceOk;
  bench.step(2);

  const Cycle& cycle = cycleOf(bench);
  const SceneObject object = *cycle.scene().find(*near);
  const std::uint64_t applied = cycle.session(session->slot).appliedSeq();
  const std::uint64_t tick_before = bench.sample().tick;
  Taken taken(bench);
  // The servo has not run since: what is different is different by the start alone.
  const SceneObject* now = cycle.scene().find(*near);
  ASSERT_NE(now, nullptr);
  EXPECT_EQ(now->X_PO.p, object.X_PO.p);
  EXPECT_EQ(now->V_PO.v, object.V_PO.v);
  EXPECT_EQ(now->material.stiffness, object.material.stiffness);
  EXPECT_NE(cycle.scene().find(*below), nullptr);
  EXPECT_EQ(cycle.session(session->slot).life(), SessionShare::Life::kAlive);
  EXPECT_EQ(cycle.session(session->slot).appliedSeq(), applied);
  EXPECT_EQ(cycle.deviceGuard(0).fault(), std::uint32_t{HD_FAULT_DEVICE_ERROR});
  EXPECT_EQ(cycle.deviceGuard(0).limits().force, 1.25);
  EXPECT_FALSE(cycle.session(session->slot).model(model.slot).empty());
  EXPECT_EQ(cycle.pending().size(), 1u);
  bench.step(1);
  EXPECT_EQ(bench.sample().tick, tick_before + 1);
  EXPECT_EQ(cycle.scene().find(*near)->id, *near);

  // The client's force, within its own limits, is there as before; the command that waited comes in its tick.
  bench.step(60);
  EXPECT_EQ(cycle.scene().find(*below)->material.stiffness, 900);
  const Vec3 own = cycle.session(session->slot).last(0);
  EXPECT_GT(own.norm(), 1);
  EXPECT_NEAR(own.norm(), goodLimits().force_n, 1e-12) << "more is asked for";
  const std::string bytes = taken.finish([&] { bench.step(); });
  const auto verdict = verify(*replayerOf(bytes));
  ASSERT_TRUE(verdict.ok());
  EXPECT_EQ(verdict->differing, 0u) << verdict->first;
}

TEST(RecordingStart, EventsGoOnWhereTheyWere) {
  Bench bench;
  ASSERT_TRUE(bench.core.scene().create(ball("ball", Vec3(0, 0, 0)), bench.core.client(bench.administration)).ok());
  DeviceSample& hand = bench.scripted.front()->sample;
  hand.p = {0, 0, 0.05};
  bench.step(5);
  std::vector<ServoEventKind> told;
  const auto listen = [&](int cycles) {
    auto& servo = bench.core.devices().links().front()->group().servo();
    for (int i = 0; i < cycles; ++i) {
      bench.step();
      const EventBatch& batch = servo.lastOutput().events;
      for (std::uint32_t e = 0; e < batch.count; ++e) told.push_back(batch.event[e].kind);
    }
  };
  hand.p = {0, 0, 0.019};
  hand.buttons = 1;
  listen(5);
  hand.status = kDeviceError;
  listen(3);
  hand.status = kDeviceOk;
  listen(3);
  using enum ServoEventKind;
  const auto count = [&](ServoEventKind kind) { return std::count(told.begin(), told.end(), kind); };
  ASSERT_EQ(count(kTouch) - count(kUntouch), 1);
  ASSERT_EQ(count(kButton), 1);
  ASSERT_EQ(count(kFault), 1);
  Taken taken(bench);
  hand.p = {0, 0, 0.05};
  listen(10);
  EXPECT_EQ(count(kTouch), count(kUntouch)) << "what was touched is told to be left";
  EXPECT_EQ(count(kButton), 1) << "it is held all the time";
  EXPECT_EQ(count(kFault), 1) << "it stays latched";
  hand.buttons = 0;
  listen(1);
  EXPECT_EQ(count(kButton), 2);
  (void)taken.finish([&] { bench.step(); });
}

/** The scene that the new cycle begins with holds them already. */
TEST(RecordingStart, EditsOnTheirWayAreObeyedOnce) {
  Bench bench;
  const Client root = bench.core.client(bench.administration);
  SceneModel& scene = bench.core.scene();
  ASSERT_TRUE(scene.create(ball("old", Vec3(0, 0, 0)), root).ok());
  bench.step(3);
  // More than a servo's ring is given at once: some wait before it.
  ASSERT_TRUE(scene.remove("old", root).ok());
  for (int i = 0; i < 100; ++i) {
    const std::string name = "ball" + std::to_string(i);
    ASSERT_TRUE(scene.create(ball(name.c_str(), Vec3(0, 0, 0.1)), root).ok());
    ASSERT_TRUE(scene.setVelocity(name, {Vec3(1, 0, 0), Vec3::Zero()}).ok());
  }
  ResourceTree tree(bench.core);  // What is no part of the scene comes all the same.
  ASSERT_TRUE(tree.set("/devices/" + bench.device().name + "/radius?value=0.002", root).ok());
  Taken taken(bench);
  const Cycle& cycle = cycleOf(bench);
  std::uint64_t refused = 0;
  for (int i = 0; i < 30; ++i) {
    bench.step();
    refused += bench.core.devices().links().front()->group().servo().lastOutput().events.count;
  }
  EXPECT_EQ(refused, 0u);
  EXPECT_EQ(cycle.deviceRadius(0), 0.002);
  // All have moved since the recording began, also those whose orders came last.
  for (const char* name : {"ball0", "ball99"}) {
    const auto now = scene.find(name);
    ASSERT_TRUE(now.ok());
    const SceneObject* object = cycle.scene().find(now->id);
    ASSERT_NE(object, nullptr);
    EXPECT_NEAR(object->X_PO.p.x(), 0.029, 1e-9) << name << ": the first cycle sets it off";
  }
  const std::string bytes = taken.finish([&] { bench.step(); });
  const auto verdict = verify(*replayerOf(bytes));
  ASSERT_TRUE(verdict.ok());
  EXPECT_EQ(verdict->differing, 0u) << verdict->first;
}

TEST(RecordingStart, IsRefusedWhileADeviceIsArmed) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  ASSERT_TRUE(bench.arm(session->id).ok());
  const auto refused = bench.core.record("", bench.administration);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().remedy.find("disarm"), std::string::npos);
  EXPECT_TRUE(cycleOf(bench).deviceGuard(0).armed()) << "a refusal changes nothing";
  EXPECT_EQ(bench.core.recordings().size(), 0u);
}

TEST(RecordingStart, OneAGroup) {
  Bench bench;
  Taken taken(bench);
  const auto second = bench.core.record("", bench.administration);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kAlreadyExists);
  bench.core.recordings().drop(taken.id());
  EXPECT_TRUE(stepUntil(bench, [&] { return bench.core.recordings().size() == 0; }));
  EXPECT_TRUE(bench.core.record("", bench.administration).ok());
}

// A program that stops one and starts the next holds both for a moment.
TEST(RecordingStart, TheNextBeginsAsSoonAsOneHasEnded) {
  Bench bench;
  Taken first(bench);
  bench.step(3);
  (void)first.finish([&] { bench.step(); });
  Taken second(bench);
  bench.step(5);
  ASSERT_TRUE(readerOf(second.finish([&] { bench.step(); })).ok());
  EXPECT_GE(second.end()->cycles, 5u);
  EXPECT_EQ(bench.core.recordings().size(), 2u);
}

/** Whoever drops one and asks for the next at once comes before all of it is in its stream. */
TEST(RecordingStart, TheNextWaitsForOneThatEnds) {
  Bench bench;
  auto first = bench.core.record("", bench.administration);
  ASSERT_TRUE(first.ok()) << toString(first.error());
  std::optional<ErrorCode> answer;
  const auto ask = [&] {
    answer.reset();
    bench.core.record("", bench.administration, [&](const Result<Recordings::Started>& started) {
      answer = started.ok() ? ErrorCode::kOk : started.error().code;
    });
  };
  ask();
  EXPECT_EQ(answer, ErrorCode::kAlreadyExists) << "nobody ends it";
  bench.core.recordings().drop(first->id);
  ask();
  EXPECT_TRUE(stepUntil(bench, [&] { return answer.has_value(); }));
  EXPECT_EQ(answer, ErrorCode::kOk);
}

TEST(RecordingStart, AllWhoStopItHearHowItEnded) {
  Bench bench;
  auto started = bench.core.record("", bench.administration);
  ASSERT_TRUE(started.ok()) << toString(started.error());
  int heard = 0;
  for (int i = 0; i < 2; ++i)
    bench.core.recordings().stop(started->id,
                                 [&](const RecordingEnd& end) { heard += end.reason == "stopped" ? 1 : 0; });
  EXPECT_TRUE(stepUntil(bench, [&] { return heard == 2; }));
}

TEST(RecordingStart, OneThatTheDaemonsEndCutsShortSaysSo) {
  Bench bench;
  Taken taken(bench);
  bench.step(3);
  bench.core.beginShutdown();
  bench.core.recordings().drop(taken.id());  // As the last connections are closed.
  ASSERT_TRUE(readerOf(taken.finish([&] { bench.step(); })).ok());
  EXPECT_EQ(taken.end()->reason, "the daemon stops");
}

TEST(RecordingStart, NobodyRecordsAnotherUsersMessages) {
  Bench bench;
  ASSERT_NE(bench.live(), nullptr);  // of user 1000
  const auto stranger = bench.core.connect(200, 2000, false);
  ASSERT_TRUE(stranger.ok());
  const auto refused = bench.core.record("", *stranger);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kPermissionDenied);
  const auto own = bench.core.record("", bench.connection);
  ASSERT_TRUE(own.ok()) << toString(own.error());

  // A session that is refused sees nothing and ends nothing.
  const Client other = bench.core.client(*stranger);
  const auto most = static_cast<std::uint64_t>(bench.core.config().quotas.memory_mb * 1e6);
  const auto filled = bench.core.uploads().begin(most - kSessionBytes + 1, other);
  ASSERT_TRUE(filled.ok()) << toString(filled.error());
  EXPECT_FALSE(bench.core.openSession("", *stranger, "stranger", HD_SHM_MAJOR, HD_SHM_MINOR).ok());
  EXPECT_NE(bench.core.devices().links().front()->group().servo().log.load(), nullptr);
  bench.core.uploads().cancel(*filled);

  // Nor does a recording go on when another user comes.
  ASSERT_TRUE(bench.core.openSession("", *stranger, "stranger", HD_SHM_MAJOR, HD_SHM_MINOR).ok());
  std::optional<RecordingEnd> end;
  bench.core.recordings().stop(own->id, [&](const RecordingEnd& e) { end = e; });
  ASSERT_TRUE(stepUntil(bench, [&] { return end.has_value(); }));
  EXPECT_NE(end->reason.find("another user"), std::string::npos) << end->reason;
}

TEST(RecordingStart, AReaderWhoStandsStillEndsOnlyTheRecording) {
  Bench bench;
  auto started = bench.core.record("", bench.administration);
  ASSERT_TRUE(started.ok());
  // Nobody reads: the stream fills, then the log; the servo goes on.
  auto& servo = bench.core.devices().links().front()->group().servo();
  CycleLog* const log = servo.log.load();
  ASSERT_NE(log, nullptr);
  for (int i = 0; i < 40'000 && log->lost() == 0; ++i) bench.step();
  EXPECT_GT(log->lost(), 0u);
  const std::uint64_t cycles = servo.counters.cycles.load();
  bench.step(10);
  EXPECT_EQ(servo.counters.cycles.load(), cycles + 10);
  bench.core.recordings().drop(started->id);
}

/** A program disarms, records and arms again, each as soon as it may. */
TEST(RecordingStart, WaitsForADeviceThatIsBeingDisarmed) {
  Bench bench(Bench::relaxed(), 2);
  Session* const session = bench.live();
  ASSERT_NE(session, nullptr);
  std::vector<ErrorCode> answers;
  const auto ask = [&] {
    bench.core.record("", bench.administration, [&](Result<Recordings::Started> started) {
      answers.push_back(started ? ErrorCode::kOk : started.error().code);
      if (started) bench.core.recordings().drop(started->id);
    });
  };
  ASSERT_TRUE(bench.arm(session->id).ok());
  ask();
  EXPECT_EQ(answers, std::vector{ErrorCode::kInvalidArgument}) << "nobody has disarmed it";

  ASSERT_TRUE(bench.core.disarm(session->id).ok());
  ask();
  EXPECT_EQ(answers.size(), 1u) << "its force is being lowered";
  bench.step(5);
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers.back(), ErrorCode::kOk);

  ASSERT_TRUE(stepUntil(bench, [&] { return bench.core.recordings().size() == 0; }));
  ASSERT_TRUE(bench.arm(session->id).ok());
  ASSERT_TRUE(bench.core.disarm(session->id).ok());
  ask();
  ASSERT_TRUE(bench.arm(session->id).ok());
  ASSERT_EQ(answers.size(), 3u);
  EXPECT_EQ(answers.back(), ErrorCode::kInvalidArgument) << "it was armed again meanwhile";

  const auto other = bench.core.openSession("test://second", bench.connection, "", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(other.ok()) << toString(other.error());
  const ClientSide side(**other);
  ASSERT_TRUE(bench.core.sessions().mapped((*other)->id).ok());
  side.producer->heartbeat(bench.clock.now());
  bench.step(3);
  ASSERT_TRUE(bench.arm((*other)->id).ok());
  ASSERT_TRUE(bench.core.disarm((*other)->id).ok());
  ask();
  ASSERT_EQ(answers.size(), 4u);
  EXPECT_EQ(answers.back(), ErrorCode::kInvalidArgument) << "the other of the group is not being disarmed";
}

}  // namespace
}  // namespace hapticd::test
