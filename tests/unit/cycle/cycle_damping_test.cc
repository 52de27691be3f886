// What contact, drags in free space and the passivity controller damp, together, by way of the cycle.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/stepped/attach_tool.h"
#include "tests/support/stepped/mount_at.h"
#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/test_effect.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kDampedWall = makeObjectId(1, 1), kThickBath = makeObjectId(2, 1);

AddObject wall(double stiffness, double damping) {
  return test::solid(kDampedWall, ShapeKind::kPlane, {stiffness, damping, 0, 0});
}

void addBath(test::SteppedCycle& hand, double damping) {
  hand.add(test::solid(kThickBath, ShapeKind::kGroup, {}));
  hand.put(CommandKind::kSetEffect, SetEffect{kThickBath, 0, test::effect(EffectKind::kViscous, 100, 0, damping, 10)});
}

/** Of two clients one gives a plane where the wall is, the other a spring that only damps. */
void addModels(test::SteppedCycle& hand, double damping) {
  hd_local_model plane{};
  plane.kind = HD_MODEL_PLANE;
  plane.normal[2] = 1;
  plane.material = {500, static_cast<float>(damping), 0, 0};
  plane.lease_ns = 100'000'000'000;
  hd_local_model spring = plane;
  spring.kind = HD_MODEL_SPRING;
  spring.material.stiffness = 0;
  for (std::uint32_t client = 0; client < 2; ++client) {
    hand.put(CommandKind::kAddSession, SessionRef{client, 0, client + 1});
    hand.put(CommandKind::kLocalModel, client == 0 ? plane : spring, client);
  }
}

struct Damped {
  double by_bath = 0, by_guard = 0;  ///< [N s/m]
};

