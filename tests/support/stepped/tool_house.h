/** @file
 * Servo, simulated device with its hand, and the collide side, stepped together; a floor at z = 0 and a box to hold.
 */
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "drivers/sim/sim_device.h"
#include "rt/base/rotation.h"
#include "rt/cycle/servo.h"
#include "tests/support/stepped/attach_tool.h"
#include "tests/support/stepped/solid.h"

namespace hapticd::test {

inline constexpr std::int64_t kPeriodNs = 1'000'000;
inline constexpr std::uint32_t kFloor = makeObjectId(1, 1), kTool = makeObjectId(2, 1), kWall = makeObjectId(3, 1);

inline AddObject object(std::uint32_t id, ShapeKind kind, const Vec3& size, const Vec3& at) {
  return solid(id, kind, {1000, 0, 0.4, 0.3}, {at, Quat::Identity()}, size);
}

/** What entered a cycle, without the room for commands that none came in: that is 35 kB in every tick. */
class KeptInput {
 public:
  explicit KeptInput(const CycleInput& from)
      : tick_(from.tick),
        now_ns_(from.now_ns),
        missed_(from.missed),
        stop_line_(from.stop_line),
        deadman_open_(from.deadman_open),
        device_(from.device),
        command_(from.command.begin(), from.command.begin() + from.command_count) {}
  [[nodiscard]] CycleInput whole() const {
    CycleInput out{tick_, now_ns_, missed_, stop_line_, deadman_open_, device_, 0, {}};
    for (const Command& command : command_) out.command[out.command_count++] = command;
    return out;
  }

 private:
  std::uint64_t tick_;
  std::int64_t now_ns_;
  std::uint32_t missed_;
  bool stop_line_, deadman_open_;
  std::array<DeviceSample, kMaxDevices> device_;
  std::vector<Command> command_;
};

/** Servo, simulated device with its hand, and the collide side, stepped together; a floor at z = 0 and a box. */
struct ToolHouse {
  explicit ToolHouse(const char* uri = "sim://default?dof=6", int collide_every = 2)
      : collide_every_(collide_every), device(resolveSim(parseDeviceUri(uri).value()).value()) {
    CycleConfig config;
    config.period_ns = kPeriodNs;
    GuardConfig guard;
    guard.limits = {.force = 12,
                    .torque = 1,
                    .force_slew = 1e5,
                    .torque_slew = 1e4,
                    .gripper_force = 1,
                    .velocity = 10,
                    .power = 1e3,
                    .active_power = 1e3};
    guard.ramp_ns = kPeriodNs;
    guard.delay = 0.25;
    config.guard.fill(guard);
    EXPECT_TRUE(device.open().ok());
    device.setIntent({{0, 0, 0.04}, Quat::Identity(), 0});
    servo = std::make_unique<Servo>(config, std::array<Device*, kMaxDevices>{&device}, meshes, clock);
    servo->collider = &collider;
    servo->begin();
    send(CommandKind::kAddObject, object(kFloor, ShapeKind::kPlane, Vec3::Zero(), Vec3::Zero()));
    send(CommandKind::kAddObject, object(kTool, ShapeKind::kBox, {0.01, 0.02, 0.005}, {0.5, 0, 0}));
    run(500);
  }
  template <class T>
  void send(CommandKind kind, const T& payload) {
    ASSERT_TRUE(servo->from_control.push(makeCommand(kind, payload)));
  }
  /** What is to be held is of another shape: of that size, or mesh number `mesh`. */
  void reshape(ShapeKind kind, const Vec3& size, std::uint32_t mesh = 0) {
    SetShape shape{kTool, 0, {static_cast<std::uint32_t>(kind), mesh, {}}};
    store(size, shape.shape.size);
    send(CommandKind::kSetShape, shape);
  }
  [[nodiscard]] AttachTool tool() const { return attachBox(kTool, {0.02, 0.04, 0.01}, device.info()); }
  void hold() { hold(tool()); }
  void hold(const AttachTool& tool) {
    send(CommandKind::kAttachTool, tool);
    run(5);
    ASSERT_TRUE(servo->cycle().tool(0).held());
    send(CommandKind::kArm, DeviceRef{0});
    run(20);
    ASSERT_TRUE(servo->cycle().deviceGuard(0).armed());
  }
  void aim(const Vec3& p, const Vec3& turn = Vec3::Zero()) { device.setIntent({p, fromRotationVector(turn), 0}); }
  void run(int ticks, bool collide = true) {
    for (int i = 0; i < ticks; ++i) {
      servo->runOnce();
      for (ServoEvent event; servo->events.pop(event);) events.push_back(event.kind);
      inputs.emplace_back(servo->lastInput());
      sent.push_back(servo->lastOutput().device[0].command);
      if (collide && ++ticks_ % collide_every_ == 0) collider.step(nullptr);
    }
  }
  /** Events of a kind so far. */
  [[nodiscard]] int told(ServoEventKind kind) const {
    return static_cast<int>(std::count(events.begin(), events.end(), kind));
  }
  [[nodiscard]] const DeviceOutput& out() const { return servo->lastOutput().device[0]; }
  [[nodiscard]] Pose place() const { return servo->cycle().tool(0).tool().body().pose(); }

  int collide_every_, ticks_ = 0;
  ManualClock clock;
  SimDevice device;
  MeshTable meshes;
  Collider collider;
  std::unique_ptr<Servo> servo;
  std::vector<KeptInput> inputs;
  std::vector<DeviceCommand> sent;
  std::vector<ServoEventKind> events;
};

/** Another cycle, fed what the house's was, sends what it sent, bit for bit: contacts are among the commands. */
inline std::unique_ptr<Cycle> expectTheSameForces(const ToolHouse& house) {
  auto cycle = std::make_unique<Cycle>(house.servo->cycle().config(), house.meshes);
  cycle->setResolution(0, house.device.info().position_resolution, house.device.info().rotation_resolution);
  const auto output = std::make_unique<CycleOutput>();
  for (std::size_t i = 0; i < house.inputs.size() && !::testing::Test::HasFailure(); ++i) {
    cycle->step(house.inputs[i].whole(), *output);
    const DeviceCommand& now = output->device[0].command;
    EXPECT_EQ(std::memcmp(&now.force, &house.sent[i].force, sizeof(Vec3)), 0) << "tick " << i;
    EXPECT_EQ(std::memcmp(&now.torque, &house.sent[i].torque, sizeof(Vec3)), 0) << "tick " << i;
  }
  return cycle;
}

}  // namespace hapticd::test
