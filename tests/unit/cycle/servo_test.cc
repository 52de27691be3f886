#include "rt/cycle/servo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "tests/support/stepped/attach_tool.h"
#include "tests/support/stepped/regions.h"
#include "tests/support/stepped/scripted_device.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;

GuardConfig openGuard() {
  GuardConfig guard;
  guard.limits = {.force = 10,
                  .torque = 1,
                  .force_slew = 1e6,
                  .torque_slew = 1e6,
                  .gripper_force = 1,
                  .velocity = 10,
                  .power = 1e3,
                  .active_power = 1e3};
  guard.ramp_ns = kPeriodNs;
  guard.small_force_ticks = 1;
  return guard;
}

AddObject plane(double stiffness) { return test::solid(makeObjectId(1, 1), ShapeKind::kPlane, {stiffness, 0, 0, 0}); }

struct ServoFixture : testing::Test {
  ServoFixture() {
    CycleConfig config;
    config.period_ns = kPeriodNs;
    config.guard.fill(openGuard());
    servo = std::make_unique<Servo>(config, std::array<Device*, kMaxDevices>{&device}, meshes, clock);
    servo->begin();
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) servo->runOnce();
  }
  void arm() {
    ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kArm, DeviceRef{0})));
    run(10);
    ASSERT_TRUE(servo->cycle().deviceGuard(0).armed());
  }

  ManualClock clock{123'456};
  test::ScriptedDevice device;
  MeshTable meshes;
  std::unique_ptr<Servo> servo;
};

TEST_F(ServoFixture, WakesOnMultiplesOfThePeriod) {
  run(3);
  EXPECT_EQ(device.reads, (std::vector<std::int64_t>{kPeriodNs, 2 * kPeriodNs, 3 * kPeriodNs}));
}

TEST_F(ServoFixture, OverrunKeepsThePhaseAndNeverRunsAPeriodTwice) {
  device.clock = &clock;
  run(1);
  device.read_cost_ns = 3 * kPeriodNs + kPeriodNs / 2;  // cycle 2 lasts three and a half periods
  run(3);
  // Cycle 2 starts at 2 ms and ends at 5.5 ms; the next one belongs to 5 ms, then 6 ms.
  EXPECT_EQ(device.reads, (std::vector<std::int64_t>{1 * kPeriodNs, 2 * kPeriodNs, 5 * kPeriodNs, 6 * kPeriodNs}));
  EXPECT_EQ(servo->counters.missed.load(), 2u);
  EXPECT_EQ(servo->counters.tick.load(), 6u);
  EXPECT_EQ(servo->counters.cycles.load(), 4u);
}

TEST_F(ServoFixture, APeriodThatHasJustPassedIsSkipped) {
  device.clock = &clock;
  device.read_cost_ns = 2 * kPeriodNs;
  run(3);
  EXPECT_EQ(device.reads, (std::vector<std::int64_t>{1 * kPeriodNs, 3 * kPeriodNs, 4 * kPeriodNs}));
  EXPECT_EQ(servo->counters.missed.load(), 1u);
}

TEST_F(ServoFixture, WhilePeriodsPassThatNobodyRanItNoneIsMissed) {
  run(2);
  clock.advance(kPeriodNs / 2);
  servo->skipPassed();
  run(1);
  clock.advance(2 * kPeriodNs + kPeriodNs / 2);
  servo->skipPassed();
  run(2);
  EXPECT_EQ(device.reads,
            (std::vector<std::int64_t>{1 * kPeriodNs, 2 * kPeriodNs, 3 * kPeriodNs, 6 * kPeriodNs, 7 * kPeriodNs}));
  EXPECT_EQ(servo->counters.missed.load(), 0u);
  EXPECT_EQ(servo->counters.tick.load(), 7u);
}

TEST_F(ServoFixture, TheSampleBehindAGapCountsIt) {
  const test::Regions regions;
  servo->ports[3].region.store(regions.a.get());
  servo->from_control.push(makeCommand(CommandKind::kAddSession, SessionRef{3, 0, 9}));
  StateReader reader(regions.a.get());
  device.clock = &clock;
  device.read_cost_ns = 3 * kPeriodNs + kPeriodNs / 2;  // of the first cycle, from 1 ms to 4.5 ms
  run(3);
  std::vector<hd_sample> samples(8);
  std::uint64_t lost = 0;
  samples.resize(reader.drain(samples, lost));
  ASSERT_EQ(samples.size(), 3u);
  for (const hd_sample& sample : samples) EXPECT_EQ(sample.missed, sample.tick - (&sample - samples.data()) - 1);
  EXPECT_EQ(samples[1].missed, 2u);
  EXPECT_EQ(samples[1].wake_ns, 2 * kPeriodNs + kPeriodNs / 2);
  EXPECT_EQ(samples[1].t_ns, 4 * kPeriodNs + kPeriodNs / 2);
  EXPECT_EQ(regions.a->counters.max_wake_ns, 2 * kPeriodNs + kPeriodNs / 2);
}

