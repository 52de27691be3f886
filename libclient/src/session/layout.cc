// The public structures are the shared memory's, field by field.
#include <hapticclient/push.h>
#include <hapticclient/scene.h>
#include <hapticclient/session.h>

#include <cstddef>

#include "proto/control.capnp.h"
#include "proto/shm_layout.h"
#include "proto/snapshot.h"
#include "proto/volume.h"

#define SAME_SIZE(a, b) static_assert(sizeof(a) == sizeof(b), #a)
#define SAME_FIELD(a, b, field) (offsetof(a, field) == offsetof(b, field) && sizeof(a::field) == sizeof(b::field))

namespace {

// What is copied whole.
#define S(f) SAME_FIELD(haptic_sample, hd_sample, f)
SAME_SIZE(haptic_sample, hd_sample);
static_assert(S(guard) && S(tick) && S(t_ns) && S(device) && S(flags) && S(fault) && S(buttons) && S(p) && S(q) &&
              S(v) && S(w) && S(proxy) && S(force));
static_assert(S(torque) && S(by_source) && S(gripper_rad) && S(gripper_force_n) && S(own) && S(energy_j) &&
              S(depth_m) && S(contact_object));
static_assert(S(missed) && S(wake_ns) && S(cycle_ns) && S(applied_commands) && S(reserved));
#undef S
#define S(f) SAME_FIELD(haptic_material, hd_material, f)
SAME_SIZE(haptic_material, hd_material);
static_assert(S(stiffness) && S(damping) && S(friction_static) && S(friction_dynamic));
#undef S
#define S(f) SAME_FIELD(haptic_object_pose, hd_object_pose, f)
SAME_SIZE(haptic_object_pose, hd_object_pose);
static_assert(S(object) && S(lease_us) && S(p) && S(q) && S(v) && S(w));
#undef S
#define S(f) SAME_FIELD(haptic_object_material, hd_object_material, f)
SAME_SIZE(haptic_object_material, hd_object_material);
static_assert(S(object) && S(material));
#undef S
#define S(f) SAME_FIELD(haptic_object_flags, hd_object_flags, f)
SAME_SIZE(haptic_object_flags, hd_object_flags);
static_assert(S(object) && S(mask) && S(value));
#undef S
#define S(f) SAME_FIELD(haptic_object_vertices, hd_object_vertices, f)
SAME_SIZE(haptic_object_vertices, hd_object_vertices);
SAME_SIZE(haptic_vertex_move, hd_vertex_move);
static_assert(SAME_FIELD(haptic_vertex_move, hd_vertex_move, index));
static_assert(SAME_FIELD(haptic_vertex_move, hd_vertex_move, p));
static_assert(S(object) && S(count) && S(move));
#undef S
#define S(f) SAME_FIELD(haptic_local_model, hd_local_model, f)
SAME_SIZE(haptic_local_model, hd_local_model);
static_assert(S(slot) && S(kind) && S(frame) && S(device) && S(lease_ns) && S(blend_ns) && S(material) && S(origin) &&
              S(normal) && S(radius));
static_assert(S(count) && S(halfspace));
#undef S
#define S(f) SAME_FIELD(haptic_force_field, hd_force_field, f)
SAME_SIZE(haptic_force_field, hd_force_field);
static_assert(S(slot) && S(frame) && S(device) && S(lease_ns) && S(blend_ns) && S(x0) && S(f0) && S(jacobian) &&
              S(radius));
#undef S
#define S(f) SAME_FIELD(haptic_clear_model, hd_clear_model, f)
SAME_SIZE(haptic_clear_model, hd_clear_model);
static_assert(S(slot) && S(blend_ns));
#undef S
#define S(f) SAME_FIELD(haptic_client_force, hd_client_force, f)
SAME_SIZE(haptic_client_force, hd_client_force);
static_assert(S(device) && S(lease_ns) && S(force) && S(torque));
#undef S
#define S(f) SAME_FIELD(haptic_intent, hd_intent, f)
SAME_SIZE(haptic_intent, hd_intent);
static_assert(S(device) && S(p) && S(q) && S(gripper_rad));
#undef S
#define S(f) SAME_FIELD(haptic_session_limits, hd_limits, f)
SAME_SIZE(haptic_session_limits, hd_limits);
static_assert(S(force_n) && S(torque_nm));
#undef S

// Numbers.
#define N(name) (int{HAPTIC_##name} == int{HD_##name})
static_assert(N(SOURCE_SURFACE) && N(SOURCE_EFFECT) && N(SOURCE_LOCAL_MODEL) && N(SOURCE_CLIENT) && N(SOURCE_GRAVITY) &&
              N(SOURCE_GUARD));
static_assert(N(SOURCES) && N(SAMPLE_ARMED) && N(SAMPLE_RAMPING) && N(SAMPLE_FAULT) && N(SAMPLE_CONTACT) &&
              N(SAMPLE_SLIP) && N(SAMPLE_LIMITED));
static_assert(N(SAMPLE_PASSIVITY) && N(SAMPLE_STALE) && N(SAMPLE_NO_RT) && N(SAMPLE_SATURATED) && N(SAMPLE_WAITING) &&
              N(SAMPLE_CLUTCHED) && N(FAULT_NONE) && N(FAULT_STOP_LINE));
static_assert(N(FAULT_NOT_FINITE) && N(FAULT_VELOCITY) && N(FAULT_DEVICE_LOST) && N(FAULT_DEVICE_ERROR) &&
              N(FAULT_DEADMAN) && N(FAULT_OVERRUN));
static_assert(N(FAULT_ENERGY) && N(FAULT_COUNT) && N(OBJECT_ENABLED) && N(OBJECT_VISIBLE) && N(OBJECT_TWO_SIDED) &&
              N(MODEL_PLANE));
static_assert(N(MODEL_SPRING) && N(MODEL_SPHERE) && N(MODEL_HALFSPACES) && N(MODEL_CORNER) && N(MESH_DEFORMABLE));
#undef N
static_assert(HAPTIC_MESH_VOLUME == HD_UPLOAD_VOLUME && HAPTIC_MESH_FILL_HOLES == HD_UPLOAD_FILL_HOLES);
static_assert(HAPTIC_MODEL_SLOTS == HD_MODEL_SLOTS && HAPTIC_HALFSPACES == HD_HALFSPACES);
static_assert(HAPTIC_VERTEX_MOVES == HD_VERTEX_MOVES);

#define N(name, value) (int{HAPTIC_SHAPE_##name} == int(hapticd::proto::ShapeKind::value))
static_assert(N(GROUP, GROUP) && N(PLANE, PLANE) && N(SPHERE, SPHERE) && N(BOX, BOX) && N(CAPSULE, CAPSULE) &&
              N(CYLINDER, CYLINDER));
static_assert(N(MESH, MESH));
#undef N

}  // namespace
