/** @file
 * One change to the cycle's state, as it enters through CycleInput: a client's message that ingest has checked, or an
 * order of the control thread. Plain data, so that a recording can hold it.
 */
#pragma once

#include <cstdint>
#include <type_traits>

#include "proto/shm_layout.h"
#include "proto/snapshot.h"
#include "rt/base/contract.h"

namespace hapticd {

inline constexpr std::uint32_t kMaxSessions = 16;  ///< Of one device group.
inline constexpr std::uint32_t kMaxObjects = 256;  ///< Slots of the scene, slot 0 is the root.
inline constexpr std::uint32_t kMaxMeshes = 256;   ///< Entries of the mesh table.
inline constexpr std::uint32_t kMaxTextures = 64;  ///< Entries of the texture table.
inline constexpr std::uint32_t kMaxDevices = HD_MAX_DEVICES;
inline constexpr std::uint32_t kMaxBodies = 8;            ///< Objects that move freely.
inline constexpr std::uint32_t kMaxEffects = 16;          ///< Objects with an effect.
inline constexpr std::uint32_t kMaxPathPoints = 32;       ///< Of one effect's path.
inline constexpr std::uint32_t kControlSession = 0xffff;  ///< Command::session of the control thread.
/** Of what the cycle moves itself: control and the other groups are told of it as of a client's. */
inline constexpr std::uint32_t kCycleSession = 0xfffe;

/** Kinds of command. Those below 64 are the client's (hd_command_kind) with the same payload. */
enum class CommandKind : std::uint32_t {
  kNone = HD_COMMAND_NONE,
  kObjectPose = HD_COMMAND_OBJECT_POSE,
  kObjectMaterial = HD_COMMAND_OBJECT_MATERIAL,
  kObjectFlags = HD_COMMAND_OBJECT_FLAGS,
  kObjectVertices = HD_COMMAND_OBJECT_VERTICES,
  kLocalModel = HD_COMMAND_LOCAL_MODEL,
  kForceField = HD_COMMAND_FORCE_FIELD,
  kClearModel = HD_COMMAND_CLEAR_MODEL,
  kClientForce = HD_COMMAND_CLIENT_FORCE,
  kIntent = HD_COMMAND_INTENT,
  kLimits = HD_COMMAND_LIMITS,

