#include "daemon/scene/object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/scene/invalid.h"
#include "rt/ingest/limits.h"

namespace hapticd {
namespace {

Result<void> length(double value, const std::string& where) {
  if (std::isfinite(value) && value > 0 && value <= limits::kCoordinate) return {};
  return invalid(where, fmt::format("{} is not a length in (0, {}] m", value, limits::kCoordinate),
                 "a box has three half sides, a capsule or cylinder radius and half length, a sphere a radius");
}

}  // namespace

Result<void> checkName(const std::string& name, const std::string& where) {
  const auto allowed = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.' ||
           c == '-';
  };
  if (name.empty()) return invalid(where, "the name is empty", "name it with letters, digits, '_', '.' or '-'");
  if (name.size() > 63)
    return invalid(where, fmt::format("the name has {} bytes; 63 is the most", name.size()), "shorten it");
  if (name == "." || name == "..") return invalid(where, "'.' and '..' are not names", "choose another");
  const auto bad = std::find_if_not(name.begin(), name.end(), allowed);
  if (bad == name.end()) return {};
  return invalid(where,
                 fmt::format("byte {} of the name (0x{:02x}) is not allowed", bad - name.begin(),
                             static_cast<unsigned char>(*bad)),
                 "use letters, digits, '_', '.' and '-'");
}

Result<void> checkPose(Pose& pose, const std::string& where) {
  for (int i = 0; i < 3; ++i) {
    const double x = pose.p[i];
    if (!std::isfinite(x) || std::abs(x) > limits::kCoordinate) {
      return invalid(fmt::format("{}.p.{}", where, "xyz"[i]),
                     fmt::format("{} is not within {} m", x, limits::kCoordinate), "places are in metres");
    }
  }
  const double norm = pose.q.norm();
  if (!std::isfinite(norm) || std::abs(norm - 1.0) > limits::kUnitTolerance) {
    return invalid(where + ".q", fmt::format("the quaternion has norm {}, not 1", norm),
                   "give w, x, y, z of a rotation: 1, 0, 0, 0 is none; else divide by the length");
  }
  pose.q.normalize();
  return {};
}

Result<void> checkMaterial(const hd_material& m, const std::string& where) {
  constexpr const char* kCoefficient = "it is a coefficient: wood on wood has 0.4, ice 0.05";
  if (auto r =
          inRange(m.stiffness, 0, limits::kStiffness, where + ".stiffness", "N/m", "a hard wall has some thousand");
      !r)
    return r;
  if (auto r = inRange(m.damping, 0, limits::kDamping, where + ".damping", "N s/m", "a hard wall has a few"); !r)
    return r;
  if (auto r = inRange(m.friction_static, 0, limits::kFriction, where + ".frictionStatic", "", kCoefficient); !r)
    return r;
  if (auto r = inRange(m.friction_dynamic, 0, limits::kFriction, where + ".frictionDynamic", "", kCoefficient); !r)
    return r;
  if (m.friction_dynamic <= m.friction_static) return {};
  return invalid(where + ".frictionDynamic",
                 fmt::format("{} is above the static friction {}", m.friction_dynamic, m.friction_static),
                 "dynamic friction is at most static friction");
}

Result<void> checkShape(const ShapeSpec& shape, const std::string& where) {
  switch (shape.kind) {
    case ShapeKind::kGroup:
    case ShapeKind::kPlane:
    case ShapeKind::kMesh:
      return {};
    case ShapeKind::kSphere:
      return length(shape.size.x(), where + ".size.x");
    case ShapeKind::kBox:
      for (int i = 0; i < 3; ++i) {
        if (auto r = length(shape.size[i], fmt::format("{}.size.{}", where, "xyz"[i])); !r) return r;
      }
      return {};
    case ShapeKind::kCapsule:
    case ShapeKind::kCylinder:
      if (auto r = length(shape.size.x(), where + ".size.x"); !r) return r;
      return length(shape.size.y(), where + ".size.y");
  }
  return invalid(where + ".kind", fmt::format("{} is no shape", static_cast<std::uint32_t>(shape.kind)),
                 "group, plane, sphere, box, capsule, cylinder or mesh");
}

const char* shapeName(ShapeKind kind) noexcept {
  switch (kind) {
    case ShapeKind::kGroup:
      return "group";
    case ShapeKind::kPlane:
      return "plane";
    case ShapeKind::kSphere:
      return "sphere";
    case ShapeKind::kBox:
      return "box";
    case ShapeKind::kCapsule:
      return "capsule";
    case ShapeKind::kCylinder:
      return "cylinder";
    case ShapeKind::kMesh:
      return "mesh";
  }
  return "unknown";
}

std::uint32_t objectFlags(const ObjectSpec& spec) noexcept {
  std::uint32_t flags = 0;
  if (spec.flags.enabled) flags |= HD_OBJECT_ENABLED;
  if (spec.flags.visible) flags |= HD_OBJECT_VISIBLE;
  if (spec.flags.two_sided) flags |= HD_OBJECT_TWO_SIDED;
  return flags;
}

}  // namespace hapticd
