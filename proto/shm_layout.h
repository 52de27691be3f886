/** @file
 * What crosses between a client and the real-time threads: the layout of a session's two shared mappings.
 *
 * Region A is written by the daemon and mapped read-only by the client: acknowledgements, statistics, the latest state
 * of each device and a history ring in which every servo sample stands. Region B is written by the client: a command
 * ring and latest-value mailboxes. Plain C, no pointers, no locks; every shared counter is a naturally aligned integer
 * that each side loads and stores atomically. docs/protocol.md tells the handshake and who trusts what.
 *
 * SI units, world frame W: right-handed, x toward the operator, y to the operator's right, z up. Quaternions are
 * w, x, y, z. Times are CLOCK_MONOTONIC nanoseconds. All reserved fields are zero.
 */
#ifndef HAPTICD_PROTO_SHM_LAYOUT_H
#define HAPTICD_PROTO_SHM_LAYOUT_H

#include <stddef.h>
#include <stdint.h>

#define HD_SHM_MAGIC UINT64_C(0x3144434954504148) /**< "HAPTICD1" in memory on a little-endian machine. */

/** A change of major breaks clients; a change of minor only adds (readers require minor >= theirs). */
#define HD_SHM_MAJOR 2
#define HD_SHM_MINOR 1 /**< 1: hd_object_pose::lease_us. */

#define HD_LINE 128u           /**< Producer and consumer fields stand this far apart: two 64-byte lines. */
#define HD_SLOT_BYTES 512u     /**< One command slot or mailbox. */
#define HD_RING_SLOTS 256u     /**< Slots of the command ring, a power of two. */
#define HD_MAILBOXES 16u       /**< Latest-value channels. */
#define HD_HISTORY_SLOTS 1024u /**< Samples in the history ring, a power of two. */
#define HD_MAX_DEVICES 4u      /**< Devices of one group (one servo). */
#define HD_MODEL_SLOTS 8u      /**< Local models of one session. */
#define HD_HALFSPACES 16u      /**< Half-spaces of one convex patch. */
#define HD_VERTEX_MOVES 26u    /**< Vertices one slot can move. */

/** Where a newton comes from. The daemon publishes the applied force split by these. */
enum hd_source {
  HD_SOURCE_SURFACE = 0,     /**< Contact with the scene. */
  HD_SOURCE_EFFECT = 1,      /**< Fields and guides of objects in free space. */
  HD_SOURCE_LOCAL_MODEL = 2, /**< Models that clients push. */
  HD_SOURCE_CLIENT = 3,      /**< Force computed by a client. */
  HD_SOURCE_GRAVITY = 4,     /**< Gravity compensation of the device. */
  HD_SOURCE_TEXTURE = 5,     /**< Relief and vibration of the surface touched. */
  HD_SOURCE_TRANSIENT = 6,   /**< Pulses of impacts. */
  HD_SOURCE_GUARD = 7,       /**< What the guard added or took away: applied minus the sum of the others. */
  HD_SOURCES = 8
};

/** Bits of hd_sample.flags. */
enum hd_sample_flag {
  HD_SAMPLE_ARMED = 1u << 0,     /**< Forces reach the device. */
  HD_SAMPLE_RAMPING = 1u << 1,   /**< The arming ramp is below one; also while it waits. */
  HD_SAMPLE_FAULT = 1u << 2,     /**< A fault is latched; see hd_sample.fault. */
  HD_SAMPLE_CONTACT = 1u << 3,   /**< The proxy touches a surface. */
  HD_SAMPLE_SLIP = 1u << 4,      /**< The contact slides (else it sticks). */
  HD_SAMPLE_LIMITED = 1u << 5,   /**< A limit reduced the force. */
  HD_SAMPLE_PASSIVITY = 1u << 6, /**< The passivity controller added damping. */
  HD_SAMPLE_STALE = 1u << 7,     /**< The device gave no new sample this tick. */
  HD_SAMPLE_NO_RT = 1u << 8,     /**< The servo runs without real-time scheduling. */
  HD_SAMPLE_SATURATED = 1u << 9, /**< The device's own limit cut the force. */
  HD_SAMPLE_WAITING = 1u << 10,  /**< Armed, but no force flows: the ramp waits until what is asked for is small. */
  HD_SAMPLE_CLUTCHED = 1u << 11  /**< The hand moves free of its point in the world, which stands still. */
};

