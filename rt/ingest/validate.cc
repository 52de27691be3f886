#include "rt/ingest/validate.h"

#include <cmath>
#include <cstring>

#include "rt/ingest/limits.h"

namespace hapticd {
namespace {

// All comparisons are written so that NaN fails them.

bool within(double x, double bound) HD_RT { return std::abs(x) <= bound; }
bool between(double x, double low, double high) HD_RT { return x >= low && x <= high; }

bool within(const double (&x)[3], double bound) HD_RT {
  return within(x[0], bound) && within(x[1], bound) && within(x[2], bound);
}

template <class T>
double norm(const T* x, int n) HD_RT {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += static_cast<double>(x[i]) * static_cast<double>(x[i]);
  return std::sqrt(sum);
}

bool normWithin(const double (&x)[3], double bound) HD_RT { return norm(x, 3) <= bound; }

/** Makes x a unit vector if it nearly is one. */
template <class T>
bool makeUnit(T* x, int n) HD_RT {
  const double length = norm(x, n);
  if (!(std::abs(length - 1) <= limits::kUnitTolerance)) return false;
  for (int i = 0; i < n; ++i) x[i] = static_cast<T>(static_cast<double>(x[i]) / length);
  return true;
}

bool goodLease(std::int64_t ns) HD_RT { return ns > 0 && ns <= limits::kLeaseNs; }
bool goodBlend(std::int64_t ns) HD_RT { return ns >= 0 && ns <= limits::kBlendNs; }

// One check per payload. Each may normalise what it is given, which is a private copy.

bool check(hd_material& m, std::uint32_t) HD_RT {
  return between(m.stiffness, 0, limits::kStiffness) && between(m.damping, 0, limits::kDamping) &&
         between(m.friction_static, 0, limits::kFriction) && between(m.friction_dynamic, 0, m.friction_static);
}

bool check(hd_object_pose& x, std::uint32_t) HD_RT {
  return within(x.p, limits::kCoordinate) && makeUnit(x.q, 4) && within(x.v, limits::kSpeed) &&
         within(x.w, limits::kAngularSpeed);
}

bool check(hd_object_material& x, std::uint32_t devices) HD_RT { return x.reserved == 0 && check(x.material, devices); }

bool check(hd_object_flags& x, std::uint32_t) HD_RT {
  constexpr std::uint32_t kKnown = HD_OBJECT_ENABLED | HD_OBJECT_VISIBLE | HD_OBJECT_TWO_SIDED;
  return x.reserved == 0 && (x.mask & ~kKnown) == 0 && (x.value & ~kKnown) == 0;
}

bool check(hd_object_vertices& x, std::uint32_t) HD_RT {
  if (x.count < 1 || x.count > HD_VERTEX_MOVES) return false;
  for (std::uint32_t i = 0; i < x.count; ++i) {
    for (const float coordinate : x.move[i].p) {
      if (!within(coordinate, limits::kCoordinate)) return false;
    }
  }
  std::memset(x.move + x.count, 0, (HD_VERTEX_MOVES - x.count) * sizeof x.move[0]);
  return true;
}

/** Checks what the kind of model uses and clears the rest. */
bool checkShape(hd_local_model& x) HD_RT {
  const hd_local_model given = x;
  std::memset(x.normal, 0, sizeof x.normal);
  std::memset(x.halfspace, 0, sizeof x.halfspace);
  x.radius = 0;
  x.count = 0;
  switch (given.kind) {
    case HD_MODEL_PLANE:
      std::memcpy(x.normal, given.normal, sizeof x.normal);
      return makeUnit(x.normal, 3);
    case HD_MODEL_SPRING:
      x.radius = given.radius;
      return between(x.radius, 0, limits::kCoordinate);
    case HD_MODEL_SPHERE:
      x.radius = given.radius;
      return between(std::abs(x.radius), limits::kRadiusMin, limits::kCoordinate);
    case HD_MODEL_HALFSPACES:
    case HD_MODEL_CORNER:
      if (given.count < 1 || given.count > HD_HALFSPACES) return false;
      if (given.kind == HD_MODEL_HALFSPACES) x.radius = given.radius;
      if (!between(x.radius, 0, limits::kCoordinate)) return false;
      x.count = given.count;
      std::memcpy(x.halfspace, given.halfspace, x.count * sizeof x.halfspace[0]);
      for (std::uint32_t i = 0; i < x.count; ++i) {
        if (!makeUnit(x.halfspace[i], 3) || !within(x.halfspace[i][3], limits::kCoordinate)) return false;
      }
      return true;
    default:
      return false;
  }
}

bool check(hd_local_model& x, std::uint32_t devices) HD_RT {
  return x.slot < HD_MODEL_SLOTS && x.device < devices && x.reserved == 0 && goodLease(x.lease_ns) &&
         goodBlend(x.blend_ns) && check(x.material, devices) && within(x.origin, limits::kCoordinate) && checkShape(x);
}

bool check(hd_force_field& x, std::uint32_t devices) HD_RT {
  for (const double entry : x.jacobian) {
    if (!within(entry, limits::kStiffness)) return false;
  }
  return x.slot < HD_MODEL_SLOTS && x.device < devices && x.reserved == 0 && goodLease(x.lease_ns) &&
         goodBlend(x.blend_ns) && within(x.x0, limits::kCoordinate) && normWithin(x.f0, limits::kForce) &&
         between(x.radius, limits::kRadiusMin, limits::kCoordinate);
}

bool check(hd_clear_model& x, std::uint32_t) HD_RT {
  return x.slot < HD_MODEL_SLOTS && x.reserved == 0 && goodBlend(x.blend_ns);
}

bool check(hd_client_force& x, std::uint32_t devices) HD_RT {
  return x.device < devices && x.reserved == 0 && goodLease(x.lease_ns) && normWithin(x.force, limits::kForce) &&
         normWithin(x.torque, limits::kTorque);
}

bool check(hd_intent& x, std::uint32_t devices) HD_RT {
  return x.device < devices && x.reserved == 0 && within(x.p, limits::kCoordinate) && makeUnit(x.q, 4) &&
         within(x.gripper_rad, limits::kGripper);
}

bool check(hd_limits& x, std::uint32_t) HD_RT {
  return between(x.force_n, 0, limits::kForce) && between(x.torque_nm, 0, limits::kTorque);
}

/** A payload's exact length, but vertices may leave out the moves that are not in use. */
template <class T>
bool goodLength(const T&, std::uint32_t length) HD_RT {
  return length == sizeof(T);
}
bool goodLength(const hd_object_vertices& x, std::uint32_t length) HD_RT {
  return x.count <= HD_VERTEX_MOVES && length <= sizeof x &&
         length >= offsetof(hd_object_vertices, move) + x.count * sizeof(hd_vertex_move);
}

template <class T>
ErrorCode accept(const hd_slot& copy, std::uint32_t devices, Command& out) HD_RT {
  static_assert(sizeof(T) <= sizeof copy.payload && sizeof(T) <= sizeof out.payload);
  T payload;
  std::memcpy(&payload, copy.payload, sizeof payload);
  if (!goodLength(payload, copy.length) || !check(payload, devices)) return ErrorCode::kInvalidArgument;
  out = Command{};
  out.kind = static_cast<CommandKind>(copy.kind);
  out.seq = copy.seq;
  out.at_tick = copy.at_tick;
  std::memcpy(out.payload, &payload, sizeof payload);
  return ErrorCode::kOk;
}

}  // namespace

ErrorCode validate(const hd_slot& copy, std::uint32_t device_count, Command& out) HD_RT {
  if (copy.reserved != 0) return ErrorCode::kInvalidArgument;
  switch (copy.kind) {
    case HD_COMMAND_OBJECT_POSE:
      return accept<hd_object_pose>(copy, device_count, out);
    case HD_COMMAND_OBJECT_MATERIAL:
      return accept<hd_object_material>(copy, device_count, out);
    case HD_COMMAND_OBJECT_FLAGS:
      return accept<hd_object_flags>(copy, device_count, out);
    case HD_COMMAND_OBJECT_VERTICES:
      return accept<hd_object_vertices>(copy, device_count, out);
    case HD_COMMAND_LOCAL_MODEL:
      return accept<hd_local_model>(copy, device_count, out);
    case HD_COMMAND_FORCE_FIELD:
      return accept<hd_force_field>(copy, device_count, out);
    case HD_COMMAND_CLEAR_MODEL:
      return accept<hd_clear_model>(copy, device_count, out);
    case HD_COMMAND_CLIENT_FORCE:
      return accept<hd_client_force>(copy, device_count, out);
    case HD_COMMAND_INTENT:
      return accept<hd_intent>(copy, device_count, out);
    case HD_COMMAND_LIMITS:
      return accept<hd_limits>(copy, device_count, out);
    default:
      return ErrorCode::kUnsupported;
  }
}

}  // namespace hapticd