/** The most that damps while a hand shakes in a wall so stiff that it makes energy. */
Damped mostIn(double wall_damping, double bath_damping, double device_can) {
  CycleConfig config = test::openConfig(100);
  config.guard[0].energy_limit = 100;
  config.guard[0].max_damping = device_can;
  test::SteppedCycle hand(config);
  hand.add(wall(20'000, wall_damping));
  if (bath_damping > 0) addBath(hand, bath_damping);
  hand.arm();
  Damped most;
  for (int i = 0; i < 3000; ++i) {
    const double z = i < 100 ? 0.001 : -0.5e-3 - 0.3e-3 * std::sin(2 * std::numbers::pi * 0.02 * (i - 100));
    const DeviceOutput& out = hand.at({0, 0, z});
    EXPECT_EQ(out.guard.fault, HD_FAULT_NONE);
    const double v = out.velocity.v.z();
    if (i < 2000 || std::abs(v) < 0.02) continue;
    const double drag = out.guard.by_source[HD_SOURCE_EFFECT].z();
    most.by_bath = std::max(most.by_bath, -drag / v);
    most.by_guard = std::max(most.by_guard, (out.contact.force.z() + drag - out.command.force.z()) / v);
  }
  return most;
}

// Together no more than one and a half times what the device can show, and the controller alone no more than once.
TEST(CycleDamping, TheControllerAddsWhatTheContactLeaves) {
  for (const double can : {2.0, 4.0}) {
    const double alone = mostIn(0, 0, can).by_guard;
    EXPECT_GT(alone, can / 2);
    for (const double of_wall : {0.25, 0.5, 0.6, 0.75, 1.0, 1.25, 1.4, 1.5, 2.0, 3.0}) {  // Of what it can.
      EXPECT_NEAR(mostIn(of_wall * can, 0, can).by_guard / alone, std::clamp(1.5 - of_wall, 0.0, 1.0), 1e-9)
          << of_wall << " of " << can;
    }
  }
}

// Drags have what the contact leaves, the controller what both leave.
TEST(CycleDamping, DragsAreCountedToo) {
  const double can = 4, alone = mostIn(0, 0, can).by_guard;
  for (const double of_wall : {0.0, 0.25, 0.75, 1.25, 1.5, 3.0}) {  // Of what it can.
    for (const double bath : {0.25, 0.75, 1.0, 100.0}) {
      const double by_bath = std::min(bath, std::clamp(1.5 - of_wall, 0.0, 1.0));
      const Damped most = mostIn(of_wall * can, bath * can, can);
      EXPECT_NEAR(most.by_bath / can, by_bath, 1e-9) << of_wall << ", " << bath;
      EXPECT_NEAR(most.by_guard / alone, std::clamp(1.5 - of_wall - by_bath, 0.0, 1.0), 1e-9)
          << of_wall << ", " << bath;
    }
  }
}

/** By what a soft finger damps that sticks to a heavy body, and a bath about it [N s/m]. */
struct PadAndBath {
  double pad = 0, bath = 0;
};

/** In a world so many times as large. */
PadAndBath damps(double pad_damping, double device_can, double scale) {
  CycleConfig config = test::openConfig(100);
  config.guard[0].max_damping = device_can;
  test::SteppedCycle hand(config);
  const std::uint32_t body = makeObjectId(1, 1);
  hand.put(CommandKind::kSetMount, test::mountAt({}, 0, scale));
  hand.add(
      test::solid(body, ShapeKind::kBox, {1000, 0, 5, 5}, {{0, 0, -0.05}, Quat::Identity()}, Vec3::Constant(0.05)));
  hand.put(CommandKind::kSetBody, SetBody{body, 0, 100, {}, {100, 100, 100, 0, 0, 0}, 0});
  addBath(hand, 1000);
  SetFinger finger{};
  finger.law = static_cast<std::uint32_t>(PadLaw::kLinear);
  finger.radius = finger.arm = 5e-3;
  finger.stiffness = 0.1;
  finger.damping = pad_damping;
  hand.put(CommandKind::kSetFinger, finger);
  PadAndBath seen;
  for (int i = 0; i < 100; ++i) {
    ToolContacts none{};  // It touches nothing else, which it is to be told.
    none.device = kMaxDevices;
    none.object = body;
    hand.answer(none);
    const DeviceOutput& out = hand.at(Vec3(0, 2e-5 * i, i == 0 ? 0.001 : -0.005) / scale);
    const SurfaceContact& c = out.contact;
    if (i < 50) continue;
    EXPECT_FALSE(c.slip);
    const Vec3 pad = c.force - c.stiffness * c.pull - c.damping * c.normal;
    seen.pad = pad.y() / (c.at_hip - out.velocity.v).y();
    seen.bath = -out.guard.by_source[HD_SOURCE_EFFECT].y() / out.velocity.v.y();
  }
  return seen;
}

// A finger damps by what the device bears in that world, and drags have what it leaves.
TEST(CycleDamping, AFingersPadIsCountedToo) {
  const double device_can = 4;
  for (const double scale : {1.0, 2.0}) {
    const double can = device_can / scale;
    for (const double of_pad : {0.0, 0.25, 0.75, 1.0, 1.4, 3.0, 20.0}) {  // Of what it can.
      const PadAndBath seen = damps(of_pad * can, device_can, scale);
      EXPECT_NEAR(seen.pad / can, std::min(of_pad, 1.5), 1e-5) << of_pad << ", " << scale;
      EXPECT_NEAR(seen.bath / can, std::clamp(1.5 - of_pad, 0.0, 1.0), 1e-9) << of_pad << ", " << scale;
    }
  }
}

/** RMS of what alternates from tick to tick in the force on 150 g that are pressed to where a wall may be [N]. */
double alternates(test::SteppedCycle& hand, std::uint32_t tool = 0) {
  double x = 0.003, v = 0, sum = 0;
  std::array<double, 4> sent{};  // The youngest first.
  for (int i = 0; i < 6000; ++i) {
    constexpr int kParts = 20;
    constexpr double dt = 1e-3 / kParts;
    for (int part = 0; part < kParts; ++part) {
      v += dt / 0.15 * (sent[1] - 6 - 400 * x - 0.5 * v);
      x += dt * v;
    }
    ToolContacts none{};
    none.object = tool;
    if (tool != 0) hand.answer(none);
    std::rotate(sent.begin(), sent.end() - 1, sent.end());
    sent[0] = hand.at({0, 0, std::round(x / 10e-6) * 10e-6}).command.force.z();
    if (i >= 4000) sum += std::pow((sent[0] - 2 * sent[1] + sent[2]) / 4, 2);
  }
  return std::sqrt(sum / 2000);
}

/** Of a device whose forces are a tick late. */
CycleConfig lateConfig(double device_can) {
  CycleConfig config = test::openConfig(200);
  config.guard[0].energy_limit = 100;
  config.guard[0].max_damping = device_can;
  config.guard[0].delay = 1;
  return config;
}

void armAbove(test::SteppedCycle& hand) {
  hand.arm();
  for (int i = 0; i < 20; ++i) (void)hand.at({0, 0, 0.003});
}

double alternates(double wall_damping, double bath_damping, double device_can, double model_damping = 0) {
  test::SteppedCycle hand(lateConfig(device_can));
  hand.add(wall(20'000, wall_damping));
  if (bath_damping > 0) addBath(hand, bath_damping);
  armAbove(hand);
  if (model_damping > 0) addModels(hand, model_damping);
  return alternates(hand);
}

/** With a tool of 100 g in it, in free space, on whose coupling lies that damper. */
double alternatesWithTool(double tool_damping, double bath_damping, double device_can) {
  test::SteppedCycle hand(lateConfig(device_can));
  const std::uint32_t box = makeObjectId(3, 1);
  const Vec3 sides = Vec3::Constant(0.02);
  hand.add(test::solid(box, ShapeKind::kBox, {500, 0, 0, 0}, {}, sides));
  if (bath_damping > 0) addBath(hand, bath_damping);
  AttachTool tool = test::attachBox(box, sides, {});
  tool.damping = tool_damping;
  hand.put(CommandKind::kAttachTool, tool);
  armAbove(hand);
  return alternates(hand, box);
}

// The device bears 110 N s/m, and says that it can show half of it. Two and a half times that would throw it by 14 N.
TEST(CycleDamping, AHandInABathIsNotThrownOffAWall) {
  const double can = 55;
  for (const double of_wall : {0.0, 0.5, 1.0, 1.5}) {  // Of what it can.
    EXPECT_LT(alternates(of_wall * can, 1000, can), 0.8) << of_wall;
  }
}

// Clients' models damp by what surfaces leave, drags and controller by what models leave.
TEST(CycleDamping, AHandInClientsModelsIsNotThrownOffAWall) {
  const double can = 55;
  for (const double of_models : {0.5, 1.0, 3.0}) {  // Of what it can.
    for (const double of_wall : {0.0, 0.75, 1.5}) {
      for (const double bath : {0.0, 1000.0}) {
        EXPECT_LT(alternates(of_wall * can, bath, can, of_models * can), 1.2)
            << of_models << ", " << of_wall << ", " << bath;
      }
    }
  }
}

// However much a surface is told to damp.
TEST(CycleDamping, ASurfaceDampsByWhatTheDeviceBears) {
  const double can = 55;
  for (const double of_wall : {1.5, 2.5, 5.0, 20.0}) {
    EXPECT_LT(alternates(of_wall * can, 0, can), 0.8) << of_wall;
  }
}

// In a world that is larger than the hand's each metre per second of the hand is more of the wall's.
TEST(CycleDamping, AlsoThroughAMount) {
  const double can = 4;
  for (const double scale : {0.5, 1.0, 2.0}) {
    for (const double of_wall : {0.5, 1.4, 3.0, 20.0}) {
      CycleConfig config = test::openConfig(200);
      config.guard[0].max_damping = can;
      test::SteppedCycle hand(config);
      hand.put(CommandKind::kSetMount, test::mountAt({}, 0, scale));
      hand.add(wall(500, of_wall * can / scale));
      for (int i = 0; i < 100; ++i) {
        const Vec3 at(0, 0, 0.002 - 5e-5 * i);
        const DeviceOutput& out = hand.at(at);
        if (i < 50) continue;
        const double damps = (out.contact.force.z() + 500 * scale * at.z()) / 0.05;  // By the hand's 50 mm/s.
        EXPECT_NEAR(damps / can, std::min(of_wall, 1.5), 1e-6) << of_wall << ", " << scale;
      }
    }
  }
}

// A tool's damper lies behind a spring: from tick to tick, where a device is thrown, it adds nothing to what damps.
TEST(CycleDamping, TheDamperOfAHeldToolThrowsNobody) {
  const double can = 55;
  for (const double of_tool : {0.0, 0.1, 0.5, 1.0, 3.0, 20.0}) {  // Of what it can.
    for (const double bath : {0.0, 1000.0}) {
      EXPECT_LT(alternatesWithTool(of_tool * can, bath, can), 0.05) << of_tool << ", " << bath;
    }
  }
}

}  // namespace
}  // namespace hapticd