/** Why the guard latched. One cause at a time: the first. */
enum hd_fault {
  HD_FAULT_NONE = 0,
  HD_FAULT_STOP_LINE = 1,    /**< Emergency stop. */
  HD_FAULT_NOT_FINITE = 2,   /**< A source or the device gave NaN or infinity. */
  HD_FAULT_VELOCITY = 3,     /**< The hand moved faster than the limit. */
  HD_FAULT_DEVICE_LOST = 4,  /**< Samples stopped coming. */
  HD_FAULT_DEVICE_ERROR = 5, /**< The driver reports an error. */
  HD_FAULT_DEADMAN = 6,      /**< The dead-man switch opened. */
  HD_FAULT_OVERRUN = 7,      /**< The servo missed too many periods in a row. */
  HD_FAULT_ENERGY = 8,       /**< The passivity observer could not be satisfied. */
  HD_FAULT_COUNT = 9
};

/** Start of both regions. `ready` is written last (release) and read first (acquire). */
struct hd_shm_header {
  uint64_t magic;
  uint16_t major;
  uint16_t minor;
  uint32_t header_bytes;
  uint64_t region_bytes;
  uint64_t daemon_epoch; /**< Drawn at daemon start; a client that sees another one opens a new session. */
  uint64_t session_id;
  uint32_t slot_bytes;
  uint32_t ring_slots;
  uint32_t mailboxes;
  uint32_t history_slots;
  uint32_t sample_bytes;
  uint32_t device_count;
  int64_t period_ns; /**< Servo period of the device group. */
  uint32_t region;   /**< 'A' or 'B'. */
  uint32_t ready;    /**< 1 once all the rest is in place. */
  uint8_t reserved[HD_LINE - 80];
};

/** One servo sample of one device. Vectors in W. */
struct hd_sample {
  uint64_t guard; /**< Seqlock: 2 n + 1 while sample n is written, 2 n + 2 when it stands. */
  uint64_t tick;
  int64_t t_ns; /**< When the servo woke for this tick. */
  uint32_t device;
  uint32_t flags; /**< hd_sample_flag */
  uint32_t fault; /**< hd_fault */
  uint32_t buttons;
  double p[3];                    /**< Device point (HIP) [m]. */
  double q[4];                    /**< Orientation, w x y z. */
  double v[3];                    /**< Velocity, filtered as the cycle uses it [m/s]. */
  double w[3];                    /**< Angular velocity [rad/s]. */
  double proxy[3];                /**< Proxy [m]; equals p in free space. */
  double force[3];                /**< Force sent to the device [N]. */
  double torque[3];               /**< Torque sent to the device [N m]. */
  float by_source[HD_SOURCES][3]; /**< The force split by owner [N]; sums to `force`. */
  double gripper_rad;
  double gripper_force_n;
  float own[3];              /**< This session's share of `force` before the common limits [N]. */
  float energy_j;            /**< What the passivity observer holds; negative means active. */
  float depth_m;             /**< Penetration of the HIP below the surface, 0 in free space. */
  uint32_t contact_object;   /**< Object in contact, 0 for none. */
  uint32_t missed;           /**< Periods missed since start. */
  uint32_t wake_ns;          /**< Wake-up latency of this tick: of the first period, where some were missed. */
  uint32_t cycle_ns;         /**< Duration of the previous tick's whole cycle. */
  uint32_t applied_commands; /**< Commands taken by this tick, all sessions together. */
  uint8_t reserved[16];
};

/**
 * What became of a session's commands. Each field has one writer, named in parentheses, and is written alone: two
 * fields read together may be of different moments. But applied_seq and rejected are stored last, with release: who
 * loads one with acquire finds what belongs to it, or newer.
 */
struct hd_acks {
  uint32_t ring_head;    /**< Slots consumed (ingest). */
  uint32_t violations;   /**< Protocol violations (ingest); the first one ends the session. */
  uint64_t received_seq; /**< Sequence number of the last slot taken (ingest). */
  uint64_t rejected;     /**< Slots and mailbox messages refused since start (ingest). */
  uint64_t last_rejected_seq;
  uint32_t last_rejected_code;    /**< An error number of errors.h. */
  uint32_t stale_mailboxes;       /**< Mailbox reads given up after two tries (ingest). */
  uint64_t applied_seq;           /**< Last command of the ring that was seen to: in force, or refused (servo). */
  uint64_t applied_tick;          /**< Tick at which it was (servo). */
  int64_t heartbeat_age_ns;       /**< Age of the client's heartbeat (ingest). */
  float fade;                     /**< The session's share factor: 1 alive, falling to 0 when lost (servo). */
  uint32_t ended;                 /**< 1 when the daemon has closed this session (control). */
  uint32_t last_rejected_channel; /**< Whose numbers last_rejected_seq is of: 0 the ring, k + 1 mailbox k (ingest). */
  uint32_t reserved0;
  uint8_t reserved[HD_LINE - 80];
};