TEST_F(ServoFixture, ASmallOverrunMissesNothingButCounts) {
  device.clock = &clock;
  device.read_cost_ns = kPeriodNs + kPeriodNs / 4;
  run(3);
  EXPECT_EQ(device.reads, (std::vector<std::int64_t>{kPeriodNs, 2 * kPeriodNs, 3 * kPeriodNs}));
  EXPECT_EQ(servo->counters.missed.load(), 0u);
  EXPECT_EQ(servo->counters.overruns.load(), 1u);
}

TEST_F(ServoFixture, SendsNothingUntilArmed) {
  servo->from_control.push(makeCommand(CommandKind::kAddObject, plane(1000)));
  run(2);
  device.sample.p = Vec3(0, 0, -0.001);
  run(5);
  EXPECT_NEAR(servo->lastOutput().device[0].contact.force.z(), 1.0, 1e-9);
  for (const DeviceCommand& command : device.sent) {
    EXPECT_EQ(command.force, Vec3::Zero());
    EXPECT_FALSE(command.enabled);
  }
}

TEST_F(ServoFixture, APlaneIsFeltOnceArmed) {
  servo->from_control.push(makeCommand(CommandKind::kAddObject, plane(1000)));
  device.sample.p = Vec3(0, 0, 0.001);
  arm();
  device.sample.p = Vec3(0, 0, -0.001);
  run(50);
  EXPECT_NEAR(device.sent.back().force.z(), 1.0, 1e-6);
  EXPECT_TRUE(device.sent.back().enabled);
}

TEST_F(ServoFixture, ACommandTakesEffectAtItsTick) {
  run(1);
  Command later = makeCommand(CommandKind::kAddObject, plane(1000));
  later.at_tick = 5;
  servo->from_control.push(later);
  while (servo->counters.tick.load() < 4) {
    run(1);
    EXPECT_EQ(servo->cycle().scene().find(makeObjectId(1, 1)), nullptr);
  }
  run(1);
  EXPECT_NE(servo->cycle().scene().find(makeObjectId(1, 1)), nullptr);
}

TEST_F(ServoFixture, TakesABoundedNumberOfOrdersEachCycle) {
  for (std::uint32_t i = 0; i < 3 * kControlCommandsPerCycle; ++i) {
    servo->from_control.push(makeCommand(CommandKind::kDisarm, DeviceRef{0}));
  }
  run(1);
  EXPECT_EQ(servo->counters.control_applied.load(), kControlCommandsPerCycle);
  run(2);
  EXPECT_EQ(servo->counters.control_applied.load(), 3 * kControlCommandsPerCycle);
}

TEST_F(ServoFixture, ARefusedCommandIsToldAndChangesNothing) {
  servo->from_control.push(makeCommand(CommandKind::kRemoveObject, ObjectRef{makeObjectId(7, 1)}));
  run(1);
  ServoEvent event;
  ASSERT_TRUE(servo->events.pop(event));
  EXPECT_EQ(event.kind, ServoEventKind::kCommandRefused);
  EXPECT_EQ(event.value, static_cast<std::uint32_t>(ErrorCode::kNotFound));
}

TEST_F(ServoFixture, PublishesEverySampleToASession) {
  auto a = std::make_unique<hd_region_a>();
  auto b = std::make_unique<hd_region_b>();
  initialiseRegions(a.get(), b.get(), {.epoch = 1, .session = 9, .device_count = 1, .period_ns = kPeriodNs});
  servo->ports[3].region.store(a.get());
  servo->from_control.push(makeCommand(CommandKind::kAddSession, SessionRef{3, 0, 9}));
  StateReader reader(a.get());
  device.script = [](std::int64_t now_ns, DeviceSample& sample) { sample.p.x() = static_cast<double>(now_ns); };
  run(20);
  std::vector<hd_sample> samples(64);
  std::uint64_t lost = 0;
  const std::uint32_t n = reader.drain(samples, lost);
  ASSERT_EQ(n, 20u);
  EXPECT_EQ(lost, 0u);
  for (std::uint32_t i = 0; i < n; ++i) {
    EXPECT_EQ(samples[i].tick, i + 1);
    EXPECT_EQ(samples[i].p[0], static_cast<double>((i + 1) * kPeriodNs));
  }
  servo->from_control.push(makeCommand(CommandKind::kFreeSession, SessionRef{3, 0, 9}));
  run(5);
  EXPECT_EQ(reader.drain(samples, lost), 0u);
}

