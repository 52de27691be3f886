#include "libclient/src/session/push_check.h"

#include <hapticclient/scene.h>

#include <cmath>
#include <cstddef>

namespace hapticd::client {
namespace {

// As the daemon's; tests/unit/libclient/push_check_test.cc compares the two. NaN fails every comparison.

constexpr const char* kMetres = "lengths are metres; check how it was computed";
constexpr const char* kFromZeros = "start from the structure's INIT, or from zeros";

bool within(double x, double bound) noexcept { return std::abs(x) <= bound; }
bool between(double x, double low, double high) noexcept { return x >= low && x <= high; }

template <class T, std::size_t N>
bool within(const T (&x)[N], double bound) noexcept {
  for (const T entry : x) {
    if (!within(entry, bound)) return false;
  }
  return true;
}

template <class T>
double norm(const T* x, int n) noexcept {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += double{x[i]} * x[i];
  return std::sqrt(sum);
}
template <class T>
bool unit(const T* x, int n) noexcept {
  return within(norm(x, n) - 1, 1e-3);
}

bool place(const double (&p)[3]) noexcept { return within(p, 100); }

Objection object(std::uint32_t id) noexcept {
  if (id != 0) return {};
  return {"object", "is 0, which is no object's number",
          "take the id that creating the object gave, or haptic_object_find()"};
}
Objection reserved(std::uint32_t value) noexcept {
  return value == 0 ? Objection{} : Objection{"reserved", "is not 0", kFromZeros};
}
Objection slot(std::uint32_t number) noexcept {
  if (number < HAPTIC_MODEL_SLOTS) return {};
  return {"slot", "is not one of the 8 that a session has, counted from 0", "take another one's place, or clear one"};
}
Objection device(std::uint32_t number, std::uint32_t devices) noexcept {
  if (number < devices) return {};
  return {"device", "is none of those that share this session's servo", "haptic_session_info.device_index is yours"};
}
Objection lease(std::int64_t ns) noexcept {
  if (ns > 0 && ns <= 10'000'000'000) return {};
  return {"lease_ns", "is not above 0 and at most 10 s", "say how long it holds without news from you, as 0.2 s"};
}
Objection blend(std::int64_t ns) noexcept {
  if (ns >= 0 && ns <= 1'000'000'000) return {};
  return {"blend_ns", "is not between 0 and 1 s", "20 ms are usual"};
}
Objection rotation(const double (&q)[4]) noexcept {
  if (unit(q, 4)) return {};
  return {"q", "is no unit quaternion w, x, y, z", "no rotation is 1, 0, 0, 0; else divide by the length"};
}

Objection material(const haptic_material& m) noexcept {
  if (!between(m.stiffness, 0, 1e5))
    return {"material.stiffness", "is not between 0 and 100000 N/m", "a hard wall has some thousand"};
  if (!between(m.damping, 0, 1e3))
    return {"material.damping", "is not between 0 and 1000 N s/m", "a hard wall has a few"};
  if (!between(m.friction_static, 0, 5))
    return {"material.friction_static", "is not between 0 and 5", "it is a coefficient"};
  if (!between(m.friction_dynamic, 0, m.friction_static))
    return {"material.friction_dynamic", "is not between 0 and friction_static",
            "what slides is held no more than what sticks"};
  return {};
}

/** Of what the kind of model uses; the rest may be anything. */
Objection shape(const haptic_local_model& c) noexcept {
  switch (c.kind) {
    case HAPTIC_MODEL_PLANE:
      if (!unit(c.normal, 3))
        return {"normal", "is no unit vector", "divide it by its length; it points out of the solid"};
      return {};
    case HAPTIC_MODEL_SPRING:
      if (!between(c.radius, 0, 100)) return {"radius", "is no free length between 0 and 100 m", kMetres};
      return {};
    case HAPTIC_MODEL_SPHERE:
      if (!between(std::abs(c.radius), 1e-6, 100))
        return {"radius", "is not between 1 um and 100 m, nor minus that",
                "lengths are metres; negative keeps the hand inside"};
      return {};
    case HAPTIC_MODEL_HALFSPACES:
    case HAPTIC_MODEL_CORNER:
      if (c.count < 1 || c.count > HAPTIC_HALFSPACES)
        return {"count", "is not between 1 and 16", "say how many half-spaces are in use"};
      if (c.kind == HAPTIC_MODEL_HALFSPACES && !between(c.radius, 0, 100))
        return {"radius", "is no rounding of edges between 0 and 100 m", kMetres};
      for (std::uint32_t i = 0; i < c.count; ++i) {
        if (!unit(c.halfspace[i], 3))
          return {"halfspace[%u]", "has no unit normal", "divide it by its length; it points out of the solid", i};
        if (!within(c.halfspace[i][3], 100)) return {"halfspace[%u]", "has no offset within 100 m", kMetres, i};
      }
      return {};
    default:
      return {"kind", "is no haptic_model_kind", "HAPTIC_MODEL_PLANE, _SPRING, _SPHERE, _HALFSPACES or _CORNER"};
  }
}

constexpr const char* kPlace = "is not finite, or farther than 100 m away";

}  // namespace

Objection objection(const haptic_object_pose& c, std::uint32_t) noexcept {
  if (const auto no = object(c.object)) return no;
  if (!place(c.p)) return {"p", kPlace, kMetres};
  if (const auto no = rotation(c.q)) return no;
  if (!within(c.v, 100)) return {"v", "is not finite, or faster than 100 m/s", kMetres};
  if (!within(c.w, 1000)) return {"w", "is not finite, or faster than 1000 rad/s", "angles are radians"};
  return {};
}

Objection objection(const haptic_object_material& c, std::uint32_t) noexcept {
  if (const auto no = object(c.object)) return no;
  if (const auto no = reserved(c.reserved)) return no;
  return material(c.material);
}

Objection objection(const haptic_object_flags& c, std::uint32_t) noexcept {
  constexpr std::uint32_t kKnown = HAPTIC_OBJECT_ENABLED | HAPTIC_OBJECT_VISIBLE | HAPTIC_OBJECT_TWO_SIDED;
  constexpr const char* kOthers = "has a bit that a push does not change";
  constexpr const char* kThese = "HAPTIC_OBJECT_ENABLED, _VISIBLE and _TWO_SIDED";
  if (const auto no = object(c.object)) return no;
  if (const auto no = reserved(c.reserved)) return no;
  if ((c.mask & ~kKnown) != 0) return {"mask", kOthers, kThese};
  if ((c.value & ~kKnown) != 0) return {"value", kOthers, kThese};
  return {};
}

Objection objection(const haptic_object_vertices& c, std::uint32_t) noexcept {
  if (const auto no = object(c.object)) return no;
  if (c.count < 1 || c.count > HAPTIC_VERTEX_MOVES)
    return {"count", "is not between 1 and 26", "send more in several pushes"};
  for (std::uint32_t i = 0; i < c.count; ++i) {
    if (!within(c.move[i].p, 100)) return {"move[%u].p", kPlace, kMetres, i};
  }
  return {};
}

Objection objection(const haptic_local_model& c, std::uint32_t devices) noexcept {
  if (const auto no = slot(c.slot)) return no;
  if (const auto no = device(c.device, devices)) return no;
  if (const auto no = reserved(c.reserved)) return no;
  if (const auto no = lease(c.lease_ns)) return no;
  if (const auto no = blend(c.blend_ns)) return no;
  if (const auto no = material(c.material)) return no;
  if (!place(c.origin)) return {"origin", kPlace, kMetres};
  return shape(c);
}

Objection objection(const haptic_force_field& c, std::uint32_t devices) noexcept {
  if (const auto no = slot(c.slot)) return no;
  if (const auto no = device(c.device, devices)) return no;
  if (const auto no = reserved(c.reserved)) return no;
  if (const auto no = lease(c.lease_ns)) return no;
  if (const auto no = blend(c.blend_ns)) return no;
  if (!place(c.x0)) return {"x0", kPlace, kMetres};
  if (!within(norm(c.f0, 3), 1000)) return {"f0", "is not finite, or more than 1000 N", "check how it was computed"};
  if (!within(c.jacobian, 1e5))
    return {"jacobian", "has an entry that is not finite, or beyond 100000 N/m", "check how it was computed"};
  if (!between(c.radius, 1e-6, 100))
    return {"radius", "is not between 1 um and 100 m", "say how far from x0 the force holds [m]"};
  return {};
}

Objection objection(const haptic_clear_model& c, std::uint32_t) noexcept {
  if (const auto no = slot(c.slot)) return no;
  if (const auto no = reserved(c.reserved)) return no;
  return blend(c.blend_ns);
}

Objection objection(const haptic_client_force& c, std::uint32_t devices) noexcept {
  if (const auto no = device(c.device, devices)) return no;
  if (const auto no = reserved(c.reserved)) return no;
  if (const auto no = lease(c.lease_ns)) return no;
  if (!within(norm(c.force, 3), 1000))
    return {"force", "is not finite, or more than 1000 N", "check how it was computed"};
  if (!within(norm(c.torque, 3), 100))
    return {"torque", "is not finite, or more than 100 N m", "check how it was computed"};
  return {};
}

Objection objection(const haptic_intent& c, std::uint32_t devices) noexcept {
  if (const auto no = device(c.device, devices)) return no;
  if (const auto no = reserved(c.reserved)) return no;
  if (!place(c.p)) return {"p", kPlace, kMetres};
  if (const auto no = rotation(c.q)) return no;
  if (!within(c.gripper_rad, 6.5)) return {"gripper_rad", "is not finite, or beyond 6.5 rad", "angles are radians"};
  return {};
}

Objection objection(const haptic_session_limits& c, std::uint32_t) noexcept {
  if (!between(c.force_n, 0, 1000))
    return {"force_n", "is not between 0 and 1000 N", "0 takes this session's force away"};
  if (!between(c.torque_nm, 0, 100))
    return {"torque_nm", "is not between 0 and 100 N m", "0 takes this session's torque away"};
  return {};
}

}  // namespace hapticd::client
