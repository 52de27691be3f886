// What a session reads of the servo's ticks is what the devices told, what was sent to them and what the cycle did.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "rt/cycle/servo.h"
#include "tests/support/for_seeds.h"
#include "tests/support/stepped/mount_at.h"
#include "tests/support/stepped/regions.h"
#include "tests/support/stepped/scripted_device.h"
#include "tests/support/stepped/solid.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kSlot = 3, kDevices = 2;

/** Two hands above a floor that rubs, armed, and a session. */
class ServoSample : public testing::Test {
 protected:
  ServoSample() {
    CycleConfig config;
    config.device_count = kDevices;
    for (GuardConfig& guard : config.guard) {
      guard.limits = {10, 1, 1e6, 1e3, 5, 10, 50, 50};
      guard.ramp_ns = kMs;
      guard.small_force = 100;
      guard.continuous_force = 1;
      guard.peak_force = 10;
    }
    servo = std::make_unique<Servo>(config, std::array<Device*, kMaxDevices>{&device[0], &device[1]}, meshes, clock);
    servo->ports[kSlot].region.store(regions.a.get());
    servo->begin();
    send(CommandKind::kAddObject, test::solid(kFloor, ShapeKind::kPlane, {1000, 0, 0.4, 0.3}));
    send(CommandKind::kAddSession, SessionRef{kSlot, 0, 9});
    for (std::uint32_t d = 0; d < kDevices; ++d) {
      device[d].sample.p = at(0, d);
      send(CommandKind::kArm, DeviceRef{d});
      send(CommandKind::kSetGrip, SetGrip{d, 0, 10, 0.2});
    }
    run(10);
  }
  template <class T>
  void send(CommandKind kind, const T& payload, std::uint64_t at_tick = 0, std::uint32_t from = kControlSession) {
    Command command = makeCommand(kind, payload, from);
    command.at_tick = at_tick;
    command.seq = ++seq;
    ASSERT_TRUE(servo->from_control.push(command));
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) servo->runOnce();
  }
  [[nodiscard]] hd_sample latest(std::uint32_t d) const {
    hd_sample sample{};
    EXPECT_TRUE(StateReader(regions.a.get()).latest(d, sample));
    return sample;
  }
  static Vec3 at(int i, std::uint32_t d) { return {2e-4 * i, d * 0.1, 0.003 * std::sin(0.05 * i + d)}; }
  /** Both hands slide over the floor, in and out, with all that a reading may tell. */
  void move(Random& random, int i) {
    for (std::uint32_t d = 0; d < kDevices; ++d) {
      DeviceSample& sample = device[d].sample;
      sample.p = at(i, d);
      sample.q = Eigen::AngleAxisd(random.in(0, 0.1), Vec3::UnitX());
      sample.fresh = !random.once(5);
      sample.buttons = static_cast<std::uint32_t>(random.below(8));
      sample.gripper_rad = random.in(0, 0.3);
      sample.status = random.once(3) ? std::uint32_t{kDeviceSaturated} : kDeviceOk;
    }
    servo->no_realtime.store(random.once(2));
    for (int n = random.below(5); n > 0; --n) send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, 0});
    if (random.once(4)) send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, -1});
  }

  static constexpr std::uint32_t kFloor = makeObjectId(1, 1);
  ManualClock clock{kMs / 2};
  std::array<test::ScriptedDevice, kDevices> device;
  MeshTable meshes;
  test::Regions regions{{.epoch = 1, .session = 9, .device_count = kDevices, .period_ns = kMs}};
  std::unique_ptr<Servo> servo;
  std::uint64_t seq = 0;
};

void expectEqual(const Vec3& expected, const double (&told)[3], const char* what) {
  for (int i = 0; i < 3; ++i) ASSERT_EQ(told[i], expected[i]) << what;
}