TEST_F(ServoFixture, AStopLineZeroesTheVeryNextTick) {
  servo->from_control.push(makeCommand(CommandKind::kAddObject, plane(1000)));
  device.sample.p = Vec3(0, 0, 0.001);
  arm();
  device.sample.p = Vec3(0, 0, -0.001);
  run(50);
  ASSERT_GT(device.sent.back().force.norm(), 0.5);
  servo->stop_line.store(true);
  run(1);
  EXPECT_EQ(device.sent.back().force, Vec3::Zero());
  EXPECT_FALSE(device.sent.back().enabled);
  EXPECT_EQ(servo->cycle().deviceGuard(0).fault(), static_cast<std::uint32_t>(HD_FAULT_STOP_LINE));
}

TEST_F(ServoFixture, GravityCompensationIsASourceOfItsOwn) {
  device.sample.gravity = Vec3(0, 0.25, 2.5);
  run(2);
  EXPECT_EQ(device.sent.back().force, Vec3(0, 0, 0));  // not before it is armed
  arm();
  const DeviceOutput& out = servo->lastOutput().device[0];
  EXPECT_EQ(device.sent.back().force, Vec3(0, 0.25, 2.5));
  EXPECT_EQ(out.guard.by_source[HD_SOURCE_GRAVITY], Vec3(0, 0.25, 2.5));
  EXPECT_EQ(out.guard.by_source[HD_SOURCE_GUARD], Vec3(0, 0, 0));
  device.sample.gravity = Vec3(0, 0, 250);
  run(10);
  EXPECT_NEAR(device.sent.back().force.norm(), 10, 1e-9);  // the limit of the guard
  EXPECT_LE(device.sent.back().force.norm(), 10);
}

TEST_F(ServoFixture, ADeviceCanBeTheDeadManSwitchOfItsGroup) {
  device.sample.gravity = Vec3(0, 0, 1);
  arm();
  EXPECT_FALSE(servo->lastInput().deadman_open);
  device.sample.status = kGroupDeadmanOpen;
  run(1);
  EXPECT_TRUE(servo->lastInput().deadman_open);
  EXPECT_EQ(servo->cycle().deviceGuard(0).fault(), HD_FAULT_DEADMAN);
  EXPECT_EQ(device.sent.back().force, Vec3(0, 0, 0));
  device.sample.status = kDeviceOk;
  run(1);
  EXPECT_FALSE(servo->lastInput().deadman_open);
}

