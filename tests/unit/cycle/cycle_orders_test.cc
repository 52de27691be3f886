// Orders that name what is not there, or ask for more than there is: refused, told, and without effect.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

/** Two devices; a session in slot 1. */
class CycleOrders : public testing::Test, protected test::SteppedCycle {
 protected:
  CycleOrders() : SteppedCycle(config()) {
    for (DeviceSample& sample : input->device) sample.fresh = true;
    EXPECT_EQ(session(CommandKind::kAddSession, kSession), ErrorCode::kOk);
  }
  /** What becomes of it. */
  template <class T>
  ErrorCode send(CommandKind kind, const T& payload, std::uint32_t from = kControlSession, std::uint32_t channel = 0) {
    Command& command = put(kind, payload, from);
    command.channel = channel;
    command.seq = ++seq;
    step();
    ErrorCode code = ErrorCode::kOk;
    for (std::uint32_t i = 0; i < output->events.count; ++i) {
      const ServoEvent& event = output->events.event[i];
      if (event.kind != ServoEventKind::kCommandRefused) continue;
      EXPECT_EQ(event.order, static_cast<std::uint32_t>(kind)) << "which it was";
      EXPECT_EQ(event.session, from) << "and whose";
      code = static_cast<ErrorCode>(event.value);
    }
    EXPECT_EQ(output->applied_commands, code == ErrorCode::kOk ? 1u : 0u);
    return code;
  }
  ErrorCode session(CommandKind kind, std::uint32_t slot) { return send(kind, SessionRef{slot, 0, 7}); }
  SessionShare::Life life() const { return cycle->session(kSession).life(); }

  static constexpr std::uint32_t kDevices = 2, kSession = 1;
  static CycleConfig config() {
    CycleConfig config;
    config.device_count = kDevices;
    for (GuardConfig& guard : config.guard) guard.limits = {10, 1, 1e6, 1e3, 5, 10, 50, 50};
    return config;
  }
  std::uint64_t seq = 0;
};

TEST_F(CycleOrders, ForDevicesThatAreNotThereAreRefused) {
  for (const std::uint32_t device : {kDevices, kMaxDevices - 1, kMaxDevices, 0xffffffffu}) {
    for (const CommandKind kind : {CommandKind::kArm, CommandKind::kDisarm, CommandKind::kDetachTool})
      EXPECT_EQ(send(kind, DeviceRef{device}), ErrorCode::kInvalidArgument) << device;
    EXPECT_EQ(send(CommandKind::kStop, StopOrder{device, 0}), ErrorCode::kInvalidArgument) << device;
    EXPECT_EQ(send(CommandKind::kDeviceLimits, DeviceLimits{device}), ErrorCode::kInvalidArgument) << device;
    EXPECT_EQ(send(CommandKind::kDeviceRadius, DeviceRadius{device}), ErrorCode::kInvalidArgument) << device;
    EXPECT_EQ(send(CommandKind::kAttachTool, AttachTool{device}), ErrorCode::kInvalidArgument) << device;
    EXPECT_EQ(send(CommandKind::kSetGrip, SetGrip{device}), ErrorCode::kInvalidArgument) << device;
    EXPECT_EQ(send(CommandKind::kSetFinger, SetFinger{device}), ErrorCode::kInvalidArgument) << device;
    EXPECT_EQ(send(CommandKind::kSetClutch, SetClutch{device, 0, 0, 0, {}}), ErrorCode::kInvalidArgument) << device;
    EXPECT_EQ(send(CommandKind::kSetMount, SetMount{device, 0, {}, {1, 0, 0, 0}, 1}), ErrorCode::kInvalidArgument)
        << device;
    hd_intent wish{};
    wish.device = device;
    EXPECT_EQ(send(CommandKind::kIntent, wish), ErrorCode::kInvalidArgument) << device;
    for (const DeviceOutput& out : output->device) EXPECT_FALSE(out.has_intent);
  }
  for (std::uint32_t device = kDevices; device < kMaxDevices; ++device)
    EXPECT_EQ(send(CommandKind::kToolContacts, ToolContacts{device}), ErrorCode::kInvalidArgument) << device;
  EXPECT_EQ(send(CommandKind::kToolContacts, ToolContacts{kMaxDevices}), ErrorCode::kOk) << "of a body that is gone";
  for (std::uint32_t device = 0; device < kDevices; ++device) {
    EXPECT_EQ(send(CommandKind::kToolContacts, ToolContacts{device}), ErrorCode::kOk) << "of a tool that is gone";
    EXPECT_EQ(cycle->deviceGuard(device).fault(), HD_FAULT_NONE);
    EXPECT_EQ(cycle->deviceGuard(device).limits().force, 10);
  }
}