/** Life of one local model slot, as the servo sees it. */
struct hd_model_status {
  uint64_t seq;   /**< Command that set it, 0 if empty. */
  int64_t age_ns; /**< Since it was applied. */
  float weight;   /**< 1 in force, falling while it fades. */
  uint32_t state; /**< 0 empty, 1 blending in, 2 in force, 3 expired and fading. */
  uint64_t reserved;
};

/** Counters of the device group's servo. */
struct hd_counters {
  uint64_t cycles;
  uint64_t missed;   /**< Periods skipped after overruns. */
  uint64_t overruns; /**< Events of lateness (each may skip several periods). */
  uint64_t stale_samples;
  uint64_t contacts; /**< Touch events. */
  uint64_t faults;
  uint32_t max_wake_ns;
  uint32_t max_cycle_ns;
  uint8_t reserved[HD_LINE - 56];
};

/** Region A: the client maps it read-only. */
struct hd_region_a {
  struct hd_shm_header header;
  struct hd_acks acks;
  struct hd_counters counters;
  struct hd_model_status models[HD_MODEL_SLOTS];
  uint64_t history_tail; /**< Samples written; sample n stands in slot n mod history_slots. */
  uint8_t reserved[HD_LINE - 8];
  struct hd_sample latest[HD_MAX_DEVICES];
  struct hd_sample history[HD_HISTORY_SLOTS];
};

/** What a slot or mailbox holds. */
enum hd_command_kind {
  HD_COMMAND_NONE = 0,
  HD_COMMAND_OBJECT_POSE = 1,
  HD_COMMAND_OBJECT_MATERIAL = 2,
  HD_COMMAND_OBJECT_FLAGS = 3,
  HD_COMMAND_OBJECT_VERTICES = 4,
  HD_COMMAND_LOCAL_MODEL = 5,
  HD_COMMAND_FORCE_FIELD = 6,
  HD_COMMAND_CLEAR_MODEL = 7,
  HD_COMMAND_CLIENT_FORCE = 8,
  HD_COMMAND_INTENT = 9,
  HD_COMMAND_LIMITS = 10,
  HD_COMMAND_KINDS = 11
};

/** Pose and velocity of an object in its parent's frame. The servo moves it on by the velocity between updates. */
struct hd_object_pose {
  uint32_t object;
  uint32_t lease_us; /**< The velocity lasts so long, 0: as long as the session; then the object stands. */
  double p[3];
  double q[4];
  double v[3]; /**< [m/s] */
  double w[3]; /**< [rad/s] */
};

struct hd_material {
  double stiffness;        /**< [N/m] */
  double damping;          /**< [N s/m], while in contact */
  double friction_static;  /**< mu_s */
  double friction_dynamic; /**< mu_d <= mu_s */
};

struct hd_object_material {
  uint32_t object;
  uint32_t reserved;
  struct hd_material material;
};

/** Bits of hd_object_flags. */
enum hd_object_flag {
  HD_OBJECT_ENABLED = 1u << 0,  /**< It can be touched. */
  HD_OBJECT_VISIBLE = 1u << 1,  /**< For viewers; the servo ignores it. */
  HD_OBJECT_TWO_SIDED = 1u << 2 /**< Both faces of an open mesh stop the proxy. */
};

struct hd_object_flags {
  uint32_t object;
  uint32_t mask;  /**< Bits to change. */
  uint32_t value; /**< Their new values. */
  uint32_t reserved;
};

struct hd_vertex_move {
  uint32_t index;
  float p[3]; /**< New place in the object's frame [m]. */
};

/** Moves vertices of a mesh that was created deformable. */
struct hd_object_vertices {
  uint32_t object;
  uint32_t count;
  struct hd_vertex_move move[HD_VERTEX_MOVES];
};

enum hd_model_kind {
  HD_MODEL_PLANE = 1,      /**< Half-space behind n.x = n.origin (plane and probe). */
  HD_MODEL_SPRING = 2,     /**< Spring from the device point to `origin`. */
  HD_MODEL_SPHERE = 3,     /**< Sphere of `radius` about `origin`; negative radius: the hand is kept inside. */
  HD_MODEL_HALFSPACES = 4, /**< Convex solid: where all of up to 16 half-spaces overlap (a bump, an outer edge). */
  HD_MODEL_CORNER = 5 /**< Solid where any of them is: the hand stays outside all (inner edge, god-object planes). */
};

