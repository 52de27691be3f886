#include <fmt/format.h>

#include <cmath>

#include "daemon/resource/properties.h"
#include "daemon/resource/resource_name.h"

namespace hapticd {
namespace {

using Json = nlohmann::json;

Result<Pose> parsePose(std::string_view value, const std::string& where) {
  auto n = parseNumbers(value, 7, where);
  if (!n) return n.error();
  return Pose{{(*n)[0], (*n)[1], (*n)[2]}, Quat((*n)[3], (*n)[4], (*n)[5], (*n)[6])};
}

Result<Vec3> parseVec3(std::string_view value, const std::string& where) {
  auto n = parseNumbers(value, 3, where);
  if (!n) return n.error();
  return Vec3((*n)[0], (*n)[1], (*n)[2]);
}

Result<void> setPos(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto p = parseVec3(value, where);
  if (!p) return p.error();
  return core.scene().setPose(object.spec.name, {*p, object.spec.X_PO.q});
}

Result<void> setRot(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto n = parseNumbers(value, 4, where);
  if (!n) return n.error();
  return core.scene().setPose(object.spec.name, {object.spec.X_PO.p, Quat((*n)[0], (*n)[1], (*n)[2], (*n)[3])});
}

Result<void> setPose(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto pose = parsePose(value, where);
  if (!pose) return pose.error();
  return core.scene().setPose(object.spec.name, *pose);
}

Result<void> setWorldPos(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto p = parseVec3(value, where);
  if (!p) return p.error();
  const Pose X_PW = core.scene().worldPose(object.spec.parent).inverse();
  return core.scene().setPose(object.spec.name, {X_PW * *p, object.spec.X_PO.q});
}

Result<void> setVelocity(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto v = parseVec3(value, where);
  if (!v) return v.error();
  return core.scene().setVelocity(object.spec.name, {*v, object.V_PO.w});
}

template <double hd_material::*kField>
Result<void> setMaterialField(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto n = parseNumbers(value, 1, where);
  if (!n) return n.error();
  hd_material material = object.spec.material;
  material.*kField = n->front();
  return core.scene().setMaterial(object.spec.name, material);
}

template <double hd_material::*kField>
Json getMaterialField(const ObjectNow& object, Core&) {
  return number(object.spec.material.*kField);
}

Result<void> setMaterial(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto n = parseNumbers(value, 4, where);
  if (!n) return n.error();
  return core.scene().setMaterial(object.spec.name, {(*n)[0], (*n)[1], (*n)[2], (*n)[3]});
}

template <double SurfaceSpec::*kField>
Result<void> setSurfaceField(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto n = parseNumbers(value, 1, where);
  if (!n) return n.error();
  SurfaceSpec surface = object.spec.surface;
  surface.*kField = n->front();
  return core.scene().setSurface(object.spec.name, surface);
}

template <double SurfaceSpec::*kField>
Json getSurfaceField(const ObjectNow& object, Core&) {
  return number(object.spec.surface.*kField);
}

template <std::uint64_t SurfaceSpec::*kTexture>
Result<void> setSurfaceTexture(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto n = parseNumbers(value, 1, where);
  if (!n) return n.error();
  const double id = n->front();
  if (!(id >= 0 && id < 0x1p53 && id == std::floor(id))) {
    return Error{ErrorCode::kInvalidArgument, where, "it is not the number of a texture", "0 for none"};
  }
  SurfaceSpec surface = object.spec.surface;
  surface.*kTexture = static_cast<std::uint64_t>(id);
  return core.scene().setSurface(object.spec.name, surface);
}

template <std::uint64_t SurfaceSpec::*kTexture>
Json getSurfaceTexture(const ObjectNow& object, Core&) {
  return object.spec.surface.*kTexture;
}

template <bool ObjectSpec::*kFlag>
Json getFlag(const ObjectNow& object, Core&) {
  return object.spec.*kFlag;
}

template <bool ObjectSpec::*kFlag>
Result<void> setFlag(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto on = parseBool(value, where);
  if (!on) return on.error();
  ObjectSpec spec = object.spec;
  spec.*kFlag = *on;
  return core.scene().setFlags(spec.name, spec.enabled, spec.visible, spec.two_sided);
}

template <double BodySpec::*kField>
Result<void> setBodyField(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto n = parseNumbers(value, 1, where);
  if (!n) return n.error();
  BodySpec body = object.spec.body;
  body.*kField = n->front();
  return core.scene().setBody(object.spec.name, body);
}

Result<void> setFalls(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto on = parseBool(value, where);
  if (!on) return on.error();
  BodySpec body = object.spec.body;
  body.falls = *on;
  return core.scene().setBody(object.spec.name, body);
}

Json getShape(const ObjectNow& object, Core&) {
  const ShapeSpec& shape = object.spec.shape;
  Json json{{"kind", shapeName(shape.kind)}};
  switch (shape.kind) {
    case ShapeKind::kSphere:
      json["radius"] = shape.size.x();
      break;
    case ShapeKind::kBox:
      json["half_extents"] = toJson(shape.size);
      break;
    case ShapeKind::kCapsule:
    case ShapeKind::kCylinder:
      json["radius"] = shape.size.x();
      json["half_length"] = shape.size.y();
      break;
    case ShapeKind::kMesh:
      json["mesh"] = shape.mesh;
      break;
    default:
      break;
  }
  return json;
}

constexpr ObjectProperty kObjectProperties[] = {
    {"pos", "place of its origin in the parent [m]: x,y,z",
     [](const ObjectNow& o, Core&) { return toJson(o.spec.X_PO.p); }, setPos},
    {"rot", "rotation in the parent: w,x,y,z", [](const ObjectNow& o, Core&) { return toJson(o.spec.X_PO.q); }, setRot},
    {"pose", "pos and rot: x,y,z,w,x,y,z", [](const ObjectNow& o, Core&) { return toJson(o.spec.X_PO); }, setPose},
    {"worldpos", "place of its origin in the world [m]: x,y,z",
     [](const ObjectNow& o, Core&) { return toJson(o.X_WO.p); }, setWorldPos},
    {"worldpose", "pose in the world", [](const ObjectNow& o, Core&) { return toJson(o.X_WO); }, nullptr},
    {"velocity", "velocity in the parent [m/s]: x,y,z; it moves on by it",
     [](const ObjectNow& o, Core&) { return toJson(o.V_PO.v); }, setVelocity},
    {"stiffness", "[N/m]", getMaterialField<&hd_material::stiffness>, setMaterialField<&hd_material::stiffness>},
    {"damping", "[N s/m], in contact", getMaterialField<&hd_material::damping>,
     setMaterialField<&hd_material::damping>},
    {"friction_static", "mu_s", getMaterialField<&hd_material::friction_static>,
     setMaterialField<&hd_material::friction_static>},
    {"friction_dynamic", "mu_d, at most mu_s", getMaterialField<&hd_material::friction_dynamic>,
     setMaterialField<&hd_material::friction_dynamic>},
    {"material", "stiffness,damping,friction_static,friction_dynamic",
     [](const ObjectNow& o, Core&) { return toJson(o.spec.material); }, setMaterial},
    {"smooth_deg", "edges that bend less [degree] are shaded round", getSurfaceField<&SurfaceSpec::smooth_deg>,
     setSurfaceField<&SurfaceSpec::smooth_deg>},
    {"transient_gain", "force per speed of impact [N s/m]", getSurfaceField<&SurfaceSpec::transient_gain>,
     setSurfaceField<&SurfaceSpec::transient_gain>},
    {"transient_hz", "what an impact rings at", getSurfaceField<&SurfaceSpec::transient_hz>,
     setSurfaceField<&SurfaceSpec::transient_hz>},
    {"transient_decay_s", "until it has fallen to 1/e", getSurfaceField<&SurfaceSpec::transient_decay_s>,
     setSurfaceField<&SurfaceSpec::transient_decay_s>},
    {"relief", "number of a texture, 0 for none", getSurfaceTexture<&SurfaceSpec::relief>,
     setSurfaceTexture<&SurfaceSpec::relief>},
    {"relief_depth", "from white down to black [m]", getSurfaceField<&SurfaceSpec::relief_depth>,
     setSurfaceField<&SurfaceSpec::relief_depth>},
    {"relief_width", "of the picture [m]", getSurfaceField<&SurfaceSpec::relief_width>,
     setSurfaceField<&SurfaceSpec::relief_width>},
    {"relief_height", "of the picture [m]", getSurfaceField<&SurfaceSpec::relief_height>,
     setSurfaceField<&SurfaceSpec::relief_height>},
    {"vibration", "number of a texture, 0 for none", getSurfaceTexture<&SurfaceSpec::vibration>,
     setSurfaceTexture<&SurfaceSpec::vibration>},
    {"vibration_mass", "force per acceleration [kg]", getSurfaceField<&SurfaceSpec::vibration_mass>,
     setSurfaceField<&SurfaceSpec::vibration_mass>},
    {"mass", "[kg]; with one it moves freely and is pushed by tools and hands, 0: it stays where it is put",
     [](const ObjectNow& o, Core&) { return number(o.spec.body.mass); }, setBodyField<&BodySpec::mass>},
    {"motion_damping", "share of its motion that it loses when it moves freely [1/s]",
     [](const ObjectNow& o, Core&) { return number(o.spec.body.damping); }, setBodyField<&BodySpec::damping>},
    {"falls", "the world's gravity acts on it when it moves freely: true or false",
     [](const ObjectNow& o, Core&) { return Json(o.spec.body.falls); }, setFalls},
    {"enabled", "it can be touched: true or false", getFlag<&ObjectSpec::enabled>, setFlag<&ObjectSpec::enabled>},
    {"visible", "for viewers: true or false", getFlag<&ObjectSpec::visible>, setFlag<&ObjectSpec::visible>},
    {"twosided", "both faces of an open mesh stop the proxy: true or false", getFlag<&ObjectSpec::two_sided>,
     setFlag<&ObjectSpec::two_sided>},
    {"keep", "it stays when its maker leaves", getFlag<&ObjectSpec::keep>, nullptr},
    {"shape", "kind and sizes [m]", getShape, nullptr},
    {"parent", "name of the parent, empty for the root", [](const ObjectNow& o, Core&) { return Json(o.spec.parent); },
     nullptr},
    {"children", "names", [](const ObjectNow& o, Core& core) { return Json(core.scene().childrenOf(o.spec.name)); },
     nullptr},
    {"id", "for the rings", [](const ObjectNow& o, Core&) { return Json(o.id); }, nullptr},
    {"path", "in the tree", [](const ObjectNow& o, Core&) { return Json(o.path); }, nullptr},
    {"owner", "client that made it", [](const ObjectNow& o, Core&) { return Json(o.owner); }, nullptr},
    {"triangles", "of its mesh", [](const ObjectNow& o, Core&) { return Json(o.triangles); }, nullptr},
};

}  // namespace

std::span<const ObjectProperty> objectProperties() { return kObjectProperties; }

}  // namespace hapticd