TEST_F(ServoSample, TellsOfEachDeviceWhatWasReadAndSent) {
  Random random(seedOf(3));
  const Vec3 own(0.3, -0.2, 0.1);
  hd_client_force push{};
  push.lease_ns = 10'000 * kMs;
  store(own, push.force);
  send(CommandKind::kClientForce, push, 0, kSlot);
  int touching = 0, sliding = 0;
  for (int i = 0; i < 500; ++i) {
    SCOPED_TRACE(i);
    move(random, i);
    run(1);
    for (std::uint32_t d = 0; d < kDevices; ++d) {
      const hd_sample told = latest(d);
      const DeviceSample& read = device[d].sample;
      const DeviceCommand& sent = device[d].sent.back();
      const DeviceOutput& out = servo->lastOutput().device[d];
      ASSERT_EQ(told.device, d);
      ASSERT_EQ(told.tick, servo->counters.tick.load());
      ASSERT_EQ(told.applied_commands, servo->lastOutput().applied_commands);
      expectEqual(read.p, told.p, "p");
      for (int k = 0; k < 4; ++k) ASSERT_EQ(told.q[k], read.q.coeffs()[(k + 3) % 4]) << "w x y z";
      expectEqual(out.velocity.v, told.v, "v");
      expectEqual(out.velocity.w, told.w, "w");
      expectEqual(sent.force, told.force, "force");
      expectEqual(sent.torque, told.torque, "torque");
      const bool touches = read.p.z() < 0;
      expectEqual(touches ? out.contact.proxy : read.p, told.proxy, "proxy");
      ASSERT_EQ(told.contact_object, touches ? kFloor : 0);
      ASSERT_NEAR(told.depth_m, touches ? -read.p.z() : 0, 1e-8);
      ASSERT_EQ(told.gripper_rad, read.gripper_rad);
      ASSERT_EQ(told.gripper_force_n, sent.gripper_force);
      ASSERT_NEAR(sent.gripper_force, 10 * std::max(0.0, 0.2 - read.gripper_rad), 1e-9);
      ASSERT_EQ(told.energy_j, static_cast<float>(out.guard.energy));
      ASSERT_EQ(told.fault, HD_FAULT_NONE);
      Vec3 sum = Vec3::Zero();
      for (const auto& part : told.by_source) sum += Vec3(part[0], part[1], part[2]);
      ASSERT_LT((sum - sent.force).norm(), 1e-5) << "every newton has an owner";
      for (int k = 0; k < 3; ++k) {
        ASSERT_EQ(told.by_source[HD_SOURCE_SURFACE][k], static_cast<float>(out.guard.by_source[HD_SOURCE_SURFACE][k]));
        ASSERT_EQ(told.own[k], d == 0 ? static_cast<float>(own[k]) : 0);
      }
      const auto has = [&](std::uint32_t flag) { return (told.flags & flag) != 0; };
      ASSERT_EQ(has(HD_SAMPLE_CONTACT), touches);
      ASSERT_EQ(has(HD_SAMPLE_SLIP), out.contact.slip);
      ASSERT_EQ(has(HD_SAMPLE_STALE), !read.fresh);
      ASSERT_EQ(has(HD_SAMPLE_SATURATED), read.status == kDeviceSaturated);
      ASSERT_EQ(has(HD_SAMPLE_NO_RT), servo->no_realtime.load());
      ASSERT_TRUE(has(HD_SAMPLE_ARMED));
      touching += touches;
      sliding += has(HD_SAMPLE_SLIP);
      ASSERT_EQ(servo->counters.heat[d].load(), static_cast<float>(out.guard.heat));
    }
    ASSERT_EQ(latest(0).buttons, device[0].sample.buttons);
  }
  EXPECT_GT(touching, 100);
  EXPECT_GT(sliding, 100);
  EXPECT_GT(servo->counters.heat[0].load(), 0);
}

