/** @file
 * What a client sends at its own pace: object motion, local models and forces. The servo renders them at full rate,
 * blends from one to the next without a jump, and fades what is not renewed within its lease.
 *
 * A push writes to shared memory and returns at once. HAPTIC_OK: it is on its way; the daemon checks its own copy and
 * counts in haptic_acks what it refuses. What its servo refuses (an object that is no more) it does not count: of both
 * HAPTIC_EVENT_REFUSED tells. Else nothing was sent, and haptic_push_refusal() says why in words.
 * HAPTIC_INVALID_ARGUMENT: a value is malformed, not finite or out of range. HAPTIC_WOULD_BLOCK: 256 commands wait
 * already. HAPTIC_QUOTA_EXCEEDED: 16 targets have a mailbox already (below). HAPTIC_DISCONNECTED: the session is over.
 * Pushing thread of the session, servo-safe. The _INIT macros are what zeros are not: a rotation, a lease, a limit.
 *
 * Two ways: the ring keeps every command and their order; a mailbox keeps only the newest value of its target, never
 * fills up, and is right for what is sent faster than it is needed. HAPTIC_PUSH_LATEST takes a mailbox for the target
 * (an object's pose, a model slot, a device's intent, ...); 16 targets of a session can have one. A target that has one
 * keeps it, also for pushes without the flag, so that old never overtakes new; it then takes no `at_tick`
 * (HAPTIC_INVALID_ARGUMENT). An object's flags and vertices, of which each push changes some, go by the ring alone:
 * with the flag they are refused.
 */
#ifndef HAPTICCLIENT_PUSH_H
#define HAPTICCLIENT_PUSH_H

#include <hapticclient/session.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTIC_HALFSPACES 16u   /**< Half-spaces of one convex patch. */
#define HAPTIC_VERTEX_MOVES 26u /**< Vertices one push can move. */

typedef enum haptic_push_flag {
  HAPTIC_PUSH_LATEST = 1 << 0 /**< Only the newest value matters: use a mailbox. */
} haptic_push_flag;

/** How to push, and what became of it. Null wherever it is asked for: by the ring, at once. */
typedef struct haptic_push {
  /**
   * Takes effect at this tick; 0 or the past: at once. Ring only. Of a session 8 may wait for theirs, 10 s ahead unless
   * configured otherwise; the others come back in haptic_acks.
   */
  uint64_t at_tick;
  uint32_t flags; /**< haptic_push_flag */
  uint32_t reserved;
  uint64_t seq; /**< Out: the command's number, as in haptic_acks (ring) and haptic_model_status. */
} haptic_push;

/**
 * Pose and velocity of an object in its parent's frame. The servo moves it on by the velocity between updates, as long
 * as the session lives: once it has ended, or its heartbeat has stopped, the object stands. The library sends that
 * heartbeat, also for a program that hangs: give a motion that must not outlive your loop a lease. What is to move
 * without a program gets its velocity from the scene (the resource /objects/NAME/velocity).
 */
typedef struct haptic_object_pose {
  uint32_t object;   /**< Id from the scene. */
  uint32_t lease_us; /**< The velocity lasts so long without another pose; 0: as long as the session. */
  double p[3];       /**< [m] */
  double q[4];       /**< w x y z */
  double v[3];       /**< [m/s] */
  double w[3];       /**< [rad/s] */
} haptic_object_pose;

/** At the parent's origin, at rest; no object yet. */
#define HAPTIC_OBJECT_POSE_INIT                           \
  {                                                       \
    0, 0, {0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0}, { 0, 0, 0 } \
  }

typedef struct haptic_object_material {
  uint32_t object;
  uint32_t reserved;
  haptic_material material;
} haptic_object_material;

typedef struct haptic_object_flags {
  uint32_t object;
  uint32_t mask;  /**< Bits of haptic_object_flag to change: enabled, visible, two-sided. */
  uint32_t value; /**< Their new values. */
  uint32_t reserved;
} haptic_object_flags;

typedef struct haptic_vertex_move {
  uint32_t index; /**< As uploaded. */
  float p[3];     /**< New place in the object's frame [m]. */
} haptic_vertex_move;

/** Moves vertices of a mesh that was uploaded deformable. */
typedef struct haptic_object_vertices {
  uint32_t object;
  uint32_t count;
  haptic_vertex_move move[HAPTIC_VERTEX_MOVES];
} haptic_object_vertices;

typedef enum haptic_model_kind {
  HAPTIC_MODEL_PLANE = 1,      /**< Solid behind the plane through `origin` with outward `normal`. */
  HAPTIC_MODEL_SPRING = 2,     /**< Spring from the device point to `origin`. */
  HAPTIC_MODEL_SPHERE = 3,     /**< Sphere of `radius` about `origin`; negative radius: the hand is kept inside. */
  HAPTIC_MODEL_HALFSPACES = 4, /**< Convex solid: where all of up to 16 half-spaces overlap (a bump, an outer edge). */
  HAPTIC_MODEL_CORNER = 5      /**< Solid where any of them is: the hand stays outside all (an inner edge). */
} haptic_model_kind;

