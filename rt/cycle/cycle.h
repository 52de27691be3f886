/** @file
 * The cycle: estimate -> render -> guard, without a thread, a device or a clock. The servo wraps it; tests and
 * benchmarks step it by hand.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/cycle/clutch.h"
#include "rt/cycle/cycle_input.h"
#include "rt/cycle/event.h"
#include "rt/cycle/free_bodies.h"
#include "rt/cycle/held_tool.h"
#include "rt/cycle/mount.h"
#include "rt/cycle/session_share.h"
#include "rt/cycle/velocity_estimator.h"
#include "rt/effect/object_effects.h"
#include "rt/finger/soft_finger.h"
#include "rt/guard/guard.h"
#include "rt/render/proxy/proxy.h"
#include "rt/render/surface/shading.h"
#include "rt/render/surface/surface_effects.h"
#include "rt/scene/scene.h"

namespace hapticd {

struct CycleConfig {
  std::int64_t period_ns = 1'000'000;
  std::uint32_t device_count = 1;
  std::array<GuardConfig, kMaxDevices> guard;
  std::int64_t loss_fade_ns = 50'000'000;  ///< A lost session's share is gone after this.
};

/** What one device's tick came to. Its command, the guard's output and the intent are in the device's frame. */
struct DeviceOutput {
  DeviceCommand command;
  SurfaceContact contact;  ///< In the world.
  GuardOutput guard;
  Pose pose;       ///< Of the device point, in the world.
  Twist velocity;  ///< Of it, in the world.
  DeviceIntent intent;
  bool has_intent = false;
};

struct CycleOutput {
  std::array<DeviceOutput, kMaxDevices> device;
  EventBatch events;
  std::uint32_t applied_commands = 0;
};

/** State of one device group. Allocates when constructed and never again. */
class Cycle {
 public:
  Cycle(const CycleConfig& config, const MeshTable& meshes) noexcept;

  /** What the velocity estimator and friction may take for noise, of the device itself [m, rad]. Before the first step.
   */
  void setResolution(std::uint32_t device, double position, double rotation) HD_RT {
    devices_[device].velocity.setResolution(position, rotation);
    devices_[device].guard.setResolution(position);
    devices_[device].read_resolution = position;
    scaleToWorld(devices_[device]);
  }

  void step(const CycleInput& input, CycleOutput& output) HD_RT;

  /** One stage each, so that the servo can time them; step() is the three in a row. */
  void applyCommands(const CycleInput& input, CycleOutput& output) HD_RT;
  void render(const CycleInput& input, CycleOutput& output) HD_RT;
  void guard(const CycleInput& input, CycleOutput& output) HD_RT;

  [[nodiscard]] const Scene& scene() const HD_RT { return scene_; }
  [[nodiscard]] const SessionShare& session(std::uint32_t slot) const HD_RT { return sessions_[slot]; }
  [[nodiscard]] const Guard& deviceGuard(std::uint32_t device) const HD_RT { return devices_[device].guard; }
  /** Where it stands in the world. */
  [[nodiscard]] const Mount& mount(std::uint32_t device) const HD_RT { return devices_[device].mount; }
  /** Whether a hand is off its point in the world. */
  [[nodiscard]] const Clutch& clutch(std::uint32_t device) const HD_RT { return devices_[device].clutch; }
  /** Radius of the ball about the device point, as ordered [m]. */
  [[nodiscard]] double deviceRadius(std::uint32_t device) const HD_RT { return devices_[device].proxy.radius(); }
  /** Of what touches at its point. */
  [[nodiscard]] const SoftFinger& finger(std::uint32_t device) const HD_RT { return devices_[device].finger; }
  /** The tool in its hand; held() may be false. */
  [[nodiscard]] const HeldTool& tool(std::uint32_t device) const HD_RT { return devices_[device].tool; }
  /** The spring on its gripper's axis, as ordered. */
  [[nodiscard]] const SetGrip& grip(std::uint32_t device) const HD_RT { return devices_[device].grip; }
  [[nodiscard]] const FreeBodies& bodies() const HD_RT { return bodies_; }
  /** Asks where held tools and free bodies touch. False, and nothing asked, when there are none. */
  [[nodiscard]] bool ask(CollideRequest& request) const HD_RT;
  [[nodiscard]] const CycleConfig& config() const HD_RT { return config_; }
  /** Tells on where `former` ended: nothing twice, and of what it told the end. No force depends on it. */
  void tellOn(const Cycle& former) noexcept;
  /** What made it were orders, and no edits of clients. */
  void forgetEdits() HD_RT { scene_.forgetEdits(); }
  /** Commands that wait for their tick, in the order they arrived. */
  [[nodiscard]] std::span<const Command> pending() const HD_RT { return {pending_.data(), pending_count_}; }

