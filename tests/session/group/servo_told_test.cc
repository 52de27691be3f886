// What a servo tells reaches subscribers whole, and says nothing that it does not know.
#include <cstdio>

#include "tests/session/bench.h"
#include "tests/support/stepped/messages.h"

namespace hapticd::test {
namespace {

class ServoTold : public testing::Test {
 protected:
  /** The one event of that kind since the last look. */
  Event heard(EventKind kind) {
    bench.step(3);
    std::vector<Event> all;
    for (EventHub::Batch batch = hub().take(listener_); !batch.events.empty(); batch = hub().take(listener_))
      all.insert(all.end(), batch.events.begin(), batch.events.end());
    std::erase_if(all, [&](const Event& event) { return event.kind != kind; });
    EXPECT_EQ(all.size(), 1u) << static_cast<int>(kind);
    if (all.size() != 1) return {};
    EXPECT_LE(all.front().t_ns, bench.clock.now());
    EXPECT_GT(all.front().t_ns, bench.clock.now() - 20 * kMs);
    return all.front();
  }
  [[nodiscard]] std::uint64_t tick() {
    hd_sample sample{};
    EXPECT_TRUE(bench.core.devices().links().front()->latest(1, sample));
    return sample.tick;
  }
  EventHub& hub() { return bench.core.events(); }

  Bench bench{Bench::relaxed(), 2};
  const Session* session = bench.live();  ///< In slot 0, on the first device.

  std::uint64_t listener_ = hub().subscribe(0, [] {});
};

TEST_F(ServoTold, ATouchWithItsPlaceItsForceAndItsObject) {
  ObjectSpec spec;
  spec.name = "ball";
  spec.shape = {ShapeKind::kSphere, Vec3(0.02, 0, 0), 0};
  spec.X_PO.p = Vec3(0.1, 0, 0);
  spec.material = {1000, 0, 0, 0};
  ASSERT_TRUE(bench.core.scene().create(spec, bench.core.client(bench.connection)).ok());
  bench.scripted[1]->sample.p = Vec3(0.1, 0, 0.05);
  bench.step(3);
  const std::uint64_t before = tick();
  bench.scripted[1]->sample.p = Vec3(0.1, 0, 0.019);  // 1 mm deep
  const Event touch = heard(EventKind::kTouch);
  EXPECT_EQ(touch.device, bench.device(1).name);
  EXPECT_EQ(touch.object, "ball");
  EXPECT_EQ(touch.tick, before + 1);
  EXPECT_NEAR(touch.force, 1.0, 1e-6) << "1 mm at 1000 N/m";
  EXPECT_NEAR(touch.point[0], 0.1, 1e-6);
  EXPECT_NEAR(touch.point[2], 0.02, 1e-6);
  EXPECT_EQ(touch.session, 0u) << "no client's: the scene is everybody's";
  bench.scripted[1]->sample.p = Vec3(0.1, 0, 0.05);
  EXPECT_EQ(heard(EventKind::kUntouch).object, "ball");
}

TEST_F(ServoTold, ThatATouchEndsByTheNameOfAnObjectThatWasRemovedMeanwhile) {
  ObjectSpec spec;
  spec.name = "ball";
  spec.shape = {ShapeKind::kSphere, Vec3(0.02, 0, 0), 0};
  spec.material = {1000, 0, 0, 0};
  for (int time = 0; time < 2; ++time) {  // The second ball stands in another slot.
    bench.scripted[1]->sample.p = Vec3(0, 0, 0.05);
    bench.step(3);
    ASSERT_TRUE(bench.core.scene().create(spec, bench.core.client(bench.connection)).ok());
    bench.step(3);
    bench.scripted[1]->sample.p = Vec3(0, 0, 0.019);
    EXPECT_EQ(heard(EventKind::kTouch).object, "ball");
    ASSERT_TRUE(bench.core.scene().remove("ball", bench.core.client(bench.connection)).ok());
    EXPECT_EQ(heard(EventKind::kUntouch).object, "ball");
  }
}

TEST_F(ServoTold, AButtonAndAFaultWithTheirNumbersAndNobodysSession) {
  bench.scripted[1]->sample.buttons = 5;
  const Event button = heard(EventKind::kButton);
  EXPECT_EQ(button.device, bench.device(1).name);
  EXPECT_EQ(button.value, 5u);
  EXPECT_EQ(button.session, 0u);
  EXPECT_TRUE(button.object.empty());
  bench.scripted[1]->sample.status = kDeviceError;
  const Event fault = heard(EventKind::kFault);
  EXPECT_EQ(fault.device, bench.device(1).name);
  EXPECT_EQ(fault.text, faultText(fault.value));
  EXPECT_EQ(fault.text, "the device reports an error");
  EXPECT_EQ(fault.session, 0u);
}

TEST_F(ServoTold, WhatIsRefusedByTheNameOfTheDeviceThatItIsFor) {
  const std::string& second = bench.device(1).name;
  const auto logged = [&](const auto& give) {
    testing::internal::CaptureStderr();
    give();
    bench.step(3);
    return testing::internal::GetCapturedStderr();
  };
  const std::string order = logged([&] {
    bench.core.devices().links().front()->post(makeCommand(CommandKind::kDeviceRadius, DeviceRadius{1, 0, -1}));
  });
  EXPECT_NE(order.find(second + ": the servo refused an order"), std::string::npos) << order;
  const auto other =
      bench.core.openSession(bench.device(1).info().uri, bench.connection, "other", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(other.ok());
  const ClientSide client(**other);
  ASSERT_TRUE(bench.core.sessions().mapped((*other)->id).ok());
  bench.step(3);
  const std::string push = logged([&] {
    hd_object_pose pose{};
    pose.object = makeObjectId(7, 1);
    pose.q[0] = 1;
    std::uint64_t seq = 0;
    EXPECT_EQ(client.producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&pose, 1)), 0, seq),
              ErrorCode::kOk);
  });
  EXPECT_NE(push.find(second + ": the servo refused 'other'"), std::string::npos) << push;
}