TEST_F(CycleOrders, OfOneDeviceLeaveTheOthersAlone) {
  EXPECT_EQ(send(CommandKind::kArm, DeviceRef{1}), ErrorCode::kOk);
  EXPECT_EQ(send(CommandKind::kDeviceRadius, DeviceRadius{1, 0, 0.01}), ErrorCode::kOk);
  EXPECT_EQ(send(CommandKind::kSetGrip, SetGrip{1, 0, 20, 0.5}), ErrorCode::kOk);
  EXPECT_EQ(send(CommandKind::kDeviceLimits, DeviceLimits{1, 0, 2, 1, 1e6, 1e3, 10, 50, 50, 5}), ErrorCode::kOk);
  EXPECT_TRUE(cycle->deviceGuard(1).armed());
  EXPECT_EQ(cycle->deviceRadius(1), 0.01);
  EXPECT_EQ(cycle->grip(1).stiffness, 20);
  EXPECT_EQ(cycle->deviceGuard(1).limits().force, 2);
  EXPECT_FALSE(cycle->deviceGuard(0).armed());
  EXPECT_EQ(cycle->deviceRadius(0), 0);
  EXPECT_EQ(cycle->grip(0).stiffness, 0);
  EXPECT_EQ(cycle->deviceGuard(0).limits().force, 10);
  EXPECT_EQ(send(CommandKind::kStop, StopOrder{0, 0}), ErrorCode::kOk);
  EXPECT_TRUE(cycle->deviceGuard(1).armed());
  EXPECT_EQ(send(CommandKind::kDisarm, DeviceRef{1}), ErrorCode::kOk);
  for (int i = 0; i < 3; ++i) step();
  EXPECT_FALSE(cycle->deviceGuard(1).armed());
}

TEST_F(CycleOrders, AStopLatchesItsCauseAndTheStopLineForWantOfOne) {
  for (std::uint32_t cause = 0; cause < HD_FAULT_COUNT + 2; ++cause) {
    EXPECT_EQ(send(CommandKind::kStop, StopOrder{0, cause}), ErrorCode::kOk);
    const bool known = cause != HD_FAULT_NONE && cause < HD_FAULT_COUNT;
    EXPECT_EQ(cycle->deviceGuard(0).fault(), known ? cause : std::uint32_t{HD_FAULT_STOP_LINE});
    step();
    EXPECT_EQ(send(CommandKind::kArm, DeviceRef{0}), ErrorCode::kOk) << "the cause is gone";
    ASSERT_EQ(cycle->deviceGuard(0).fault(), HD_FAULT_NONE);
  }
}

TEST_F(CycleOrders, ARadiusIsWithinWhatIsTold) {
  const double most = ProxyRenderer::kMaxRadius;
  for (const double radius : {most, 0.0, 0.004}) {
    EXPECT_EQ(send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, radius}), ErrorCode::kOk);
    EXPECT_EQ(cycle->deviceRadius(0), radius);
  }
  for (const double radius : {-1e-9, std::nextafter(most, 1), kInf, -kInf, kNan}) {
    EXPECT_EQ(send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, radius}), ErrorCode::kInvalidArgument) << radius;
    EXPECT_EQ(cycle->deviceRadius(0), 0.004);
  }
}