  kAddObject = 64,  ///< AddObject
  kRemoveObject,    ///< ObjectRef; children were removed before.
  kSetShape,        ///< SetShape
  kAddSession,      ///< SessionRef: the slot starts alive and empty.
  kLoseSession,     ///< SessionRef: client gone or stuck; its share fades.
  kReviveSession,   ///< SessionRef: heartbeat is back before the slot was freed.
  kFreeSession,     ///< SessionRef: the slot may be used again.
  kArm,             ///< DeviceRef
  kDisarm,          ///< DeviceRef
  kStop,            ///< StopOrder
  kDeviceLimits,    ///< DeviceLimits
  kDeviceRadius,    ///< DeviceRadius
  kSetSurface,      ///< SetSurface
  kAttachTool,      ///< AttachTool: the device holds an object.
  kDetachTool,      ///< DeviceRef
  kToolContacts,    ///< ToolContacts: the collide thread's answer.
  kSetBody,         ///< SetBody: an object moves freely, or no longer.
  kSetGravity,      ///< SetGravity
  kSetGrip,         ///< SetGrip: what the device's gripper closes on.
  kSetEffect,       ///< SetEffect
  kSetMount,        ///< SetMount: where the device stands, and how large. Refused while it is armed.
  kSetFinger,       ///< SetFinger: what touches is a fingertip.
  kSetClutch,       ///< SetClutch
};

/** An object id for the rings: slot in the low 16 bits, generation above, never 0. */
[[nodiscard]] constexpr std::uint32_t objectSlot(std::uint32_t id) { return id & 0xffffu; }
[[nodiscard]] constexpr std::uint32_t makeObjectId(std::uint32_t slot, std::uint32_t generation) {
  return slot | (generation << 16);
}

struct ShapeParameters {
  std::uint32_t kind;  ///< ShapeKind
  std::uint32_t mesh;  ///< Entry of the mesh table, for meshes.
  double size[3];
};

/** Beside hd_object_flag, by control alone (ingest refuses it): it is in the hand of a device, of whichever servo. */
inline constexpr std::uint32_t kObjectInHand = 1u << 31;

struct AddObject {
  std::uint32_t object;
  std::uint32_t parent;  ///< Object id, 0 for the root.
  std::uint32_t flags;   ///< hd_object_flag, kObjectInHand
  std::uint32_t reserved;
  ShapeParameters shape;
  hd_material material;
  double p[3];
  double q[4];
};

struct ObjectRef {
  std::uint32_t object;
};
struct SetShape {
  std::uint32_t object;
  std::uint32_t reserved;
  ShapeParameters shape;
};
/** What a surface does beyond its material (docs/surfaces.md); all zero: nothing. Checked and made by the daemon. */
struct SurfaceParameters {
  double smooth_cosine;    ///< Edges whose normals differ by less than this angle are shaded round; 0: none is.
  double transient_gain;   ///< Force per speed of impact [N s/m].
  double transient_first;  ///< r sin(theta): what follows an impact is r^n sin(n theta) at the ticks n = 1, 2, ...
  double transient_turn;   ///< 2 r cos(theta)
  double transient_decay;  ///< r^2, below 1.
  double relief_depth;     ///< From white down to black [m].
  double relief_size[2];   ///< Of the picture [m].
  double vibration_mass;   ///< Force per acceleration [kg].
  std::uint32_t relief;    ///< Entry of the texture table plus 1, 0 for none.
  std::uint32_t vibration;
};

struct SetSurface {
  std::uint32_t object;
  std::uint32_t reserved;
  SurfaceParameters surface;
};

enum class EffectKind : std::uint32_t { kNone = 0, kForce, kViscous, kFriction, kVibration, kGuide };

/** What an object does to a hand that does not touch it (docs/effects.md). Checked by the daemon. */
struct EffectParameters {
  std::uint32_t kind;             ///< EffectKind
  std::uint32_t points;           ///< Of `path`; 0: it has none.
  double force;                   ///< The most it pushes [N].
  double stiffness;               ///< Of a guide, and of friction that sticks [N/m].
  double damping;                 ///< Of viscous, and of a guide across its way [N s/m].
  double reach;                   ///< Beyond this distance there is nothing [m].
  double frequency;               ///< Of a vibration [Hz].
  std::int64_t until_ns;          ///< When it ends, on the servo's clock; 0: never.
  float path[kMaxPathPoints][3];  ///< A smooth curve goes through these, in the object's frame [m].
};

struct SetEffect {
  std::uint32_t object;
  std::uint32_t reserved;
  EffectParameters effect;
};
struct SessionRef {
  std::uint32_t slot;
  std::uint32_t reserved;
  std::uint64_t id;
};
struct DeviceRef {
  std::uint32_t device;
};
struct StopOrder {
  std::uint32_t device;
  std::uint32_t cause;  ///< hd_fault to latch; 0: HD_FAULT_STOP_LINE.
};
struct DeviceLimits {
  std::uint32_t device;
  std::uint32_t only_lowers;  ///< Not 0: each limit becomes the lower of this and what is in force.
  double force, torque, force_slew, torque_slew, velocity, power, active_power, gripper_force;
};

/** Of the ball about the device point. */
struct DeviceRadius {
  std::uint32_t device;
  std::uint32_t reserved;
  double radius;  ///< 0 to ProxyRenderer::kMaxRadius [m].
};

/** Where a device stands in the world, and how large: x_W = scale q x_D + p. */
struct SetMount {
  std::uint32_t device;
  std::uint32_t keeps_place;  ///< 1: the scale alone is meant.
  double p[3];                ///< [m]
  double q[4];                ///< w x y z
  double scale;               ///< 0: 1, as in recordings that knew none.
};

/** Whether a hand is taken off its point in the world (rt/cycle/clutch.h). */
struct SetClutch {
  std::uint32_t device;
  std::uint32_t held;    ///< Not 0: by this order, until another.
  std::uint32_t button;  ///< Held, too, as long as this one is pressed: 1 is the first, 0 none.
  std::uint32_t frozen;  ///< Not 0: its point stands still at `anchor` already, where a recording begins.
  double anchor[3];      ///< In the world [m].
};

/** An object becomes the tool in a device's hand: its frame goes to the device's, by a coupling (rt/body/coupling.h).
 */
struct AttachTool {
  std::uint32_t device;
  std::uint32_t object;              ///< Directly below the root.
  std::uint32_t shows_torque;        ///< The device can turn the hand.
  std::uint32_t flags;               ///< ToolFlag
  double mass;                       ///< [kg]
  double com[3];                     ///< In the object's frame [m].
  double inertia[6];                 ///< About com: xx yy zz xy xz yz [kg m^2].
  double outer, stiffness, damping;  ///< CouplingGains.
  double angular_outer, angular_stiffness, angular_damping;
};

/** Bits of AttachTool::flags. */
enum ToolFlag : std::uint32_t {
  kToolWeighs = 1u << 0,  ///< The hand carries it; else its weight is taken off.
  kToolDirect = 1u << 1,  ///< No coupling: the tool is where the device is, and overlap pushes (rt/body/direct.h).
};

/** Where a tool or a free body touches, as of some ticks ago. What ContactModel holds. */
struct ToolContacts {
  static constexpr std::uint32_t kMost = 14;
  struct Point {
    float p_A[3], n_B[3], offset;
    std::uint32_t key;
  };
  std::uint32_t device;  ///< From kMaxDevices on: the free body of that number.
  std::uint32_t object;  ///< The tool or body; contacts of another are ignored.
  std::uint32_t count;
  std::uint32_t dropped;  ///< Points of the tool's surface that the budget left out.
  Point point[kMost];
  std::uint64_t tick;  ///< Of the servo, in which that was asked: CollideRequest::tick.
};

/** An object that moves freely and is pushed by tools. It stands directly below the root. */
struct SetBody {
  std::uint32_t object;
  std::uint32_t falls;  ///< 1: the scene's gravity acts on it.
  double mass;          ///< [kg]; 0: it stays where it is put, as if it had never moved.
  double com[3];        ///< In the object's frame [m].
  double inertia[6];    ///< About com: xx yy zz xy xz yz [kg m^2].
  double damping;       ///< Share of its motion that is lost [1/s].
};

struct SetGravity {
  double g[3];  ///< [m/s^2]
};

/** A spring on the gripper's axis: closed further than `width` it pushes open. */
struct SetGrip {
  std::uint32_t device;
  std::uint32_t reserved;
  double stiffness;  ///< [N/rad]; 0: none.
  double width;      ///< [rad]
};

/** What touches is a fingertip that resists being turned (rt/finger/soft_finger.h), or a point. */
struct SetFinger {
  std::uint32_t device;
  std::uint32_t law;           ///< PadLaw; kNone: a point.
  std::uint32_t flags;         ///< FingerFlag
  std::uint32_t shows_moment;  ///< The device can turn the hand.
  double radius;               ///< Of the pad [m].
  double arm;                  ///< Of PadLaw::kLinear [m].
  double stiffness;            ///< Of the twist [N m/rad].
  double damping;              ///< Of the pad, across the normal, where it holds a free body [N s/m].
  double cue;                  ///< Amplitude of the vibration that tells of slip, per speed [N s/m].
};

/** Bits of SetFinger::flags. */
enum FingerFlag : std::uint32_t {
  kFingerUncoupled = 1u << 0,  ///< Sliding and turning do not share friction (thesis 2.3.1; else 2.3.3).
};

/** A checked command. `payload` is read with as<T>() according to `kind`. */
struct Command {
  CommandKind kind = CommandKind::kNone;
  std::uint32_t session = kControlSession;  ///< Slot of the sender.
  std::uint64_t seq = 0;                    ///< Sender's number, for the acknowledgement.
  std::uint64_t at_tick = 0;                ///< Takes effect at this tick; 0: at once.
  /** Where it came from: 0 the ring, k + 1 mailbox k. Each counts its own seq; applied_seq speaks of the ring's. */
  std::uint32_t channel = 0;
  std::uint32_t reserved = 0;
  alignas(8) unsigned char payload[HD_SLOT_BYTES - 32] = {};

  template <class T>
  [[nodiscard]] const T& as() const noexcept {
    static_assert(std::is_trivially_copyable_v<T> && sizeof(T) <= sizeof payload && alignof(T) <= 8);
    return *reinterpret_cast<const T*>(payload);
  }
  template <class T>
  [[nodiscard]] T& as() noexcept {
    static_assert(std::is_trivially_copyable_v<T> && sizeof(T) <= sizeof payload && alignof(T) <= 8);
    return *reinterpret_cast<T*>(payload);
  }
};
static_assert(std::is_trivially_copyable_v<Command>);

/** Of the control thread, or of that session. */
template <class T>
[[nodiscard]] Command makeCommand(CommandKind kind, const T& payload, std::uint32_t session = kControlSession) HD_RT {
  Command command;
  command.kind = kind;
  command.session = session;
  command.as<T>() = payload;
  return command;
}

}  // namespace hapticd
