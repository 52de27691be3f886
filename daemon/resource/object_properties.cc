#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "daemon/resource/properties.h"
#include "daemon/resource/resource_name.h"
#include "drivers/number.h"

namespace hapticd {
namespace {

constexpr const char* kPlace = "x,y,z in metres: 0,0,0.02";

/** Who gives others is told `how` they are written. */
Result<std::vector<double>> numbersOf(std::string_view value, std::size_t count, const std::string& where,
                                      const char* how) {
  auto n = parseNumbers(value, count, where);
  if (!n) return Error{n.error().code, where, n.error().what, how};
  return n;
}

Result<Pose> parsePose(std::string_view value, const std::string& where) {
  auto n = numbersOf(value, 7, where, "x,y,z in metres, then w,x,y,z of a quaternion: 0,0,0.02,1,0,0,0");
  if (!n) return n.error();
  return Pose{{(*n)[0], (*n)[1], (*n)[2]}, Quat((*n)[3], (*n)[4], (*n)[5], (*n)[6])};
}

Result<Vec3> parseVec3(std::string_view value, const std::string& where, const char* how) {
  auto n = numbersOf(value, 3, where, how);
  if (!n) return n.error();
  return Vec3((*n)[0], (*n)[1], (*n)[2]);
}

Result<void> setPos(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto p = parseVec3(value, where, kPlace);
  if (!p) return p.error();
  return core.setPose(object.spec.name, {*p, object.spec.X_PO.q});
}

Result<void> setRot(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto n = numbersOf(value, 4, where, "w,x,y,z of a quaternion: 0.966,0,0,0.259 turns by 30 degrees about z");
  if (!n) return n.error();
  return core.setPose(object.spec.name, {object.spec.X_PO.p, Quat((*n)[0], (*n)[1], (*n)[2], (*n)[3])});
}

Result<void> setPose(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto pose = parsePose(value, where);
  if (!pose) return pose.error();
  return core.setPose(object.spec.name, *pose);
}

Result<void> setWorldPos(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto p = parseVec3(value, where, kPlace);
  if (!p) return p.error();
  const Pose X_PW = core.scene().worldPose(object.spec.parent).inverse();
  return core.setPose(object.spec.name, {X_PW * *p, object.spec.X_PO.q});
}

Result<void> setVelocity(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto v = parseVec3(value, where, "x,y,z in metres a second: 0.05,0,0");
  if (!v) return v.error();
  return core.setVelocity(object.spec.name, {*v, object.V_PO.w});
}

Result<void> setMaterial(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto n = numbersOf(value, 4, where, "N/m, N s/m, static and dynamic friction: 800,1,0.4,0.3");
  if (!n) return n.error();
  return core.scene().setMaterial(object.spec.name, {(*n)[0], (*n)[1], (*n)[2], (*n)[3]});
}

Result<void> change(Core& core, const ObjectNow& object, const hd_material& material) {
  return core.scene().setMaterial(object.spec.name, material);
}
Result<void> change(Core& core, const ObjectNow& object, const SurfaceSpec& surface) {
  return core.scene().setSurface(object.spec.name, surface);
}
Result<void> change(Core& core, const ObjectNow& object, const BodySpec& body) {
  return core.scene().setBody(object.spec.name, body);
}
Result<void> change(Core& core, const ObjectNow& object, const EffectSpec& effect) {
  return core.scene().setEffect(object.spec.name, effect, core.now());
}

/** One number of the object's material, surface, body or effect. */
template <auto kPart, auto kField>
constexpr ObjectProperty numberOf(const char* name, const char* doc) {
  return {name, doc, [](const ObjectNow& o, Core&) { return number(o.spec.*kPart.*kField); },
          [](Core& core, const ObjectNow& object, std::string_view value, const std::string& where) -> Result<void> {
            auto n = parseNumbers(value, 1, where);
            if (!n) return n.error();
            auto part = object.spec.*kPart;
            part.*kField = n->front();
            return change(core, object, part);
          }};
}

template <auto kTexture>
constexpr ObjectProperty textureOf(const char* name) {
  return {
      name, "number of a texture, 0 for none", [](const ObjectNow& o, Core&) { return Json(o.spec.surface.*kTexture); },
      [](Core& core, const ObjectNow& object, std::string_view value, const std::string& where) -> Result<void> {
        constexpr const char* kHow = "a number that /textures has, 0 for none; hapticctl load-texture lays a file on";
        auto n = numbersOf(value, 1, where, kHow);
        if (!n) return n.error();
        const double id = n->front();
        if (!(id >= 0 && id < 0x1p53 && id == std::floor(id)))
          return Error{ErrorCode::kInvalidArgument, where, "it is not the number of a texture", kHow};
        SurfaceSpec surface = object.spec.surface;
        surface.*kTexture = static_cast<std::uint64_t>(id);
        return change(core, object, surface);
      }};
}

template <auto kFlag>
constexpr ObjectProperty flagOf(const char* name, const char* doc) {
  return {name, doc, [](const ObjectNow& o, Core&) { return Json(o.spec.flags.*kFlag); },
          [](Core& core, const ObjectNow& object, std::string_view value, const std::string& where) -> Result<void> {
            auto on = parseBool(value, where);
            if (!on) return on.error();
            ObjectFlags flags = object.spec.flags;
            flags.*kFlag = *on;
            return core.scene().setFlags(object.spec.name, flags);
          }};
}

Result<void> setFalls(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto on = parseBool(value, where);
  if (!on) return on.error();
  BodySpec body = object.spec.body;
  body.falls = *on;
  return change(core, object, body);
}

Json getPath(const ObjectNow& object, Core&) {
  Json points = Json::array();
  for (const Vec3& point : object.spec.effect.path) points.push_back(toJson(point));
  return points;
}

/** "" or "none": no points. */
Result<std::vector<Vec3>> parsePath(std::string_view value, const std::string& where) {
  std::vector<Vec3> path;
  if (value.empty() || value == "none") return path;
  const auto numbers = static_cast<std::size_t>(std::count(value.begin(), value.end(), ',')) + 1;
  if (numbers % 3 != 0 || numbers > std::size_t{3} * kMaxPathPoints) {
    return Error{ErrorCode::kInvalidArgument, where,
                 fmt::format("{} number{} not three for each of 2 to {} points", numbers,
                             numbers == 1 ? " is" : "s are", kMaxPathPoints),
                 "x,y,z of one after the other [m]; none takes the path away"};
  }
  auto n = parseNumbers(value, numbers, where);
  if (!n) return n.error();
  for (std::size_t i = 0; i < numbers; i += 3) path.emplace_back((*n)[i], (*n)[i + 1], (*n)[i + 2]);
  return path;
}

Result<void> setPath(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  auto path = parsePath(value, where);
  if (!path) return path.error();
  EffectSpec effect = object.spec.effect;
  effect.path = std::move(*path);
  return change(core, object, effect);
}

/** KIND, then FIELD=NUMBER as far as wanted, and at the end path=X,Y,Z,...: all at once, or nothing. */
Result<void> setEffect(Core& core, const ObjectNow& object, std::string_view value, const std::string& where) {
  constexpr std::pair<std::string_view, double EffectSpec::*> kNumbers[] = {
      {"force", &EffectSpec::force},     {"stiffness", &EffectSpec::stiffness},
      {"damping", &EffectSpec::damping}, {"reach", &EffectSpec::reach},
      {"hz", &EffectSpec::hz},           {"duration_s", &EffectSpec::duration_s}};
  EffectSpec effect = object.spec.effect;
  std::string_view rest = trimmed(value);
  const auto next = [&] {
    const std::string_view word = rest.substr(0, rest.find(','));
    rest = trimmed(rest.substr(std::min(rest.size(), word.size() + 1)));
    return trimmed(word);
  };
  auto kind = parseEffect(next(), where);
  if (!kind) return kind.error();
  effect.kind = *kind;
  while (!rest.empty()) {
    if (rest.starts_with("path=")) {
      auto path = parsePath(rest.substr(5), where + ".path");
      if (!path) return path.error();
      effect.path = std::move(*path);
      break;
    }
    const std::string_view word = next(), field = word.substr(0, word.find('='));
    const auto known = std::ranges::find_if(kNumbers, [&](const auto& each) { return each.first == field; });
    if (known == std::end(kNumbers) || field.size() == word.size()) {
      return Error{ErrorCode::kInvalidArgument, where, fmt::format("'{}' is no field of an effect", word.substr(0, 40)),
                   "force=N, stiffness=N/m, damping=Ns/m, reach=m, hz=Hz, duration_s=s, and path=x,y,z,... last"};
    }
    auto n = parseNumbers(word.substr(field.size() + 1), 1, fmt::format("{}.{}", where, field));
    if (!n) return n.error();
    effect.*known->second = n->front();
  }
  return change(core, object, effect);
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
    numberOf<&ObjectSpec::material, &hd_material::stiffness>("stiffness", "[N/m]"),
    numberOf<&ObjectSpec::material, &hd_material::damping>("damping", "[N s/m], in contact"),
    numberOf<&ObjectSpec::material, &hd_material::friction_static>("friction_static", "mu_s"),
    numberOf<&ObjectSpec::material, &hd_material::friction_dynamic>("friction_dynamic", "mu_d, at most mu_s"),
    {"material", "stiffness,damping,friction_static,friction_dynamic",
     [](const ObjectNow& o, Core&) { return toJson(o.spec.material); }, setMaterial},
    numberOf<&ObjectSpec::surface, &SurfaceSpec::smooth_deg>("smooth_deg",
                                                             "edges that bend less [degree] are shaded round"),
    numberOf<&ObjectSpec::surface, &SurfaceSpec::transient_gain>("transient_gain", "force per speed of impact [N s/m]"),
    numberOf<&ObjectSpec::surface, &SurfaceSpec::transient_hz>("transient_hz", "what an impact rings at"),
    numberOf<&ObjectSpec::surface, &SurfaceSpec::transient_decay_s>("transient_decay_s", "until it has fallen to 1/e"),
    textureOf<&SurfaceSpec::relief>("relief"),
    numberOf<&ObjectSpec::surface, &SurfaceSpec::relief_depth>("relief_depth", "from white down to black [m]"),
    numberOf<&ObjectSpec::surface, &SurfaceSpec::relief_width>("relief_width", "of the picture [m]"),
    numberOf<&ObjectSpec::surface, &SurfaceSpec::relief_height>("relief_height", "of the picture [m]"),
    textureOf<&SurfaceSpec::vibration>("vibration"),
    numberOf<&ObjectSpec::surface, &SurfaceSpec::vibration_mass>("vibration_mass", "force per acceleration [kg]"),
    numberOf<&ObjectSpec::body, &BodySpec::mass>(
        "mass", "[kg]; with one it moves freely and is pushed by tools and hands, 0: it stays where it is put"),
    numberOf<&ObjectSpec::body, &BodySpec::damping>("motion_damping",
                                                    "share of its motion that it loses when it moves freely [1/s]"),
    {"falls", "the world's gravity acts on it when it moves freely: true or false",
     [](const ObjectNow& o, Core&) { return Json(o.spec.body.falls); }, setFalls},
    {"effect",
     "what it does to a hand in free space: none, force, viscous, friction, vibration or guide[,FIELD=NUMBER ...]",
     [](const ObjectNow& o, Core&) { return Json(effectName(o.spec.effect.kind)); }, setEffect},
    numberOf<&ObjectSpec::effect, &EffectSpec::force>("effect_force", "the most that its effect pushes [N]"),
    numberOf<&ObjectSpec::effect, &EffectSpec::stiffness>("effect_stiffness", "of a guide, of sticking friction [N/m]"),
    numberOf<&ObjectSpec::effect, &EffectSpec::damping>("effect_damping", "of viscous, of a guide across it [N s/m]"),
    numberOf<&ObjectSpec::effect, &EffectSpec::reach>("effect_reach", "distance to which its effect is felt [m]"),
    numberOf<&ObjectSpec::effect, &EffectSpec::hz>("effect_hz", "of a vibration"),
    numberOf<&ObjectSpec::effect, &EffectSpec::duration_s>(
        "effect_duration_s", "it ends so long after it was set or changed; 0: it does not end"),
    {"effect_path", "points of a smooth curve [m]: x,y,z,x,y,z,...; none: the object itself", getPath, setPath},
    flagOf<&ObjectFlags::enabled>("enabled", "it can be touched: true or false"),
    flagOf<&ObjectFlags::visible>("visible", "for viewers: true or false"),
    flagOf<&ObjectFlags::two_sided>("twosided", "both faces of an open mesh stop the proxy: true or false"),
    {"keep", "it stays when its maker leaves", [](const ObjectNow& o, Core&) { return Json(o.spec.keep); }, nullptr},
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