TEST_F(ServoTold, AnExpiredModelWithItsSlotAndItsSession) {
  ASSERT_NE(session, nullptr);
  hd_local_model model = goodModel(HD_MODEL_PLANE);
  model.slot = 3;
  model.device = 1;
  model.lease_ns = 20 * kMs;
  std::uint64_t seq = 0;
  ASSERT_EQ(bench.client->producer->push(HD_COMMAND_LOCAL_MODEL, std::as_bytes(std::span(&model, 1)), 0, seq),
            ErrorCode::kOk);
  bench.step(20);
  const Event expired = heard(EventKind::kModelExpired);
  EXPECT_EQ(expired.value, 3u);
  EXPECT_EQ(expired.session, session->id);
  EXPECT_EQ(expired.device, bench.device(1).name) << "that it was felt on";
}

/** Leases of a few ticks, renewed for ever: as many events a second as it has slots, which tell of the others. */
TEST_F(ServoTold, NotEachOfTheModelsThatItLetsExpire) {
  ASSERT_NE(session, nullptr);
  std::uint64_t told = 0, suppressed = 0;
  const auto listen = [&] {
    for (EventHub::Batch batch = hub().take(listener_); !batch.events.empty(); batch = hub().take(listener_)) {
      for (const Event& event : batch.events) {
        if (event.kind != EventKind::kModelExpired) continue;
        ++told;
        unsigned long long more = 0;
        if (std::sscanf(event.text.c_str(), "(%llu suppressed)", &more) == 1) suppressed += more;
      }
    }
  };
  constexpr std::uint64_t kPushed = 60;
  const auto push = [&](std::uint32_t slot) {
    hd_local_model model = goodModel(HD_MODEL_PLANE);
    model.slot = slot;
    model.device = 1;
    model.lease_ns = kMs;
    std::uint64_t seq = 0;
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_LOCAL_MODEL, std::as_bytes(std::span(&model, 1)), 0, seq),
              ErrorCode::kOk);
    bench.step(5);
    listen();
  };
  for (std::uint64_t i = 0; i < kPushed; ++i) push(i % HD_MODEL_SLOTS);
  EXPECT_EQ(told, std::uint64_t{HD_MODEL_SLOTS});
  bench.step(1000);
  push(0);
  bench.step(20);
  listen();
  EXPECT_EQ(told, std::uint64_t{HD_MODEL_SLOTS} + 1);
  EXPECT_EQ(told + suppressed, kPushed + 1) << "none is kept silent";
}

