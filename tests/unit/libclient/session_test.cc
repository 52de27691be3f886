// Sessions: the two mappings, pushes by ring and mailbox, heartbeats, ends.
#include <atomic>
#include <cmath>
#include <cstring>

#include "rt/ring/command_ring.h"
#include "rt/ring/state.h"
#include "tests/unit/libclient/fixture.h"

namespace hapticd::test {
namespace {

class SessionTest : public WithSession {
 protected:
  /** Publishes samples whose ticks count from `first`. */
  void publish(StateWriter& writer, std::uint64_t first, int count) {
    for (int i = 0; i < count; ++i) {
      hd_sample sample{};
      sample.tick = first + static_cast<std::uint64_t>(i);
      sample.p[2] = 0.001 * static_cast<double>(sample.tick);
      writer.publish(sample);
    }
  }
};

TEST_F(SessionTest, MapsThenSaysSo) {
  const auto calls = daemon_->seen().calls;
  ASSERT_EQ(calls.size(), 2u);
  EXPECT_EQ(calls[0], "regions");
  EXPECT_EQ(calls[1], "mapped");
  auto info = session_->describe();
  ASSERT_TRUE(info);
  EXPECT_EQ((*info)->id, 7u);
  EXPECT_EQ((*info)->period_ns, 1'000'000);
  EXPECT_STREQ((*info)->device->uri, "sim://one");
}

TEST_F(SessionTest, ReadsTheLatestSampleAndCountsWhatTheHistoryLost) {
  EXPECT_EQ(session_->latest().code(), HAPTIC_WOULD_BLOCK);
  StateWriter writer(daemon_->regionA());
  publish(writer, 1, 10);
  auto sample = session_->latest();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->tick, 10u);
  EXPECT_EQ(sample->p[2], 0.01);

  std::vector<haptic_sample> room(2048);
  std::uint64_t lost = 0;
  auto got = session_->drain(room, lost);
  ASSERT_TRUE(got);
  ASSERT_EQ(got->size(), 10u);
  EXPECT_EQ((*got)[9].tick, 10u);
  EXPECT_EQ(lost, 0u);

  publish(writer, 11, 3000);
  got = session_->drain(room, lost);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->size() + lost, 3000u);
  EXPECT_GE(lost, 3000u - HD_HISTORY_SLOTS);
  EXPECT_EQ(got->back().tick, 3010u);
  for (std::size_t i = 1; i < got->size(); ++i) ASSERT_EQ((*got)[i].tick, (*got)[i - 1].tick + 1);
}