/** Geometry near the tool, rendered by the servo at full rate until its lease runs out. */
typedef struct haptic_local_model {
  uint32_t slot;    /**< 0 to HAPTIC_MODEL_SLOTS - 1. */
  uint32_t kind;    /**< haptic_model_kind */
  uint32_t frame;   /**< 0: world; else an object id: the model moves along with it. */
  uint32_t device;  /**< Device of the group; see haptic_session_info.device_index. */
  int64_t lease_ns; /**< In force this long after it was applied, then fades; at most 10 s. */
  /** Time over which it replaces the former model of the slot; at most 1 s, and less than 5 ms is 5 ms. */
  int64_t blend_ns;
  haptic_material material;
  double origin[3]; /**< In `frame` [m]; so is all that follows. */
  double normal[3]; /**< Unit, outward (plane). */
  double radius;    /**< Sphere: radius; spring: free length; convex solid: rounding of its edges, 0: 0.5 mm [m]. */
  uint32_t count;   /**< Half-spaces in use. */
  uint32_t reserved;
  float halfspace[HAPTIC_HALFSPACES][4]; /**< Unit outward normal n and offset d: behind it n.(x-origin) <= d. */
} haptic_local_model;

/** In slot 0 for 0.5 s, blended over 20 ms; 1000 N/m, 1 N s/m, no friction; no kind and no shape yet. */
#define HAPTIC_LOCAL_MODEL_INIT                                                        \
  {                                                                                    \
    0, 0, 0, 0, 500000000, 20000000, {1000, 1, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, 0, 0, { \
      { 0, 0, 0, 0 }                                                                   \
    }                                                                                  \
  }

/** Force f0 + J (x - x0) within `radius` of x0, fading to zero over the outer fifth. */
typedef struct haptic_force_field {
  uint32_t slot;  /**< Shares its numbers with local models. */
  uint32_t frame; /**< Of x0, f0 and the Jacobian; this, device, lease_ns and blend_ns as in haptic_local_model. */
  uint32_t device;
  uint32_t reserved;
  int64_t lease_ns;
  int64_t blend_ns;
  double x0[3];       /**< [m] */
  double f0[3];       /**< [N] */
  double jacobian[9]; /**< Row-major dF/dx [N/m]. */
  double radius;      /**< [m] */
} haptic_force_field;

/** In slot 0 for 0.1 s, blended over 10 ms; no force and no radius yet. */
#define HAPTIC_FORCE_FIELD_INIT \
  { 0, 0, 0, 0, 100000000, 10000000, {0, 0, 0}, {0, 0, 0}, {0, 0, 0, 0, 0, 0, 0, 0, 0}, 0 }

typedef struct haptic_clear_model {
  uint32_t slot;
  uint32_t reserved;
  int64_t blend_ns; /**< Time over which it vanishes; at most 1 s, and less than 5 ms is 5 ms. */
} haptic_clear_model;

/** Force computed by the client, in the world, held until replaced or until the lease runs out. */
typedef struct haptic_client_force {
  uint32_t device;
  uint32_t reserved;
  int64_t lease_ns; /**< As in haptic_local_model. */
  double force[3];  /**< [N] */
  double torque[3]; /**< [N m] */
} haptic_client_force;

/** No force yet, for 50 ms. */
#define HAPTIC_CLIENT_FORCE_INIT           \
  {                                        \
    0, 0, 50000000, {0, 0, 0}, { 0, 0, 0 } \
  }

/**
 * Where in the world the hand of a simulated device wants to be; it strives no farther than 10 m along each axis of the
 * device.
 */
typedef struct haptic_intent {
  uint32_t device;
  uint32_t reserved;
  double p[3]; /**< [m] */
  double q[4]; /**< w x y z */
  double gripper_rad;
} haptic_intent;

/** At the origin of the world. */
#define HAPTIC_INTENT_INIT \
  { 0, 0, {0, 0, 0}, {1, 0, 0, 0}, 0 }

/** Binds this session's own share; can only lower what the daemon allows. 0 takes it away. */
typedef struct haptic_session_limits {
  double force_n;
  double torque_nm;
} haptic_session_limits;

/** The highest there are: lower what shall be bound, the other is left alone. */
#define HAPTIC_SESSION_LIMITS_INIT \
  { 1000, 100 }

HAPTIC_API int haptic_push_object_pose(haptic_session* session, const haptic_object_pose* pose, haptic_push* push);
HAPTIC_API int haptic_push_object_material(haptic_session* session, const haptic_object_material* material,
                                           haptic_push* push);
HAPTIC_API int haptic_push_object_flags(haptic_session* session, const haptic_object_flags* flags, haptic_push* push);
HAPTIC_API int haptic_push_object_vertices(haptic_session* session, const haptic_object_vertices* vertices,
                                           haptic_push* push);
HAPTIC_API int haptic_push_local_model(haptic_session* session, const haptic_local_model* model, haptic_push* push);
HAPTIC_API int haptic_push_force_field(haptic_session* session, const haptic_force_field* field, haptic_push* push);
HAPTIC_API int haptic_push_clear_model(haptic_session* session, const haptic_clear_model* clear, haptic_push* push);
HAPTIC_API int haptic_push_client_force(haptic_session* session, const haptic_client_force* force, haptic_push* push);
HAPTIC_API int haptic_push_intent(haptic_session* session, const haptic_intent* intent, haptic_push* push);
HAPTIC_API int haptic_push_limits(haptic_session* session, const haptic_session_limits* limits, haptic_push* push);

/**
 * Why the last push of this session was refused: its code, and in `error` the field, the fault and the remedy.
 * HAPTIC_OK and nothing else if it was not. Pushing thread; for people to read, so not servo-safe.
 * HAPTIC_INVALID_ARGUMENT for null.
 */
HAPTIC_API int haptic_push_refusal(const haptic_session* session, haptic_error* error);
/** Commands that the ring takes now without HAPTIC_WOULD_BLOCK; 0 when disconnected. */
HAPTIC_API uint32_t haptic_push_space(const haptic_session* session);

#ifdef __cplusplus
}
#endif
#endif /* HAPTICCLIENT_PUSH_H */