TEST(ServoDeadman, OneThatIsNotHeardOfIsNotHeld) {
  ManualClock clock{123'456};
  test::ScriptedDevice arm, deadman;
  MeshTable meshes;
  CycleConfig config;
  config.period_ns = kPeriodNs;
  config.device_count = 2;
  config.guard.fill(openGuard());
  Servo servo(config, {&arm, &deadman}, meshes, clock);
  const auto run = [&](int cycles) {
    for (int i = 0; i < cycles; ++i) servo.runOnce();
  };
  servo.begin();
  deadman.sample.status = kGroupDeadmanOpen;  // Nobody has held it yet.
  run(5);
  deadman.sample.status = kDeviceOk;
  run(5);
  ASSERT_TRUE(servo.from_control.push(makeCommand(CommandKind::kArm, DeviceRef{0})));
  run(10);
  ASSERT_TRUE(servo.cycle().deviceGuard(0).armed());
  deadman.sample.fresh = false;  // Its thread hangs while it is held.
  run(100);
  EXPECT_FALSE(servo.lastInput().deadman_open);
  run(1);
  EXPECT_TRUE(servo.lastInput().deadman_open);
  EXPECT_EQ(servo.cycle().deviceGuard(0).fault(), HD_FAULT_DEADMAN);
  deadman.sample.fresh = true;
  run(1);
  EXPECT_FALSE(servo.lastInput().deadman_open);
  arm.sample.fresh = false;  // One that is no dead-man switch holds up nobody else.
  run(150);
  EXPECT_FALSE(servo.lastInput().deadman_open);
}

TEST_F(ServoFixture, PassesIntentToTheDevice) {
  hd_intent wish{};
  wish.p[1] = 0.25;
  wish.q[0] = 1;
  servo->from_control.push(makeCommand(CommandKind::kIntent, wish));
  run(1);
  EXPECT_EQ(device.intent.p.y(), 0.25);
}

/** Control frees a mesh when the servo has passed the order that drops it: no older question may lie there then. */
TEST_F(ServoFixture, WhenTheLastToolIsGoneTheQuestionThatNamesItIsReplaced) {
  Collider collider;
  servo->collider = &collider;
  const std::uint32_t id = makeObjectId(2, 1);
  const AddObject box = test::solid(id, ShapeKind::kBox, {1000, 0, 0, 0}, {}, Vec3::Constant(0.01));
  SetBody body{};
  body.object = id;
  body.mass = 0.1;
  body.inertia[0] = body.inertia[1] = body.inertia[2] = 1e-5;
  ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kAddObject, box)));
  ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kSetBody, body)));
  run(3);  // Nobody takes the questions.
  ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kRemoveObject, ObjectRef{id})));
  run(3);
  ASSERT_FALSE(servo->cycle().scene().find(id));
  const auto question = std::make_unique<CollideRequest>();
  ASSERT_TRUE(collider.questions.take(*question));
  EXPECT_EQ(question->orders, servo->counters.control_applied.load());
  for (const CollideRequest::Held& held : question->held) EXPECT_EQ(held.object, 0u);
  run(3);
  EXPECT_FALSE(collider.questions.take(*question)) << "with nothing to ask nothing is asked";
}

/** So it is where a body is still asked for. */
TEST_F(ServoFixture, AToolThatIsGoneIsNamedInNoFurtherQuestion) {
  Collider collider;
  servo->collider = &collider;
  const std::uint32_t tool = makeObjectId(2, 1), loose = makeObjectId(3, 1);
  for (const std::uint32_t id : {tool, loose}) {
    const AddObject box = test::solid(id, ShapeKind::kBox, {1000, 0, 0, 0}, {}, Vec3::Constant(0.01));
    ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kAddObject, box)));
  }
  SetBody body{};
  body.object = loose;
  body.mass = 0.1;
  body.inertia[0] = body.inertia[1] = body.inertia[2] = 1e-5;
  ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kSetBody, body)));
  const AttachTool attach = test::attachBox(tool, Vec3::Constant(0.02), device.info());
  ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kAttachTool, attach)));
  run(3);
  const auto question = std::make_unique<CollideRequest>();
  ASSERT_TRUE(collider.questions.take(*question));
  ASSERT_EQ(question->held[0].object, tool);
  ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kDetachTool, DeviceRef{0})));
  ASSERT_TRUE(servo->from_control.push(makeCommand(CommandKind::kRemoveObject, ObjectRef{tool})));
  run(3);
  ASSERT_TRUE(collider.questions.take(*question));
  EXPECT_EQ(question->held[0].object, 0u);
  EXPECT_EQ(question->held[kMaxDevices].object, loose);
}

// The same inputs give the same bits, whatever memory the cycle stands in.
TEST(Cycle, IsDeterministicToTheBit) {
  const auto trace = [] {
    CycleConfig config;
    config.guard.fill(openGuard());
    test::SteppedCycle hand(config);
    hand.add(test::solid(makeObjectId(1, 1), ShapeKind::kPlane, {700, 2, 0.6, 0.4}));
    hand.arm();
    std::vector<double> forces;
    for (int i = 0; i < 3000; ++i) {
      const DeviceOutput& out =
          hand.at({0.02 * std::sin(0.01 * i), 0.01 * std::cos(0.013 * i), 0.002 * std::sin(0.05 * i)});
      for (int axis = 0; axis < 3; ++axis) forces.push_back(out.command.force[axis]);
    }
    return forces;
  };
  const std::vector<double> first = trace();
  const auto padding = std::make_unique<char[]>(12345);
  const std::vector<double> second = trace();
  ASSERT_EQ(first.size(), second.size());
  EXPECT_EQ(std::memcmp(first.data(), second.data(), first.size() * sizeof(double)), 0);
  EXPECT_NE(first[3 * 2000 + 2], 0.0);
}

}  // namespace
}  // namespace hapticd