/** By whom the header's C is used: nothing is written through a null, and nothing is read beyond the devices. */
TEST_F(SessionTest, ReadingWithoutAPlaceToReadIntoIsRefused) {
  haptic_session* const session = session_->get();
  haptic_sample sample{};
  haptic_acks acks{};
  haptic_counters counters{};
  haptic_model_status status{};
  std::uint32_t count = 7;
  const std::uint32_t devices = (*session_->describe())->device_count;
  EXPECT_EQ(haptic_session_check(nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_latest(nullptr, &sample), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_latest(session, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_latest_of(nullptr, 0, &sample), HAPTIC_INVALID_ARGUMENT);
  for (const std::uint32_t device : {devices, devices + 1, 1000u})
    EXPECT_EQ(haptic_session_latest_of(session, device, &sample), HAPTIC_INVALID_ARGUMENT) << device;
  EXPECT_EQ(haptic_session_drain(nullptr, &sample, 1, &count, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_drain(session, &sample, 1, nullptr, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_drain(session, nullptr, 1, &count, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_drain(session, nullptr, 0, &count, nullptr), HAPTIC_OK) << "who wants none has room for it";
  EXPECT_EQ(count, 0u);
  EXPECT_EQ(haptic_session_acks(nullptr, &acks), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_acks(session, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_counters(nullptr, &counters), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_counters(session, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_model_status(nullptr, 0, &status), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_session_model_status(session, 0, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_push_space(nullptr), 0u);

  daemon_->regionA()->acks.ended = 1;
  count = 7;
  EXPECT_EQ(haptic_session_drain(session, &sample, 1, &count, nullptr), HAPTIC_DISCONNECTED);
  EXPECT_EQ(count, 0u) << "of a session that is over, too";
  EXPECT_EQ(haptic_session_counters(session, &counters), HAPTIC_DISCONNECTED);
  EXPECT_EQ(haptic_session_model_status(session, 0, &status), HAPTIC_DISCONNECTED);
  EXPECT_EQ(haptic_push_space(session), 0u);
}

/** Models, fields and their clearing share a slot of the session, hence a mailbox; the device of a force is another. */
TEST_F(SessionTest, WhatSharesASlotSharesItsMailbox) {
  haptic_session* const session = session_->get();
  haptic_push latest{};
  latest.flags = HAPTIC_PUSH_LATEST;
  haptic_local_model model = HAPTIC_LOCAL_MODEL_INIT;
  model.kind = HAPTIC_MODEL_SPRING;
  haptic_force_field field = HAPTIC_FORCE_FIELD_INIT;
  field.radius = 0.01;
  const haptic_client_force push = test::force(1);
  ASSERT_EQ(haptic_push_local_model(session, &model, &latest), HAPTIC_OK);
  ASSERT_EQ(haptic_push_client_force(session, &push, &latest), HAPTIC_OK);
  ASSERT_EQ(haptic_push_force_field(session, &field, nullptr), HAPTIC_OK) << "it goes where its slot's newest goes";
  const auto holds = [&](std::size_t box) {
    hd_slot copy{};
    MailboxReader reader(&daemon_->regionB()->mailbox[box]);
    return reader.read(copy) == MailboxReader::Read::kNew ? copy.kind : std::uint32_t{HD_COMMAND_NONE};
  };
  EXPECT_EQ(holds(0), unsigned{HD_COMMAND_FORCE_FIELD});
  EXPECT_EQ(holds(1), unsigned{HD_COMMAND_CLIENT_FORCE});
  EXPECT_EQ(holds(2), unsigned{HD_COMMAND_NONE});
  const haptic_clear_model clear{};
  ASSERT_EQ(haptic_push_clear_model(session, &clear, nullptr), HAPTIC_OK);
  EXPECT_EQ(holds(0), unsigned{HD_COMMAND_CLEAR_MODEL});
}

/** Each from its own place. */
TEST_F(SessionTest, ReadsAcksCountersAndModels) {
  hd_region_a* a = daemon_->regionA();
  a->acks = {11, 12, 13, 14, 15, 16, 17, 18, 19, -20, 0.5F, 0, 0, 0, {}};
  a->counters = {31, 32, 33, 34, 35, 36, 37, 38, {}};
  a->models[3] = {8, 77, 0.25F, 3, 0};
  const auto acks = session_->acks();
  ASSERT_TRUE(acks);
  EXPECT_EQ(acks->ring_head, 11u);
  EXPECT_EQ(acks->violations, 12u);
  EXPECT_EQ(acks->received_seq, 13u);
  EXPECT_EQ(acks->rejected, 14u);
  EXPECT_EQ(acks->last_rejected_seq, 15u);
  EXPECT_EQ(acks->last_rejected_code, 16u);
  EXPECT_EQ(acks->stale_mailboxes, 17u);
  EXPECT_EQ(acks->applied_seq, 18u);
  EXPECT_EQ(acks->applied_tick, 19u);
  EXPECT_EQ(acks->heartbeat_age_ns, -20);
  EXPECT_EQ(acks->fade, 0.5F);
  EXPECT_EQ(acks->ended, 0u);
  const auto counters = session_->counters();
  ASSERT_TRUE(counters);
  EXPECT_EQ(counters->cycles, 31u);
  EXPECT_EQ(counters->missed, 32u);
  EXPECT_EQ(counters->overruns, 33u);
  EXPECT_EQ(counters->stale_samples, 34u);
  EXPECT_EQ(counters->contacts, 35u);
  EXPECT_EQ(counters->faults, 36u);
  EXPECT_EQ(counters->max_wake_ns, 37u);
  EXPECT_EQ(counters->max_cycle_ns, 38u);
  const auto model = session_->model(3);
  ASSERT_TRUE(model);
  EXPECT_EQ(model->seq, 8u);
  EXPECT_EQ(model->age_ns, 77);
  EXPECT_EQ(model->weight, 0.25F);
  EXPECT_EQ(model->state, 3u);
  EXPECT_EQ(session_->model(8).code(), HAPTIC_INVALID_ARGUMENT);
}

TEST_F(SessionTest, TheRingKeepsEveryCommandInOrder) {
  CommandConsumer consumer(daemon_->regionB(), daemon_->regionA());
  for (int i = 1; i <= 3; ++i) {
    auto seq = session_->push(force(i), {.at_tick = static_cast<std::uint64_t>(100 * i)});
    ASSERT_TRUE(seq);
    EXPECT_EQ(*seq, static_cast<std::uint64_t>(i));
  }
  for (int i = 1; i <= 3; ++i) {
    hd_slot slot;
    ASSERT_EQ(consumer.pop(slot), CommandConsumer::Pop::kSlot);
    EXPECT_EQ(slot.kind, unsigned{HD_COMMAND_CLIENT_FORCE});
    EXPECT_EQ(slot.at_tick, 100u * static_cast<unsigned>(i));
    EXPECT_EQ(slot.length, sizeof(hd_client_force));
    hd_client_force got;
    std::memcpy(&got, slot.payload, sizeof got);
    EXPECT_EQ(got.force[0], i);
  }
  hd_slot slot;
  EXPECT_EQ(consumer.pop(slot), CommandConsumer::Pop::kEmpty);
}

TEST_F(SessionTest, AFullRingSaysSoAndTakesMoreOnceDrained) {
  CommandConsumer consumer(daemon_->regionB(), daemon_->regionA());
  EXPECT_EQ(session_->space(), HD_RING_SLOTS);
  for (unsigned i = 0; i < HD_RING_SLOTS; ++i) ASSERT_TRUE(session_->push(force(1)));
  EXPECT_EQ(session_->push(force(1)).code(), HAPTIC_WOULD_BLOCK);
  haptic_error error = HAPTIC_ERROR_INIT;
  EXPECT_EQ(haptic_push_refusal(session_->get(), &error), HAPTIC_WOULD_BLOCK);
  EXPECT_STREQ(error.what, "256 commands wait to be taken");
  EXPECT_EQ(session_->space(), 0u);
  hd_slot slot;
  ASSERT_EQ(consumer.pop(slot), CommandConsumer::Pop::kSlot);
  EXPECT_TRUE(session_->push(force(1)));
}

TEST_F(SessionTest, AMailboxKeepsTheNewestOfItsTarget) {
  for (int i = 1; i <= 1000; ++i) ASSERT_TRUE(session_->push(force(i), {.latest = true}));
  EXPECT_EQ(session_->space(), HD_RING_SLOTS) << "the ring was not used";
  MailboxReader reader(&daemon_->regionB()->mailbox[0]);
  hd_slot slot;
  ASSERT_EQ(reader.read(slot), MailboxReader::Read::kNew);
  hd_client_force got;
  std::memcpy(&got, slot.payload, sizeof got);
  EXPECT_EQ(got.force[0], 1000);
}

TEST_F(SessionTest, ATargetWithAMailboxKeepsItSoThatOldNeverOvertakesNew) {
  haptic_local_model model{};
  model.slot = 2;
  model.kind = HAPTIC_MODEL_PLANE;
  model.lease_ns = 1;
  model.normal[2] = 1;
  ASSERT_TRUE(session_->push(model, {.latest = true}));
  ASSERT_TRUE(session_->push(haptic_clear_model{2, 0, 0}));
  MailboxReader reader(&daemon_->regionB()->mailbox[0]);
  hd_slot slot;
  ASSERT_EQ(reader.read(slot), MailboxReader::Read::kNew);
  EXPECT_EQ(slot.kind, unsigned{HD_COMMAND_CLEAR_MODEL});
  EXPECT_EQ(session_->push(model, {.at_tick = 5}).code(), HAPTIC_INVALID_ARGUMENT) << "a mailbox has no tick";
  EXPECT_EQ(session_->space(), HD_RING_SLOTS);
}

/** Of vertices and of flags each push changes some: the newest does not hold what those before it changed. */
TEST_F(SessionTest, WhatChangesAPartTakesNoMailbox) {
  haptic_object_vertices vertices{};
  vertices.object = vertices.count = 1;
  const haptic_object_flags flags{1, HAPTIC_OBJECT_ENABLED, 0, 0};
  EXPECT_EQ(session_->push(vertices, {.latest = true}).code(), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(session_->push(flags, {.latest = true}).code(), HAPTIC_INVALID_ARGUMENT);
  EXPECT_TRUE(session_->push(vertices, {.at_tick = 5}));
  EXPECT_TRUE(session_->push(vertices));
  EXPECT_TRUE(session_->push(flags));
  EXPECT_EQ(session_->space(), HD_RING_SLOTS - 3) << "all of them by the ring";
}

TEST_F(SessionTest, SixteenTargetsCanHaveAMailbox) {
  haptic_object_pose pose{};
  pose.q[0] = 1;
  for (unsigned i = 1; i <= HD_MAILBOXES; ++i) {
    pose.object = i;
    ASSERT_TRUE(session_->push(pose, {.latest = true}));
  }
  pose.object = HD_MAILBOXES + 1;
  EXPECT_EQ(session_->push(pose, {.latest = true}).code(), HAPTIC_QUOTA_EXCEEDED);
  EXPECT_TRUE(session_->push(pose)) << "the ring is still there";
  pose.object = 3;
  EXPECT_TRUE(session_->push(pose, {.latest = true}));
}

TEST_F(SessionTest, ARefusedPushSaysWhichFieldAndWhatToDo) {
  haptic_error error = HAPTIC_ERROR_INIT;
  ASSERT_TRUE(session_->push(force(1)));
  EXPECT_EQ(haptic_push_refusal(session_->get(), &error), HAPTIC_OK);
  EXPECT_EQ(error.code, HAPTIC_OK) << "nothing was refused";

  haptic_client_force bad = force(1);
  bad.lease_ns = 0;
  EXPECT_EQ(session_->push(bad).error().message(),
            "lease_ns: is not above 0 and at most 10 s (say how long it holds without news from you, as 0.2 s)");
  EXPECT_EQ(haptic_push_refusal(session_->get(), &error), HAPTIC_INVALID_ARGUMENT);
  EXPECT_STREQ(error.where, "lease_ns");
  haptic_local_model patch = HAPTIC_LOCAL_MODEL_INIT;
  patch.kind = HAPTIC_MODEL_HALFSPACES;
  patch.count = 1;
  EXPECT_EQ(session_->push(patch).error().where, "halfspace[0]");
  bad = force(1);
  bad.device = 1;
  EXPECT_EQ(session_->push(bad).error().where, "device") << "of a group of one";
  EXPECT_EQ(haptic_push_client_force(session_->get(), nullptr, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(haptic_push_refusal(session_->get(), &error), HAPTIC_INVALID_ARGUMENT);
  EXPECT_STREQ(error.where, "client_force");

  ASSERT_TRUE(session_->push(force(1)));
  EXPECT_EQ(haptic_push_refusal(session_->get(), nullptr), HAPTIC_OK) << "only the last push counts";
  EXPECT_EQ(haptic_push_refusal(nullptr, &error), HAPTIC_INVALID_ARGUMENT);
}

/** Zeros would take away what nobody spoke of. */
TEST_F(SessionTest, LimitsBindNothingUntilOneIsLowered) {
  haptic_session_limits limits = HAPTIC_SESSION_LIMITS_INIT;
  EXPECT_TRUE(session_->push(limits));
  limits.force_n = 2;
  EXPECT_TRUE(session_->push(limits));
  CommandConsumer consumer(daemon_->regionB(), daemon_->regionA());
  hd_slot slot;
  for (const double force_n : {1000.0, 2.0}) {
    ASSERT_EQ(consumer.pop(slot), CommandConsumer::Pop::kSlot);
    hd_limits sent;
    std::memcpy(&sent, slot.payload, sizeof sent);
    EXPECT_EQ(sent.force_n, force_n);
    EXPECT_EQ(sent.torque_nm, 100);
  }
}

TEST_F(SessionTest, WhatCannotBeMeantIsNotSent) {
  haptic_client_force bad = force(NAN);
  EXPECT_EQ(session_->push(bad).code(), HAPTIC_INVALID_ARGUMENT);
  bad = force(1);
  bad.lease_ns = 0;
  EXPECT_EQ(session_->push(bad).code(), HAPTIC_INVALID_ARGUMENT);
  bad = force(1);
  bad.device = HD_MAX_DEVICES;
  EXPECT_EQ(session_->push(bad).code(), HAPTIC_INVALID_ARGUMENT);
  haptic_local_model model{};
  model.kind = HAPTIC_MODEL_PLANE;
  model.lease_ns = 1;
  EXPECT_EQ(session_->push(model).code(), HAPTIC_INVALID_ARGUMENT) << "no normal";
  model.normal[0] = 1;
  EXPECT_TRUE(session_->push(model));
  model.slot = HAPTIC_MODEL_SLOTS;
  EXPECT_EQ(session_->push(model).code(), HAPTIC_INVALID_ARGUMENT);
  model.slot = 0;
  model.material.friction_dynamic = 0.5;
  EXPECT_EQ(session_->push(model).code(), HAPTIC_INVALID_ARGUMENT) << "dynamic friction above static";
  haptic_object_pose pose{};
  pose.object = 1;
  EXPECT_EQ(session_->push(pose).code(), HAPTIC_INVALID_ARGUMENT) << "no rotation";
  haptic_object_vertices vertices{};
  vertices.object = 1;
  vertices.count = HAPTIC_VERTEX_MOVES + 1;
  EXPECT_EQ(session_->push(vertices).code(), HAPTIC_INVALID_ARGUMENT);
  haptic_push unknown{0, 0x80, 0, 0};
  const haptic_client_force good = force(1);
  EXPECT_EQ(haptic_push_client_force(session_->get(), &good, &unknown), HAPTIC_INVALID_ARGUMENT);
  haptic_push reserved{0, 0, 1, 0};
  EXPECT_EQ(haptic_push_client_force(session_->get(), &good, &reserved), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(session_->space(), HD_RING_SLOTS - 1);
}

TEST_F(SessionTest, HeartbeatsComeByThemselves) {
  CommandConsumer consumer(daemon_->regionB(), daemon_->regionA());
  const std::int64_t first = consumer.heartbeat();
  EXPECT_NE(first, 0);
  EXPECT_TRUE(eventually([&] { return consumer.heartbeat() > first; }));
}

TEST_F(SessionTest, OrdersReachTheDaemonAndRefusalsComeBack) {
  EXPECT_TRUE(session_->acquireLease());
  daemon_->script([](Script& script) { script.refuse_arm = HAPTIC_FAULT_LATCHED; });
  const auto armed = session_->arm();
  EXPECT_EQ(armed.code(), HAPTIC_FAULT_LATCHED);
  EXPECT_EQ(armed.error().remedy, "close the stop line");
  EXPECT_TRUE(session_->disarm());
  EXPECT_TRUE(session_->releaseLease());
  const auto calls = daemon_->seen().calls;
  EXPECT_EQ(std::vector<std::string>(calls.begin() + 2, calls.end()),
            (std::vector<std::string>{"acquireLease", "arm", "disarm", "releaseLease"}));
}

/** A daemon that stood still may obey when nobody waits for it any more. */
TEST_F(SessionTest, AnOrderToArmThatTookTooLongIsCalledOff) {
  daemon_->script([](Script& script) { script.dawdle = true; });
  ASSERT_TRUE(client_->setTimeout(std::chrono::milliseconds(50)));
  EXPECT_EQ(session_->arm().code(), HAPTIC_TIMEOUT);
  EXPECT_TRUE(eventually([&] { return daemon_->seen().calls.back() == "disarm"; }));
  EXPECT_EQ(*(daemon_->seen().calls.end() - 2), "arm");
}

TEST_F(SessionTest, ASessionThatTheDaemonEndedIsDead) {
  EXPECT_TRUE(session_->alive());
  daemon_->regionA()->acks.ended = 1;
  EXPECT_FALSE(session_->alive());
  EXPECT_EQ(session_->latest().code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(session_->push(force(1)).code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(session_->arm().code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(session_->acks()->ended, 1u) << "the acknowledgements say why";
}

TEST_F(SessionTest, ClosingEndsItAtTheDaemon) {
  EXPECT_EQ(daemon_->seen().open_sessions, 1);
  session_ = nullptr;
  EXPECT_TRUE(eventually([&] { return daemon_->seen().open_sessions == 0; }));
}

TEST_F(SessionTest, TheClientMayGoFirst) {
  client_ = nullptr;
  EXPECT_TRUE(eventually([&] { return daemon_->seen().open_sessions == 0; }));
  EXPECT_EQ(session_->latest().code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(session_->arm().code(), HAPTIC_DISCONNECTED);
  session_ = nullptr;
}

TEST_F(SessionTest, ReopensOnTheSameDeviceAfterARestart) {
  ASSERT_TRUE(session_->push(force(1), {.latest = true}));
  restart(2);
  ASSERT_TRUE(eventually([&] { return !session_->alive(); }));
  EXPECT_EQ(session_->push(force(1)).code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(session_->reopen().code(), HAPTIC_DISCONNECTED) << "reconnect first";
  ASSERT_TRUE(client_->reconnect());
  EXPECT_FALSE(session_->alive()) << "sessions do not come back by themselves";
  const auto back = session_->reopen();
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ((*session_->describe())->epoch, 2u);
  StateWriter writer(daemon_->regionA());
  publish(writer, 5, 1);
  EXPECT_EQ(session_->latest()->tick, 5u);
  CommandConsumer consumer(daemon_->regionB(), daemon_->regionA());
  EXPECT_TRUE(session_->push(force(1)));
  hd_slot slot;
  EXPECT_EQ(consumer.pop(slot), CommandConsumer::Pop::kSlot) << "mailboxes and numbers start anew";
  EXPECT_EQ(slot.seq, 1u);
}

/** What may not wait for the daemon cannot reopen, either: the session that stands goes on. */
TEST_F(SessionTest, AReopeningThatIsRefusedInACallbackEndsNothing) {
  struct Reopened {
    haptic_session* session;
    std::atomic<int> code{-1};
  } reopened{session_->get()};
  haptic_events_options options = HAPTIC_EVENTS_OPTIONS_INIT;
  options.user = &reopened;
  options.callback = [](const haptic_event*, void* user) {
    auto& r = *static_cast<Reopened*>(user);
    r.code = haptic_session_reopen(r.session, nullptr);
  };
  haptic_events* events = nullptr;
  ASSERT_EQ(haptic_events_open(client_->get(), &options, &events, nullptr), HAPTIC_OK);
  daemon_->send({1});
  EXPECT_EQ(reopened.code, HAPTIC_INVALID_ARGUMENT);
  haptic_events_close(events);
  EXPECT_TRUE(session_->alive());
  EXPECT_TRUE(session_->push(force(1)));
  EXPECT_TRUE(session_->acquireLease());
}

/** Names are given out in the order in which a daemon opens its devices. */
TEST_F(SessionTest, ReopensTheDeviceItHadWhateverBearsItsNameByThen) {
  auto named = client_->openSession("sim2");
  ASSERT_TRUE(named) << named.error().message();
  ASSERT_STREQ((*named->describe())->device->uri, "sim://one");
  daemon_ = nullptr;
  Script script;
  script.device = "sim://two";
  start(script);
  ASSERT_TRUE(eventually([&] { return !client_->connected(); }));
  ASSERT_TRUE(client_->reconnect());
  const auto back = named->reopen();
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_STREQ((*named->describe())->device->uri, "sim://one") << "not a stranger's hand";
}

/** Those of the configuration may be others by then. */
TEST_F(SessionTest, ReopensWithTheParametersThatWereAskedForAlone) {
  daemon_->script([](Script& script) { script.device = "sim://one?dof=6"; });
  for (const auto& [asked, again] : {std::pair{"sim2", "sim://one"}, {"sim://two?dof=6", "sim://two?dof=6"}}) {
    auto session = client_->openSession(asked);
    ASSERT_TRUE(session) << session.error().message();
    const auto back = session->reopen();
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_STREQ((*session->describe())->device->uri, again);
  }
}

TEST_F(SessionTest, RefusalsOfOpeningNameTheDevice) {
  const auto none = client_->openSession("sim://none");
  EXPECT_EQ(none.code(), HAPTIC_NOT_FOUND);
  EXPECT_EQ(none.error().where, "sim://none");
  daemon_->script([](Script& script) { script.layout_major = HD_SHM_MAJOR + 1; });
  EXPECT_EQ(client_->openSession().code(), HAPTIC_VERSION_MISMATCH);
  EXPECT_TRUE(eventually([&] { return daemon_->seen().open_sessions == 1; })) << "refused sessions end";
}

}  // namespace
}  // namespace hapticd::test