/** Of a machine that is too busy: a few events a second, which together tell all that was missed. */
TEST_F(ServoTold, PeriodsThatItMissed) {
  const std::int64_t period_ns = bench.core.devices().links().front()->group().options().cycle.period_ns;
  const auto late = [&](std::int64_t periods) {
    bench.clock.advance(periods * period_ns);
    bench.step();
  };
  late(7);
  const Event first = heard(EventKind::kOverrun);
  EXPECT_EQ(first.device, bench.device(0).name);
  std::uint64_t told = first.value, events = 0;
  EXPECT_EQ(told, bench.core.devices().links().front()->group().servo().counters.missed.load());
  const auto listen = [&] {
    for (EventHub::Batch batch = hub().take(listener_); !batch.events.empty(); batch = hub().take(listener_)) {
      for (const Event& event : batch.events) {
        if (event.kind != EventKind::kOverrun) continue;
        told += event.value;
        ++events;
      }
    }
  };
  for (int i = 0; i < 100; ++i) late(3);
  listen();
  EXPECT_LE(events, 5u);
  bench.step(1000);  // Nothing more is missed: what was held back is told all the same.
  listen();
  EXPECT_EQ(told, bench.core.devices().links().front()->group().servo().counters.missed.load());
}

/** A servo whose events nobody fetches counts those it drops; subscribers are told of each of them once. */
TEST_F(ServoTold, WhatItHadNoRoomFor) {
  std::uint64_t got = 0, lost = 0;
  const auto press = [&](int times) {
    for (int i = 0; i < times; ++i) {
      bench.scripted[1]->sample.buttons ^= 1u;
      for (const auto& link : bench.core.devices().links()) link->group().step();
    }
    for (int i = 0; i < 20; ++i) {
      bench.core.poll();
      for (EventHub::Batch batch = hub().take(listener_); !batch.events.empty(); batch = hub().take(listener_)) {
        got += batch.events.size();
        lost += batch.lost;
      }
    }
  };
  press(1);
  got = lost = 0;
  constexpr std::uint64_t kMany = 20'000;
  press(kMany);
  press(1);
  EXPECT_GT(lost, 0u);
  EXPECT_EQ(got + lost, kMany + 1);
  const std::uint64_t before = lost;
  press(5);
  EXPECT_EQ(lost, before);
}

/** Armed again before its driver had sent the zeros, a device never was disarmed; another was. */
TEST_F(ServoTold, NoDisarmingThatWasTakenBack) {
  ASSERT_NE(session, nullptr);
  const auto other = bench.core.openSession("test://second", bench.connection, "t", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(other.ok());
  ASSERT_TRUE(bench.core.sessions().mapped((*other)->id).ok());
  bench.step(4);
  for (const std::uint64_t id : {session->id, (*other)->id}) ASSERT_TRUE(bench.arm(id).ok());
  for (ScriptedDevice* device : bench.scripted) device->hung = true;
  for (const std::uint64_t id : {session->id, (*other)->id}) ASSERT_TRUE(bench.core.disarm(id).ok());
  bench.step(5);
  ASSERT_TRUE(bench.arm(session->id).ok());
  for (ScriptedDevice* device : bench.scripted) device->hung = false;
  EXPECT_EQ(heard(EventKind::kDisarmed).device, bench.device(1).name);
}

TEST_F(ServoTold, ALeaseWithItsSession) {
  ASSERT_NE(session, nullptr);
  const std::uint64_t id = session->id;
  ASSERT_TRUE(bench.core.acquireLease(id).ok());
  const Event taken = heard(EventKind::kLeaseTaken);
  EXPECT_EQ(taken.session, id);
  EXPECT_EQ(taken.text, "tester");
  ASSERT_TRUE(bench.core.releaseLease(id).ok());
  EXPECT_EQ(heard(EventKind::kLeaseLost).session, id);
}

}  // namespace
}  // namespace hapticd::test
