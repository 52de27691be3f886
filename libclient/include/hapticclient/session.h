/** @file
 * A session with one device: reading what the servo does, and the right to energise the device.
 *
 * Functions marked servo-safe neither allocate, lock nor make a system call. Reading and pushing each belong to one
 * thread at a time per session (the same or two different ones); everything else blocks and may come from any thread.
 * haptic_session_reopen() and haptic_session_close() take the session for themselves: no other call may be running.
 */
#ifndef HAPTICCLIENT_SESSION_H
#define HAPTICCLIENT_SESSION_H

#include <hapticclient/client.h>
#include <hapticclient/device.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTIC_MODEL_SLOTS 8u /**< Local models of one session. */

/** Where a newton comes from. */
typedef enum haptic_source {
  HAPTIC_SOURCE_SURFACE = 0,     /**< Contact with the scene. */
  HAPTIC_SOURCE_EFFECT = 1,      /**< Fields and guides of objects in free space. */
  HAPTIC_SOURCE_LOCAL_MODEL = 2, /**< Models that clients push. */
  HAPTIC_SOURCE_CLIENT = 3,      /**< Force computed by a client. */
  HAPTIC_SOURCE_GRAVITY = 4,     /**< Gravity compensation of the device. */
  HAPTIC_SOURCE_TEXTURE = 5,     /**< Relief and vibration of the surface touched. */
  HAPTIC_SOURCE_TRANSIENT = 6,   /**< Pulses of impacts. */
  HAPTIC_SOURCE_GUARD = 7,       /**< What the guard added or took away. */
  HAPTIC_SOURCES = 8
} haptic_source;

/** Bits of haptic_sample.flags. */
typedef enum haptic_sample_flag {
  HAPTIC_SAMPLE_ARMED = 1 << 0,     /**< Forces reach the device. */
  HAPTIC_SAMPLE_RAMPING = 1 << 1,   /**< The arming ramp is below one; also while it waits. */
  HAPTIC_SAMPLE_FAULT = 1 << 2,     /**< A fault is latched; see haptic_sample.fault. */
  HAPTIC_SAMPLE_CONTACT = 1 << 3,   /**< The proxy touches a surface. */
  HAPTIC_SAMPLE_SLIP = 1 << 4,      /**< The contact slides (else it sticks). */
  HAPTIC_SAMPLE_LIMITED = 1 << 5,   /**< A limit reduced the force. */
  HAPTIC_SAMPLE_PASSIVITY = 1 << 6, /**< The passivity controller added damping. */
  HAPTIC_SAMPLE_STALE = 1 << 7,     /**< The device gave no new sample this tick. */
  HAPTIC_SAMPLE_NO_RT = 1 << 8,     /**< The servo runs without real-time scheduling. */
  HAPTIC_SAMPLE_SATURATED = 1 << 9, /**< The device's own limit cut the force. */
  HAPTIC_SAMPLE_WAITING = 1 << 10,  /**< Armed, but no force flows: the ramp waits until what is asked for is small. */
  HAPTIC_SAMPLE_CLUTCHED = 1 << 11  /**< The hand moves free of its point in the world, which stands still. */
} haptic_sample_flag;

/** Why the guard latched: the first cause. */
typedef enum haptic_fault {
  HAPTIC_FAULT_NONE = 0,
  HAPTIC_FAULT_STOP_LINE = 1,    /**< Emergency stop. */
  HAPTIC_FAULT_NOT_FINITE = 2,   /**< A source or the device gave NaN or infinity. */
  HAPTIC_FAULT_VELOCITY = 3,     /**< The hand moved faster than the limit. */
  HAPTIC_FAULT_DEVICE_LOST = 4,  /**< Samples stopped coming. */
  HAPTIC_FAULT_DEVICE_ERROR = 5, /**< The driver reports an error. */
  HAPTIC_FAULT_DEADMAN = 6,      /**< The dead-man switch opened. */
  HAPTIC_FAULT_OVERRUN = 7,      /**< The servo missed too many periods in a row. */
  HAPTIC_FAULT_ENERGY = 8,       /**< The passivity observer could not be satisfied. */
  HAPTIC_FAULT_COUNT = 9
} haptic_fault;