/** A local model: geometry near the tool, rendered by the servo at full rate until its lease runs out. */
struct hd_local_model {
  uint32_t slot;    /**< 0 to HD_MODEL_SLOTS - 1. */
  uint32_t kind;    /**< hd_model_kind */
  uint32_t frame;   /**< 0: world; else an object id: the model moves along with it. */
  uint32_t device;  /**< Device of the group. */
  int64_t lease_ns; /**< In force this long after it was applied, then fades. */
  int64_t blend_ns; /**< Time over which it replaces the former model of the slot. */
  struct hd_material material;
  double origin[3];
  double normal[3]; /**< Unit, outward (plane). */
  double radius;    /**< Sphere: radius; spring: free length; convex solid: rounding of its edges, 0: 0.5 mm [m]. */
  uint32_t count;   /**< Half-spaces in use. */
  uint32_t reserved;
  float halfspace[HD_HALFSPACES]
                 [4]; /**< Unit outward normal n and offset d about `origin`: behind it n.(x-origin) <= d. */
};

/** Force f0 + J (x - x0) within `radius` of x0, fading to zero over the outer fifth. */
struct hd_force_field {
  uint32_t slot;
  uint32_t frame;
  uint32_t device;
  uint32_t reserved;
  int64_t lease_ns;
  int64_t blend_ns;
  double x0[3];
  double f0[3];
  double jacobian[9]; /**< Row-major dF/dx [N/m]. */
  double radius;      /**< [m] */
};

struct hd_clear_model {
  uint32_t slot;
  uint32_t reserved;
  int64_t blend_ns;
};

/** Force computed by the client, held until replaced or until the lease runs out. */
struct hd_client_force {
  uint32_t device;
  uint32_t reserved;
  int64_t lease_ns;
  double force[3];
  double torque[3];
};

/** Where the hand of a simulated device wants to be. */
struct hd_intent {
  uint32_t device;
  uint32_t reserved;
  double p[3];
  double q[4];
  double gripper_rad;
};

/** Binds the session's own share; can only lower what the daemon allows. */
struct hd_limits {
  double force_n;
  double torque_nm;
};

/** One slot of the ring, or one mailbox. A mailbox uses `guard` as its seqlock; the ring ignores it. */
struct hd_slot {
  uint32_t guard;
  uint32_t kind;   /**< hd_command_kind */
  uint32_t length; /**< Bytes of payload in use. */
  uint32_t reserved;
  uint64_t seq;     /**< Strictly rising within the ring, and within each mailbox. */
  uint64_t at_tick; /**< Takes effect at this tick; 0 or the past: at once. */
  uint8_t payload[HD_SLOT_BYTES - 32];
};

/** Region B: the client writes it, the daemon trusts nothing in it. */
struct hd_region_b {
  struct hd_shm_header header;
  uint32_t tail; /**< Slots pushed, free-running. The client keeps its own copy and never reads this back. */
  uint8_t reserved0[HD_LINE - 4];
  int64_t heartbeat_ns; /**< The client's clock when it was last alive. */
  uint8_t reserved1[HD_LINE - 8];
  struct hd_slot ring[HD_RING_SLOTS];
  struct hd_slot mailbox[HD_MAILBOXES];
};

#ifdef __cplusplus
#define HD_LAYOUT_ASSERT static_assert
#else
#define HD_LAYOUT_ASSERT _Static_assert
#endif
HD_LAYOUT_ASSERT(sizeof(struct hd_shm_header) == HD_LINE, "header");
HD_LAYOUT_ASSERT(sizeof(struct hd_sample) == 3 * HD_LINE, "sample");
HD_LAYOUT_ASSERT(sizeof(struct hd_acks) == HD_LINE, "acks");
HD_LAYOUT_ASSERT(sizeof(struct hd_counters) == HD_LINE, "counters");
HD_LAYOUT_ASSERT(sizeof(struct hd_slot) == HD_SLOT_BYTES, "slot");
HD_LAYOUT_ASSERT(offsetof(struct hd_region_a, latest) == 6 * HD_LINE, "region A");
HD_LAYOUT_ASSERT(offsetof(struct hd_region_b, ring) == 3 * HD_LINE, "region B");
HD_LAYOUT_ASSERT(sizeof(struct hd_local_model) <= sizeof(((struct hd_slot*)0)->payload), "local model fits a slot");
HD_LAYOUT_ASSERT(sizeof(struct hd_object_vertices) <= sizeof(((struct hd_slot*)0)->payload), "vertices fit a slot");

#endif /* HAPTICD_PROTO_SHM_LAYOUT_H */
