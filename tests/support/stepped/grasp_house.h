/** @file
 * Two fingers, that are where a test says, and a block between them that falls, with servo and collide side stepped
 * together.
 */
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "rt/cycle/servo.h"
#include "tests/support/stepped/scripted_device.h"
#include "tests/support/stepped/solid.h"

namespace hapticd::test {

/** Index and thumb press on the faces at x = + and - size.x of a block about the origin. */
struct GraspHouse {
  static constexpr std::uint32_t kBlock = makeObjectId(2, 1);
  static constexpr double kDt = 1e-3;

  struct Block {
    Vec3 size = Vec3::Constant(0.025);  ///< Half of its edges [m].
    Vec3 com = Vec3::Zero();            ///< [m]
    double mass = 0.2;                  ///< [kg]
    hd_material material{1000, 1, 0.8, 0.6};
    double gravity = 9.81;
  };

  explicit GraspHouse(const Block& wanted) : block(wanted) {
    CycleConfig config;
    config.device_count = 2;
    GuardConfig guard;
    guard.limits = {.force = 20,
                    .torque = 1,
                    .force_slew = 1e5,
                    .torque_slew = 1e4,
                    .gripper_force = 1,
                    .velocity = 10,
                    .power = 1e3,
                    .active_power = 1e3};
    guard.ramp_ns = 1'000'000;
    config.guard.fill(guard);
    for (ScriptedDevice& d : device) d.actuateRotation();
    servo = std::make_unique<Servo>(config, std::array<Device*, kMaxDevices>{device.data(), &device[1]}, meshes, clock);
    servo->collider = &collider;
    servo->begin();
    press(-1e-3);
    add(kBlock, ShapeKind::kBox, block.size, Pose{});
    SetBody body{};
    body.object = kBlock;
    body.falls = 1;
    body.mass = block.mass;
    store(block.com, body.com);
    const MassProperties mass = MassProperties::ofBox(block.mass, 2 * block.size);
    for (int i = 0; i < 3; ++i) body.inertia[i] = mass.inertia_O(i, i);
    send(CommandKind::kSetBody, body);
    for (std::uint32_t d = 0; d < 2; ++d) send(CommandKind::kArm, DeviceRef{d});
    run(10);
  }
  void add(std::uint32_t id, ShapeKind kind, const Vec3& size, const Pose& X) {
    send(CommandKind::kAddObject, solid(id, kind, block.material, X, size));
  }
  template <class T>
  void send(CommandKind kind, const T& payload) {
    ASSERT_TRUE(servo->from_control.push(makeCommand(kind, payload)));
  }
  /** Gravity is there from now on. */
  void letGo() { send(CommandKind::kSetGravity, SetGravity{{0, 0, -block.gravity}}); }
  /** Both fingers as deep as that, at `at` from the middle of a block that has not moved. */
  void press(double depth, const Vec3& at = Vec3::Zero(), double turn = 0) {
    for (int d = 0; d < 2; ++d) {
      const double side = d == 0 ? 1 : -1;
      device[d].sample.p = at + Vec3(side * (block.size.x() - depth), 0, 0);
      device[d].sample.q = Quat(Eigen::AngleAxisd(turn, Vec3::UnitX()));
    }
  }
  void step() {
    servo->runOnce();
    for (ServoEvent event; servo->events.pop(event);) {
    }
    if (++tick % 2 == 0) collider.step(nullptr);
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }
  [[nodiscard]] const SceneObject& seen() const { return *servo->cycle().scene().find(kBlock); }
  [[nodiscard]] const RigidBody& body() const { return servo->cycle().bodies().body(0).body; }
  [[nodiscard]] const DeviceOutput& finger(int d) const { return servo->lastOutput().device[d]; }
  /** Of the block about x, from -pi to pi [rad]. */
  [[nodiscard]] double turned() const {
    const Quat& q = seen().X_WO.q;
    return 2 * std::atan2(q.x(), q.w());
  }

  Block block;
  int tick = 0;
  ManualClock clock;
  std::array<ScriptedDevice, 2> device;
  MeshTable meshes;
  Collider collider;
  std::unique_ptr<Servo> servo;
};

}  // namespace hapticd::test