/** One servo sample of one device: 384 bytes. World frame, SI. */
typedef struct haptic_sample {
  uint64_t guard; /**< The library's own. */
  uint64_t tick;
  int64_t t_ns; /**< When the servo woke for this tick. */
  uint32_t device;
  uint32_t flags; /**< haptic_sample_flag */
  uint32_t fault; /**< haptic_fault */
  uint32_t buttons;
  double p[3];                        /**< Device point (HIP) [m]. */
  double q[4];                        /**< Orientation, w x y z. */
  double v[3];                        /**< Velocity, filtered [m/s]. */
  double w[3];                        /**< Angular velocity [rad/s]. */
  double proxy[3];                    /**< Proxy [m]; equals p in free space. */
  double force[3];                    /**< Force sent to the device [N]. */
  double torque[3];                   /**< Torque sent to the device [N m]. */
  float by_source[HAPTIC_SOURCES][3]; /**< The force split by owner [N]; sums to `force`. */
  double gripper_rad;
  double gripper_force_n;
  float own[3];              /**< This session's share before the common limits [N]. */
  float energy_j;            /**< What the passivity observer holds; negative means active. */
  float depth_m;             /**< Penetration of the device point below the surface. */
  uint32_t contact_object;   /**< Object in contact, 0 for none. */
  uint32_t missed;           /**< Periods missed since start. */
  uint32_t wake_ns;          /**< Wake-up latency of this tick: of the first period, where some were missed. */
  uint32_t cycle_ns;         /**< Duration of the previous tick's whole cycle. */
  uint32_t applied_commands; /**< Commands taken by this tick, all sessions together. */
  uint8_t reserved[16];
} haptic_sample;

/** What became of this session's commands. */
typedef struct haptic_acks {
  uint32_t ring_head;    /**< Slots consumed, free-running. */
  uint32_t violations;   /**< Protocol violations; the first one ends the session. */
  uint64_t received_seq; /**< Last command taken from the ring. */
  uint64_t rejected;     /**< Commands refused since the session began, but by the servo: HAPTIC_EVENT_REFUSED tells. */
  uint64_t last_rejected_seq;
  uint32_t last_rejected_code; /**< haptic_error_code */
  uint32_t stale_mailboxes;    /**< Latest-value reads given up after two tries. */
  /** Last command of the ring that the servo has seen to: in force, or refused. Falls after one with `at_tick`. */
  uint64_t applied_seq;
  uint64_t applied_tick; /**< Tick at which it did. */
  int64_t heartbeat_age_ns;
  float fade;     /**< Share factor: 1 alive, falling to 0 when lost. */
  uint32_t ended; /**< 1: the daemon has closed this session. */
} haptic_acks;

/** Life of one local model slot. */
typedef struct haptic_model_status {
  uint64_t seq;   /**< Command that set it, 0 if empty. */
  int64_t age_ns; /**< Since it was applied. */
  float weight;   /**< 1 in force, falling while it fades. */
  uint32_t state; /**< 0 empty, 1 blending in, 2 in force, 3 expired and fading. */
} haptic_model_status;

/** Counters of the servo since its start. */
typedef struct haptic_counters {
  uint64_t cycles;
  uint64_t missed;   /**< Periods skipped after overruns. */
  uint64_t overruns; /**< Events of lateness (each may skip several periods). */
  uint64_t stale_samples;
  uint64_t contacts; /**< Touch events. */
  uint64_t faults;
  uint32_t max_wake_ns;
  uint32_t max_cycle_ns;
} haptic_counters;

/** A session. */
typedef struct haptic_session haptic_session;

typedef struct haptic_session_options {
  uint32_t size;
  uint32_t flags;   /**< 0 */
  const char* uri;  /**< Device by URI, name or serial; null or "" as haptic_device_open() tells. */
  const char* name; /**< Null: the connection's name. */
} haptic_session_options;

#define HAPTIC_SESSION_OPTIONS_INIT \
  { sizeof(haptic_session_options), 0, NULL, NULL }