 private:
  /** An object that held a hand, as it was then. */
  struct PressedObject {
    std::uint32_t object = 0;
    std::uint32_t surface = 0;  ///< Surface::changes.
    std::uint64_t shape = 0;    ///< Shape::number.
    double stiffness = 0;       ///< [N/m]
  };
  /** What one that holds a hand got from it in a tick. */
  struct Given {
    std::uint32_t object = 0;  ///< Id.
    std::uint8_t body = FreeBodies::kNone;
    Vec3 at = Vec3::Zero();        ///< Where in W; of a body, from its center of mass [m].
    Vec3 impulse = Vec3::Zero();   ///< In W [N s].
    Vec3 velocity = Vec3::Zero();  ///< Of the body there, before, in W [m/s].
  };
  /** What the springs that hold a hand may give to free bodies, and what they gave in the last tick. */
  struct Lending {
    double energy = 0;         ///< [J]
    Vec3 felt = Vec3::Zero();  ///< By the hand [N],
    Vec3 hand = Vec3::Zero();  ///< and where the point was, in W [m].
    bool bound = false;        ///< There was a narrow wedge, and not all is paid for yet.
    std::uint32_t count = 0;
    std::array<Given, kMaxHolding> given;

    /** Nothing that is free is held. */
    void begin(double stored, const Vec3& force) HD_RT {
      energy = stored;
      felt = force;
      bound = false;
      count = 0;
    }
  };
  struct DeviceState {
    DeviceState(const GuardConfig& config, std::uint32_t device) noexcept
        : guard(config), max_damping(config.max_damping), effects(device) {}
    Guard guard;
    double max_damping;  ///< What the device can show [N s/m].
    ProxyRenderer proxy;
    Shading shading;
    SoftFinger finger;
    SurfaceEffects effects;
    ObjectEffects object_effects;
    VelocityEstimator velocity;
    HeldTool tool;
    Mount mount;
    Clutch clutch;
    bool moved = false;        ///< The clutch has moved the mount, and that is not told yet.
    Vec3 rest = Vec3::Zero();  ///< Where the point is held in the last tick, or was: what a clutch leaves it at.
    DeviceSample placed;       ///< The reading brought into the world, where asRead() says that it is another.
    Twist velocity_D;          ///< As estimated, in the device's frame.
    SetGrip grip{};
    double read_resolution = 0;  ///< Of the reading's place [m],
    double resolution = 0;       ///< and of where that is in the world.
    bool started = false;
    std::uint32_t buttons = 0;
    std::array<std::uint32_t, kMaxHolding> touched{};  ///< Objects whose touch was told, named when it ends.
    std::array<PressedObject, kMaxHolding> pressed{};  ///< Objects of the last tick's contact,
    double pressed_stored = 0;                         ///< and what their springs held [J].
    Lending lending;
    std::uint32_t last_fault = HD_FAULT_NONE;
    bool last_armed = false;
    bool last_warm = false;
  };
  /** What the guard must know of the sources beside their force (GuardInput). */
  struct Energy {
    Vec3 local_active = Vec3::Zero();
    Vec3 relief = Vec3::Zero();
    Vec3 carried = Vec3::Zero();
    double stored = 0;
    double damping = 0;
    double gripper = 0;  ///< Force wanted on its axis [N].
  };
  static constexpr std::uint32_t kMaxPending = 128;