TEST_F(ServoSample, CountersCountWhatHappenedUntilTheTickBefore) {
  Random random(seedOf(4));
  hd_counters counted{};
  counted.cycles = servo->counters.cycles.load();
  std::int64_t last_cost = 0;
  device[0].clock = &clock;
  for (int i = 0; i < 1000; ++i) {
    SCOPED_TRACE(i);
    move(random, i);
    if (random.once(50)) send(CommandKind::kStop, StopOrder{0, 0});
    if (random.once(10)) send(CommandKind::kArm, DeviceRef{0});
    const auto deadline = static_cast<std::int64_t>(servo->counters.tick.load() + 1) * kMs;
    const std::int64_t late = std::max<std::int64_t>(0, clock.now() - deadline), missed = late / kMs;
    const std::int64_t cost = random.once(10) ? random.below(4 * kMs) : 0;
    device[0].read_cost_ns = cost;
    run(1);
    const hd_sample told = latest(0);
    ASSERT_EQ(told.missed, counted.missed + static_cast<std::uint64_t>(missed));
    ASSERT_EQ(told.wake_ns, late);
    ASSERT_EQ(told.t_ns, std::max(deadline + late, deadline));
    ASSERT_EQ(told.cycle_ns, last_cost);
    ASSERT_EQ(told.fault, servo->cycle().deviceGuard(0).fault());
    ASSERT_EQ(std::memcmp(&regions.a->counters, &counted, sizeof counted), 0);

    ++counted.cycles;
    counted.missed += static_cast<std::uint64_t>(missed);
    counted.overruns += missed > 0 || late % kMs + cost > kMs ? 1 : 0;
    for (const auto& d : device) counted.stale_samples += d.sample.fresh ? 0 : 1;
    for (ServoEvent event; servo->events.pop(event);) {
      counted.contacts += event.kind == ServoEventKind::kTouch ? 1 : 0;
      counted.faults += event.kind == ServoEventKind::kFault ? 1 : 0;
    }
    counted.max_wake_ns = std::max(counted.max_wake_ns, static_cast<std::uint32_t>(late));
    counted.max_cycle_ns = std::max(counted.max_cycle_ns, static_cast<std::uint32_t>(cost));
    last_cost = cost;
    ASSERT_EQ(servo->counters.cycles.load(), counted.cycles);
    ASSERT_EQ(servo->counters.missed.load(), counted.missed);
    ASSERT_EQ(servo->counters.overruns.load(), counted.overruns);
    ASSERT_EQ(servo->counters.stale.load(), counted.stale_samples);
    ASSERT_EQ(servo->counters.contacts.load(), counted.contacts);
    ASSERT_EQ(servo->counters.faults.load(), counted.faults);
    ASSERT_EQ(servo->counters.last_cycle_ns.load(), clock.now());
  }
  for (const std::uint64_t n : {counted.missed, counted.overruns, counted.contacts, counted.faults}) EXPECT_GT(n, 5u);
}

TEST_F(ServoSample, TheSessionReadsWhatBecameOfItsOrders) {
  hd_local_model model{};
  model.slot = 2;
  model.kind = HD_MODEL_PLANE;
  model.normal[2] = 1;
  model.material.stiffness = 100;
  model.lease_ns = 40 * kMs;
  model.blend_ns = 20 * kMs;
  send(CommandKind::kLocalModel, model, 0, kSlot);
  const std::uint64_t number = seq, tick = servo->counters.tick.load() + 1;
  const hd_model_status& told = regions.a->models[2];
  for (int age = 0; age <= 200; ++age) {
    run(1);
    ASSERT_EQ(regions.a->acks.applied_seq, number);
    ASSERT_EQ(regions.a->acks.applied_tick, tick);
    ASSERT_EQ(regions.a->acks.fade, 1);
    if (told.state == 0) break;
    ASSERT_EQ(told.seq, number) << age;
    ASSERT_EQ(told.age_ns, age * kMs);
    ASSERT_EQ(told.state, age < 20 ? 1u : age <= 40 ? 2u : 3u) << age;
    if (age >= 20 && age <= 40) {
      ASSERT_EQ(told.weight, 1);
    }
    ASSERT_EQ(regions.a->models[0].state, 0u);
  }
  EXPECT_EQ(told.seq, 0u) << "it has faded";
  send(CommandKind::kLoseSession, SessionRef{kSlot, 0, 9});
  for (int age = 0; age < 60; ++age) {
    run(1);
    ASSERT_NEAR(regions.a->acks.fade, std::max(0.0, 1 - age / 50.0), 1e-6);  // CycleConfig::loss_fade_ns
  }
}

TEST_F(ServoSample, WhatIsRaisedAndNotReadIsCounted) {
  for (ServoEvent event; servo->events.pop(event);) continue;
  const std::uint64_t at = servo->counters.tick.load() + 10;  // More in one tick than a cycle tells of.
  std::uint64_t raised = 0, read = 0;
  for (int i = 0; i < 40; ++i, ++raised) {
    if (i % 10 == 0) run(1);
    send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, -1}, at);
  }
  run(10);
  EXPECT_EQ(servo->counters.events_dropped.load(), raised - EventBatch::kMostRefusals);
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 10; ++k, ++raised) send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, -1});
    run(1);
  }
  for (ServoEvent event; servo->events.pop(event);) ++read;
  EXPECT_LT(read, raised);
  EXPECT_EQ(read + servo->counters.events_dropped.load(), raised);
}

TEST_F(ServoSample, AFaultIsToldHoweverMuchIsRefused) {
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 16; ++k) send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, -1});
    run(1);
  }
  send(CommandKind::kStop, StopOrder{0, HD_FAULT_STOP_LINE});
  run(1);
  int faults = 0;
  for (ServoEvent event; servo->events.pop(event);) faults += event.kind == ServoEventKind::kFault ? 1 : 0;
  EXPECT_EQ(faults, 1);
}