typedef struct haptic_session_info {
  uint32_t size;
  uint32_t device_index; /**< haptic_sample.device of the device that was asked for. */
  uint32_t device_count; /**< Devices that share the servo. */
  uint32_t reserved;
  uint64_t id;
  uint64_t epoch;
  int64_t period_ns; /**< Of the servo. */
  const haptic_device_info* device;
} haptic_session_info;

/** Opens the device if need be, maps the shared memory and starts heartbeats. `options` may be null. Blocks. */
HAPTIC_API int haptic_session_open(haptic_client* client, const haptic_session_options* options,
                                   haptic_session** session, haptic_error* error);
/** Ends the session: its share of the force fades, its lease is released. Null is allowed. Blocks briefly. */
HAPTIC_API void haptic_session_close(haptic_session* session);
/**
 * Opens it again after haptic_reconnect(), on the same device and with the same name: by the URI that the device itself
 * reported, whatever name it was asked for by. With its parameters only if some, or no device, were asked for:
 * HAPTIC_PERMISSION_DENIED if those are the administrator's, and no device has them now. Lease, arming, models and
 * pushed limits are gone: a restarted daemon holds still until told otherwise. One that stands ends first, but where
 * the daemon cannot be asked (no connection, a callback). Blocks.
 */
HAPTIC_API int haptic_session_reopen(haptic_session* session, haptic_error* error);
/** Its number, the servo's period, the device: as told when it was opened. Does not block; any thread. */
HAPTIC_API int haptic_session_describe(haptic_session* session, haptic_session_info** info, haptic_error* error);

/** Reserves the right to arm. HAPTIC_LEASE_HELD names the holder. Blocks; any thread, as the next three. */
HAPTIC_API int haptic_session_acquire_lease(haptic_session* session, haptic_error* error);
/** Gives it back; the device is disarmed. */
HAPTIC_API int haptic_session_release_lease(haptic_session* session, haptic_error* error);
/**
 * Energises the device: takes the lease, clears a latched fault whose cause is gone, and ramps the force up over two
 * seconds once the force asked for is small. HAPTIC_WOULD_BLOCK while the machine goes to sleep, before which every
 * armed device is stopped. After HAPTIC_TIMEOUT it is not armed later either.
 */
HAPTIC_API int haptic_session_arm(haptic_session* session, haptic_error* error);
/**
 * Has the force lowered, in a second at most; haptic_device_status.armed says when none can reach the device. Where
 * nobody holds the lease it is off, and stays so: HAPTIC_OK.
 */
HAPTIC_API int haptic_session_disarm(haptic_session* session, haptic_error* error);

/** HAPTIC_OK while the session lives, else HAPTIC_DISCONNECTED. Any thread, servo-safe. */
HAPTIC_API int haptic_session_check(const haptic_session* session);
/**
 * The newest sample of this session's device, the one before while the servo is stopped in the middle of writing it;
 * one stands when the session has been opened. HAPTIC_WOULD_BLOCK only as long as the servo has not run since then (it
 * was stuck for 50 ms), or when this call itself was stopped for the 1024 samples of the history; ask again. Reading
 * thread, servo-safe.
 */
HAPTIC_API int haptic_session_latest(haptic_session* session, haptic_sample* sample);
/** The same for another device of the group. */
HAPTIC_API int haptic_session_latest_of(haptic_session* session, uint32_t device, haptic_sample* sample);
/**
 * Oldest unread samples in order, of all devices of the group, at most `capacity`. `count` receives how many; `lost`,
 * if not null, is increased by those overwritten unread (the history holds 1024). Reading thread, servo-safe.
 */
HAPTIC_API int haptic_session_drain(haptic_session* session, haptic_sample* samples, uint32_t capacity, uint32_t* count,
                                    uint64_t* lost);
/** Fields are each exact; together they may span a tick. Any thread, servo-safe, as the next two. */
HAPTIC_API int haptic_session_acks(const haptic_session* session, haptic_acks* acks);
HAPTIC_API int haptic_session_counters(const haptic_session* session, haptic_counters* counters);
HAPTIC_API int haptic_session_model_status(const haptic_session* session, uint32_t slot, haptic_model_status* status);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_SESSION_H */