  [[nodiscard]] double period() const HD_RT { return 1e-9 * static_cast<double>(config_.period_ns); }  ///< [s]

  void apply(const Command& command, const CycleInput& input, CycleOutput& output) HD_RT;
  ErrorCode applyToSession(const Command& command, const CycleInput& input) HD_RT;
  ErrorCode applySessionOrder(const Command& command, const CycleInput& input) HD_RT;
  ErrorCode applyDeviceOrder(const Command& command) HD_RT;
  ErrorCode applyToHand(HeldTool& tool, const Command& command) HD_RT;
  [[nodiscard]] bool isHeld(std::uint32_t object) const HD_RT;
  void stand(std::uint32_t object) HD_RT;
  ErrorCode applyMount(const SetMount& order) HD_RT;
  void scaleToWorld(DeviceState& device) HD_RT;
  void refuse(const Command& command, ErrorCode code, const CycleInput& input, CycleOutput& output) HD_RT;
  ErrorCode applyToBodies(const Command& command) HD_RT;
  [[nodiscard]] std::uint32_t heldObjects(std::array<std::uint32_t, kMaxDevices>& held) const HD_RT;
  void moveTools(const CycleInput& input, CycleOutput& output) HD_RT;
  void pushBodies(DeviceState& device, const Vec3& hand, const SurfaceContact& contact, const Vec3& felt,
                  const Vec3& turning, double weight) HD_RT;
  [[nodiscard]] static bool isNarrow(const SurfaceContact& contact) HD_RT;
  [[nodiscard]] double lent(const Lending& last) const HD_RT;
  FingerForces touchSoftly(std::uint32_t d, DeviceOutput& out) HD_RT;
  double changed(DeviceState& device, const SurfaceContact& contact, double stored) const HD_RT;
  /** The point is where the reading says. */
  [[nodiscard]] static bool asRead(const DeviceState& device) HD_RT {
    return device.mount.identity() && !device.clutch.frozen();
  }
  void moveClutch(std::uint32_t d, const CycleInput& input) HD_RT;
  void weighClutch(std::uint32_t d, const SurfaceContact& contact, const Vec3& point) HD_RT;
  [[nodiscard]] const DeviceSample& place(std::uint32_t d, const CycleInput& input) HD_RT;
  void renderDevice(std::uint32_t d, const CycleInput& input, DeviceOutput& out) HD_RT;
  void renderTool(std::uint32_t d, const DeviceSample& sample, DeviceOutput& out) HD_RT;
  void bringToDevice(std::uint32_t d, const DeviceOutput& out) HD_RT;
  void noteExpiredModels(const CycleInput& input, CycleOutput& output) HD_RT;
  void raiseTouches(std::uint32_t d, const CycleInput& input, CycleOutput& output) HD_RT;
  void raiseEvents(std::uint32_t d, const CycleInput& input, CycleOutput& output) HD_RT;

  CycleConfig config_;
  Scene scene_;
  std::array<SessionShare, kMaxSessions> sessions_;
  FreeBodies bodies_;
  std::array<DeviceState, kMaxDevices> devices_;
  std::array<Command, kMaxPending> pending_;  ///< Commands whose tick has not come.
  std::uint32_t pending_count_ = 0;
  std::uint64_t last_tick_ = 0;  ///< 0: there was none.
  double periods_ = 1;           ///< Since the tick before.
  std::array<std::array<Wrench, HD_SOURCES>, kMaxDevices>
      sources_;  ///< In the device's frame once rendered; so energy_.
  std::array<Energy, kMaxDevices> energy_;
};

}  // namespace hapticd