/** What is pushed, wished and read is of the world; what is read from the device and sent to it is its own. */
TEST_F(ServoSample, ADeviceThatStandsElsewhereIsToldOfInTheWorld) {
  Random random(seedOf(5));
  for (int i = 0; i < 20; ++i) {
    Pose X = random.pose(0.2);
    X.p.z() += 0.5;  // Above the floor.
    DeviceSample& read = device[1].sample;
    read.has_velocity = true;
    read.p = random.vector(0.05);
    read.q = random.pose(1).q;
    read.v = random.vector(0.1);
    read.w = random.vector(0.1);
    hd_client_force push{};
    push.device = 1;
    push.lease_ns = 10'000 * kMs;
    send(CommandKind::kClientForce, push, 0, kSlot);
    send(CommandKind::kDisarm, DeviceRef{1});
    run(10);
    send(CommandKind::kSetMount, test::mountAt(X, 1));
    send(CommandKind::kArm, DeviceRef{1});
    run(10);
    const Vec3 force = random.vector(1), torque = random.vector(0.1);
    store(force, push.force);
    store(torque, push.torque);
    send(CommandKind::kClientForce, push, 0, kSlot);
    const Pose wanted = random.pose(0.1);
    hd_intent wish{};
    wish.device = 1;
    store(wanted.p, wish.p);
    store(wanted.q, wish.q);
    send(CommandKind::kIntent, wish);
    run(20);
    const hd_sample told = latest(1);
    const DeviceCommand& sent = device[1].sent.back();
    const auto near = [](const Vec3& a, const Vec3& b) { return (a - b).norm() < 1e-6; };
    const auto back = [&](const Vec3& x_W) { return Vec3(X.q.conjugate() * x_W); };
    EXPECT_TRUE(near(vec3(told.p), X * read.p));
    EXPECT_LT(quat(told.q).angularDistance(X.q * read.q), 1e-7);
    EXPECT_TRUE(near(vec3(told.v), X.q * read.v)) << vec3(told.v).transpose();
    EXPECT_TRUE(near(vec3(told.w), X.q * read.w)) << vec3(told.w).transpose();
    EXPECT_TRUE(near(vec3(told.force), force));
    EXPECT_TRUE(near(vec3(told.torque), torque));
    const float(&client)[3] = told.by_source[HD_SOURCE_CLIENT];
    EXPECT_TRUE(near(Vec3(client[0], client[1], client[2]), force));
    EXPECT_TRUE(near(sent.force, back(force)));
    EXPECT_TRUE(near(sent.torque, back(torque)));
    EXPECT_TRUE(near(device[1].intent.p, X.inverse() * wanted.p));
    EXPECT_LT(device[1].intent.q.angularDistance(X.q.conjugate() * wanted.q), 1e-7);
    EXPECT_TRUE(near(vec3(latest(0).p), device[0].sample.p)) << "the other stands where it stood";
  }
}

/** A share is told as it is felt: of a hand that is off its point less and less, then nothing. */
TEST_F(ServoSample, AClutchWeighsASessionsOwnShare) {
  for (auto& each : device) each.sample.p = {0, 0, 0.05};
  run(5);
  hd_client_force force{};
  force.lease_ns = 10'000 * kMs;
  force.force[1] = 0.5;
  send(CommandKind::kClientForce, force, 0, kSlot);
  run(20);
  ASSERT_EQ(latest(0).own[1], 0.5f);
  send(CommandKind::kSetClutch, SetClutch{0, 1, 0, 0, {}});
  int between = 0;
  for (int i = 0; i < 60; ++i) {
    run(1);
    const hd_sample sample = latest(0);
    between += sample.own[1] > 0 && sample.own[1] < 0.5f ? 1 : 0;
    ASSERT_EQ(sample.own[1], sample.by_source[HD_SOURCE_CLIENT][1]) << i;
  }
  EXPECT_GT(between, 40);
  EXPECT_EQ(latest(0).own[1], 0);
}

TEST_F(ServoSample, AnIntentIsPassedOnOnce) {
  hd_intent wish{};
  wish.device = 1;
  wish.p[1] = 0.25;
  wish.q[0] = 1;
  send(CommandKind::kIntent, wish);
  run(1);
  EXPECT_EQ(device[1].intent.p.y(), 0.25);
  EXPECT_EQ(device[0].intent.p.y(), 0);
  for (auto& each : device) each.intent.p.setConstant(7);
  run(2);
  for (const auto& each : device) EXPECT_EQ(each.intent.p, Vec3::Constant(7));
}

}  // namespace
}  // namespace hapticd