TEST_F(CycleOrders, AGripIsFiniteAndNotNegative) {
  for (const auto& [stiffness, width] : {std::array{0.0, 0.0}, {999e3, 0.0}, {0.0, 9.9}, {20.0, 0.5}}) {
    EXPECT_EQ(send(CommandKind::kSetGrip, SetGrip{0, 0, stiffness, width}), ErrorCode::kOk) << stiffness;
    EXPECT_EQ(cycle->grip(0).stiffness, stiffness);
    EXPECT_EQ(cycle->grip(0).width, width);
  }
  for (const double bad : {-1e-9, 1e6, kInf, -kInf, kNan}) {
    EXPECT_EQ(send(CommandKind::kSetGrip, SetGrip{0, 0, bad, 0.5}), ErrorCode::kInvalidArgument) << bad;
    EXPECT_EQ(send(CommandKind::kSetGrip, SetGrip{0, 0, 20, bad}), ErrorCode::kInvalidArgument) << bad;
  }
  EXPECT_EQ(send(CommandKind::kSetGrip, SetGrip{0, 0, 20, 10}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(cycle->grip(0).stiffness, 20);
  EXPECT_EQ(cycle->grip(0).width, 0.5);
}

TEST_F(CycleOrders, AFingerThatIsNoneLeavesTheOneThatIs) {
  SetFinger finger{};
  finger.law = static_cast<std::uint32_t>(PadLaw::kLinear);
  finger.radius = finger.arm = 5e-3;
  finger.stiffness = 0.1;
  EXPECT_EQ(send(CommandKind::kSetFinger, finger), ErrorCode::kOk);
  SetFinger bad = finger;
  for (bad.radius = 0; const double stiffness : {0.1, kNan}) {
    bad.stiffness = stiffness;
    EXPECT_EQ(send(CommandKind::kSetFinger, bad), ErrorCode::kInvalidArgument);
    EXPECT_EQ(cycle->finger(0).order().radius, 5e-3);
  }
}

TEST_F(CycleOrders, AClutchOfAButtonThatIsNoneLeavesTheOneThatIs) {
  EXPECT_EQ(send(CommandKind::kSetClutch, SetClutch{1, 0, 32, 0, {}}), ErrorCode::kOk);
  EXPECT_EQ(send(CommandKind::kSetClutch, SetClutch{1, 1, 33, 0, {}}), ErrorCode::kInvalidArgument);
  EXPECT_FALSE(cycle->clutch(1).held(0));
  EXPECT_TRUE(cycle->clutch(1).held(1u << 31));
  EXPECT_FALSE(cycle->clutch(0).held(1u << 31));
}

TEST_F(CycleOrders, AWishIsToldOfItsDeviceInItsTickAlone) {
  for (std::uint32_t device = 0; device < kDevices; ++device) {
    hd_intent wish{};
    wish.device = device;
    wish.p[0] = 0.01;
    wish.q[0] = 1;
    wish.gripper_rad = 0.3;
    EXPECT_EQ(send(CommandKind::kIntent, wish), ErrorCode::kOk);
    for (std::uint32_t d = 0; d < kDevices; ++d) EXPECT_EQ(output->device[d].has_intent, d == device) << d;
    EXPECT_EQ(output->device[device].intent.p, Vec3(0.01, 0, 0));
    EXPECT_EQ(output->device[device].intent.gripper_rad, 0.3);
    step();
    for (std::uint32_t d = 0; d < kDevices; ++d) EXPECT_FALSE(output->device[d].has_intent) << d;
  }
}

/** One that overtakes others that wait may make nothing stronger. */
TEST_F(CycleOrders, LimitsThatOnlyLowerRaiseNone) {
  const DeviceLimits wanted{0, 1, 20, 0.5, 2e6, 500, 20, 25, 100, 2.5};  // Every other one is lower.
  EXPECT_EQ(send(CommandKind::kDeviceLimits, wanted), ErrorCode::kOk);
  const GuardLimits lowered = cycle->deviceGuard(0).limits(), before = config().guard[0].limits;
  EXPECT_EQ(lowered.force, before.force);
  EXPECT_EQ(lowered.torque, 0.5);
  EXPECT_EQ(lowered.force_slew, before.force_slew);
  EXPECT_EQ(lowered.torque_slew, 500);
  EXPECT_EQ(lowered.velocity, before.velocity);
  EXPECT_EQ(lowered.power, 25);
  EXPECT_EQ(lowered.active_power, before.active_power);
  EXPECT_EQ(lowered.gripper_force, 2.5);
  DeviceLimits all = wanted;
  all.only_lowers = 0;
  EXPECT_EQ(send(CommandKind::kDeviceLimits, all), ErrorCode::kOk);
  EXPECT_EQ(cycle->deviceGuard(0).limits().force, 20);
  EXPECT_EQ(cycle->deviceGuard(0).limits().torque, 0.5);
}

TEST_F(CycleOrders, OfSessionsThatAreNotThereAreRefused) {
  for (const std::uint32_t slot : {kMaxSessions, 0xffffffffu}) {
    for (const CommandKind kind : {CommandKind::kAddSession, CommandKind::kLoseSession, CommandKind::kReviveSession,
                                   CommandKind::kFreeSession}) {
      EXPECT_EQ(session(kind, slot), ErrorCode::kInvalidArgument) << slot;
    }
  }
  for (const std::uint32_t slot : {kMaxSessions, kControlSession})
    EXPECT_EQ(send(CommandKind::kLimits, hd_limits{1, 1}, slot), ErrorCode::kInvalidArgument) << slot;
  EXPECT_EQ(send(CommandKind::kLimits, hd_limits{1, 1}, kSession + 1), ErrorCode::kDisconnected) << "it is free";
}

TEST_F(CycleOrders, OnlyALostSessionIsRevivedAndOnlyALiveOneIsHeard) {
  using Life = SessionShare::Life;
  const auto heard = [&] { return send(CommandKind::kLimits, hd_limits{1, 1}, kSession); };
  EXPECT_EQ(heard(), ErrorCode::kOk);
  EXPECT_EQ(session(CommandKind::kReviveSession, kSession), ErrorCode::kOk);
  EXPECT_EQ(life(), Life::kAlive);
  EXPECT_EQ(cycle->session(kSession).fade(input->now_ns), 1) << "it does not begin to return";
  EXPECT_EQ(session(CommandKind::kLoseSession, kSession), ErrorCode::kOk);
  EXPECT_EQ(life(), Life::kLost);
  EXPECT_EQ(heard(), ErrorCode::kDisconnected);
  const float before = cycle->session(kSession).fade(input->now_ns);
  EXPECT_EQ(session(CommandKind::kLoseSession, kSession), ErrorCode::kOk);
  EXPECT_LT(cycle->session(kSession).fade(input->now_ns), before) << "its fade does not begin anew";
  EXPECT_EQ(session(CommandKind::kReviveSession, kSession), ErrorCode::kOk);
  EXPECT_EQ(life(), Life::kAlive);
  EXPECT_EQ(heard(), ErrorCode::kOk);
  EXPECT_EQ(session(CommandKind::kFreeSession, kSession), ErrorCode::kOk);
  for (const CommandKind kind : {CommandKind::kLoseSession, CommandKind::kReviveSession}) {
    EXPECT_EQ(session(kind, kSession), ErrorCode::kOk);
    EXPECT_EQ(life(), Life::kFree);
  }
  EXPECT_EQ(heard(), ErrorCode::kDisconnected);
}

/** Refused or not: its sender learns that it has been looked at. A mailbox counts its own. */
TEST_F(CycleOrders, WhatCameThroughTheRingIsAcknowledgedToWhoSentIt) {
  const SessionShare &own = cycle->session(kSession), &other = cycle->session(kSession - 1);
  EXPECT_EQ(send(CommandKind::kLimits, hd_limits{1, 1}, kSession), ErrorCode::kOk);
  EXPECT_EQ(own.appliedSeq(), seq);
  EXPECT_EQ(own.appliedTick(), input->tick);
  EXPECT_EQ(send(CommandKind::kLimits, hd_limits{-1, 1}, kSession), ErrorCode::kInvalidArgument);
  EXPECT_EQ(own.appliedSeq(), seq);
  const std::uint64_t last = seq;
  for (const std::uint32_t channel : {1u, 2u, std::uint32_t{HD_MAILBOXES}})
    EXPECT_EQ(send(CommandKind::kLimits, hd_limits{1, 1}, kSession, channel), ErrorCode::kOk);
  EXPECT_EQ(session(CommandKind::kLoseSession, kSession), ErrorCode::kOk) << "of control, that counts nothing";
  EXPECT_EQ(own.appliedSeq(), last);
  EXPECT_EQ(other.appliedSeq(), 0u);
}

TEST_F(CycleOrders, HoweverManyAreRefusedWhatDevicesAndHandsDoIsTold) {
  const auto told = [&](ServoEventKind kind, std::uint32_t device) {
    const std::span events(output->events.event.data(), output->events.count);
    return std::ranges::count_if(events, [&](const ServoEvent& e) { return e.kind == kind && e.device == device; });
  };
  const hd_object_pose gone = poseMessage(makeObjectId(1, 1), Pose{});
  while (input->command_count + kDevices < kMaxCommandsPerCycle) put(CommandKind::kObjectPose, gone, kSession);
  const std::uint32_t refused = input->command_count;
  for (std::uint32_t d = 0; d < kDevices; ++d) {
    put(CommandKind::kStop, StopOrder{d, HD_FAULT_STOP_LINE}, kControlSession);
    input->device[d].buttons = 1;
  }
  step();
  for (std::uint32_t d = 0; d < kDevices; ++d) {
    EXPECT_EQ(told(ServoEventKind::kFault, d), 1);
    EXPECT_EQ(told(ServoEventKind::kButton, d), 1);
  }
  EXPECT_EQ(static_cast<std::uint32_t>(told(ServoEventKind::kCommandRefused, 0)) + output->events.dropped, refused)
      << "or counted";
  EXPECT_GE(told(ServoEventKind::kCommandRefused, 0), 16) << "as many as one client may send";
}

}  // namespace
}  // namespace hapticd
