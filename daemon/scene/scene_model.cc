#include "daemon/scene/scene_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/log/log.h"
#include "daemon/scene/body.h"
#include "rt/collide/scene_contacts.h"
#include "rt/cycle/free_bodies.h"
#include "rt/ingest/limits.h"

namespace hapticd {
namespace {

bool mayRemove(const Client& owner, const Client& by) { return by.administration || owner.uid == by.uid; }

}  // namespace

Result<std::uint32_t> SceneModel::create(ObjectSpec spec, const Client& by) {
  if (auto r = checkName(spec.name, "object.name"); !r) return r.error();
  if (has(spec.name)) {
    return Error{ErrorCode::kAlreadyExists, "object.name", fmt::format("there is an object '{}' already", spec.name),
                 "choose another name, or change that object"};
  }
  std::uint32_t parent = 0;
  if (!spec.parent.empty()) {
    const auto it = by_name_.find(spec.parent);
    if (it == by_name_.end()) return notFound(spec.parent, "object.parent");
    parent = it->second;
  }
  if (auto r = checkPose(spec.X_PO, "object.pose"); !r) return r.error();
  if (auto r = checkMaterial(spec.material, "object.material"); !r) return r.error();
  if (auto r = checkShapeMesh(spec.shape, "object.shape"); !r) return r.error();
  if (auto r = checkSurface(spec.surface, textures_, "object.surface"); !r) return r.error();
  if (countOf(by.uid) >= quota_) {
    return Error{
        ErrorCode::kQuotaExceeded, "object",
        fmt::format("user {} owns {} object{}, the most allowed", by.uid, quota_, quota_ == 1 ? "" : "s"),
        quota_ < kMaxObjects - 1 ? "remove some, or raise quotas.objects in the configuration" : "remove some"};
  }
  if (auto r = accepting(); !r) return r.error();
  const std::uint32_t slot = free_.first();
  if (slot == 0) {
    return Error{ErrorCode::kQuotaExceeded, "object",
                 fmt::format("the scene holds {} objects, its most", kMaxObjects - 1), "remove some"};
  }
  Client owner = by;
  by_name_.emplace(spec.name, slot);  // The last that may fail for want of memory.
  takeFreeSlot();
  Object& object = slots_[slot];
  object = {};
  object.spec = std::move(spec);
  object.owner = std::move(owner);
  object.id = makeObjectId(slot, generation_[slot]);
  object.parent_slot = parent;
  if (object.spec.shape.kind == ShapeKind::kMesh) meshes_.use(object.spec.shape.mesh);
  textures_.use(object.spec.surface.relief);
  textures_.use(object.spec.surface.vibration);
  post(object, addCommand(object));
  if (object.spec.surface != SurfaceSpec{}) postSurface(object);
  changed(object.spec.name, "created");
  return object.id;
}

Result<void> SceneModel::remove(std::string_view name, const Client& by) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  const std::vector<std::uint32_t> subtree = subtreeOf(objectSlot(object->id));
  for (const std::uint32_t slot : subtree) {
    const Object& o = slots_[slot];
    if (!mayRemove(o.owner, by)) {
      const std::string maker = o.owner.name.empty() ? std::string() : fmt::format("'{}' of ", o.owner.name);  // Left.
      return Error{ErrorCode::kPermissionDenied, "name",
                   fmt::format("'{}' belongs to {}user {}", o.spec.name, maker, o.owner.uid),
                   "ask that user, or use the administration socket"};
    }
  }
  if (auto r = accepting(); !r) return r;
  removeAll(subtree);
  return {};
}

Result<void> SceneModel::setPose(std::string_view name, Pose X_PO) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  if (auto r = checkPose(X_PO, "pose"); !r) return r;
  if (auto r = accepting(); !r) return r;
  refresh(*object);
  object->spec.X_PO = X_PO;
  object->V_PO = {};
  postPart(*object, SceneObject::kPlace);
  changed(object->spec.name, "pose");
  return {};
}

Result<void> SceneModel::setVelocity(std::string_view name, const Twist& V_PO) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  const auto within = [](const Vec3& x, double most) { return isFinite(x) && x.cwiseAbs().maxCoeff() <= most; };
  if (!within(V_PO.v, limits::kSpeed) || !within(V_PO.w, limits::kAngularSpeed)) {
    return Error{ErrorCode::kInvalidArgument, "velocity",
                 fmt::format("it is not finite or beyond {} m/s or {} rad/s", limits::kSpeed, limits::kAngularSpeed),
                 "for example 0.05,0,0"};
  }
  if (auto r = accepting(); !r) return r;
  refresh(*object);
  moveOn(*object);
  object->V_PO = V_PO;
  postPart(*object, SceneObject::kPlace);
  changed(object->spec.name, "velocity");
  return {};
}

Result<void> SceneModel::setMaterial(std::string_view name, const hd_material& material) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  if (auto r = checkMaterial(material, "material"); !r) return r;
  if (auto r = accepting(); !r) return r;
  refresh(*object);
  object->spec.material = material;
  postPart(*object, SceneObject::kMaterial);
  changed(object->spec.name, "material");
  return {};
}

Result<void> SceneModel::setSurface(std::string_view name, const SurfaceSpec& surface) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  if (auto r = checkSurface(surface, textures_, "surface"); !r) return r;
  if (auto r = accepting(); !r) return r;
  refresh(*object);
  const SurfaceSpec before = object->spec.surface;
  textures_.use(surface.relief);
  textures_.use(surface.vibration);
  object->spec.surface = surface;
  postSurface(*object);
  textures_.release(before.relief);
  textures_.release(before.vibration);
  changed(object->spec.name, "surface");
  return {};
}

Result<void> SceneModel::setBody(std::string_view name, const BodySpec& body) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  if (auto r = checkBody(body, "body"); !r) return r;
  if (body.mass > 0) {
    if (auto r = checkMovable(describe(objectSlot(object->id)).spec, meshes_, "body"); !r) return r;
    const auto moves = [](const Object& o) { return o.id != 0 && o.spec.body.mass > 0; };
    const auto others = std::count_if(slots_.begin(), slots_.end(), moves) - (moves(*object) ? 1 : 0);
    if (others >= kMaxBodies) {
      return Error{ErrorCode::kQuotaExceeded, "body.mass",
                   fmt::format("{} objects move freely, the most that a servo can keep up with", others),
                   "set the mass of another to 0"};
    }
  }
  if (auto r = accepting(); !r) return r;
  refresh(*object);
  const bool was_body = object->spec.body.mass > 0;
  object->spec.body = body;
  postBody(*object, was_body);
  const std::string note =
      body.mass > 0 ? withoutField(object->spec.name, object->spec.shape, meshes_, SceneContacts::kBodyPatches)
                    : std::string();
  if (!note.empty()) log::info("{}", log::printable(note));
  changed(object->spec.name, note.empty() ? "body" : ("body; " + note).c_str());
  return {};
}

Result<void> SceneModel::setEffect(std::string_view name, const EffectSpec& effect, std::int64_t now_ns) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  if (auto r = checkEffect(effect, "effect"); !r) return r;
  Object* ended = nullptr;
  if (effect.kind != EffectKind::kNone && object->spec.effect.kind == EffectKind::kNone) {
    const auto has = [](const Object& o) { return o.id != 0 && o.spec.effect.kind != EffectKind::kNone; };
    const auto others = std::count_if(slots_.begin(), slots_.end(), has);
    if (others >= kMaxEffects) {
      const auto over = [&](const Object& o) { return has(o) && o.effect_until_ns != 0 && o.effect_until_ns < now_ns; };
      const auto found = std::find_if(slots_.begin(), slots_.end(), over);
      if (found == slots_.end()) {
        return Error{ErrorCode::kQuotaExceeded, "effect",
                     fmt::format("{} objects have an effect, the most that a servo can keep up with", others),
                     "set that of another to none"};
      }
      ended = &*found;
    }
  }
  if (auto r = accepting(); !r) return r;
  if (ended != nullptr) {  // Its place is another's now.
    refresh(*ended);
    ended->spec.effect.kind = EffectKind::kNone;
    post(*ended, effectCommand(*ended));
    changed(ended->spec.name, "effect");
  }
  refresh(*object);
  object->spec.effect = effect;
  object->effect_until_ns = effect.duration_s > 0 ? now_ns + static_cast<std::int64_t>(effect.duration_s * 1e9) : 0;
  post(*object, effectCommand(*object));
  changed(object->spec.name, "effect");
  return {};
}

Result<void> SceneModel::setGravity(const Vec3& gravity) {
  if (!isFinite(gravity) || gravity.norm() > FreeBodies::kMostGravity) {
    return Error{ErrorCode::kInvalidArgument, "gravity",
                 fmt::format("it is not finite or beyond {} m/s^2", FreeBodies::kMostGravity), "for example 0,0,-9.81"};
  }
  if (auto r = accepting(); !r) return r;
  gravity_ = gravity;
  for (CommandSink* sink : sinks_) {
    if (sink != nullptr) (void)sink->post(gravityCommand());
  }
  return {};
}

Result<void> SceneModel::setFlags(std::string_view name, const ObjectFlags& flags) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  if (auto r = accepting(); !r) return r;
  refresh(*object);
  object->spec.flags = flags;
  postPart(*object, SceneObject::kFlags);
  changed(object->spec.name, "flags");
  return {};
}

Result<void> SceneModel::setShape(std::string_view name, const ShapeSpec& shape) {
  Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  if (auto r = checkShapeMesh(shape, "shape"); !r) return r;
  if (auto r = accepting(); !r) return r;
  refresh(*object);
  const ShapeSpec before = object->spec.shape;
  if (shape.kind == ShapeKind::kMesh) meshes_.use(shape.mesh);
  object->spec.shape = shape;
  post(*object, shapeCommand(*object));
  if (object->spec.body.mass > 0) {
    // Its mass is spread over the new shape; an infinite shape (a plane) can have none and no longer moves.
    if (!checkMovable(describe(objectSlot(object->id)).spec, meshes_, "shape")) object->spec.body.mass = 0;
    postBody(*object, true);
  }
  if (before.kind == ShapeKind::kMesh) meshes_.release(before.mesh);
  changed(object->spec.name, "shape");
  return {};
}

void SceneModel::clientLeft(std::uint64_t connection) {
  // An object that carries another client's stays and becomes that client's. Parents first: it shows only from there.
  const auto foreign = [&](std::uint32_t root) -> const Object* {
    std::vector<std::uint32_t> open = childSlots(root);
    for (std::size_t i = 0; i < open.size(); ++i) {
      const Object& o = slots_[open[i]];
      if (o.owner.connection != connection || o.spec.keep) return &o;
      for (const std::uint32_t child : childSlots(open[i])) open.push_back(child);
    }
    return nullptr;
  };
  for (std::uint32_t slot = 1; slot < kMaxObjects; ++slot) {
    Object& object = slots_[slot];
    if (object.id == 0 || object.owner.connection != connection) continue;
    const Object* const heir = object.spec.keep ? &object : foreign(slot);
    if (heir == nullptr) {
      removeAll(subtreeOf(slot));
      continue;
    }
    Client owner = heir->owner;  // Whole or not: there may be no memory, and this is done again.
    object.owner = std::move(owner);
    object.spec.keep = heir->spec.keep;
    if (object.owner.connection == connection) {  // Kept: by nobody who is there.
      object.owner.connection = 0;
      object.owner.name.clear();
    }
  }
}

Result<void> SceneModel::checkShapeMesh(const ShapeSpec& shape, const std::string& where) const {
  if (auto r = checkShape(shape, where); !r) return r;
  if (shape.kind != ShapeKind::kMesh || meshes_.find(shape.mesh) != nullptr) return {};
  return Error{ErrorCode::kNotFound, where + ".mesh", fmt::format("there is no mesh {}", shape.mesh),
               "upload it first"};
}

std::vector<std::uint32_t> SceneModel::subtreeOf(std::uint32_t slot) const {
  std::vector<std::uint32_t> subtree{slot};
  for (std::size_t i = 0; i < subtree.size(); ++i) {
    for (const std::uint32_t child : childSlots(subtree[i])) subtree.push_back(child);
  }
  return subtree;
}

/** What is below goes first. */
void SceneModel::removeAll(const std::vector<std::uint32_t>& subtree) {
  for (auto slot = subtree.rbegin(); slot != subtree.rend(); ++slot) removeOne(*slot);
}

void SceneModel::removeOne(std::uint32_t slot) {
  Object& object = slots_[slot];
  post(object, makeCommand(CommandKind::kRemoveObject, ObjectRef{object.id}));
  if (object.spec.shape.kind == ShapeKind::kMesh) meshes_.release(object.spec.shape.mesh);
  textures_.release(object.spec.surface.relief);
  textures_.release(object.spec.surface.vibration);
  const std::string name = std::move(object.spec.name);
  by_name_.erase(name);
  Gone& gone = gone_[slot] = {object.id, {}};
  name.copy(gone.name.data(), gone.name.size() - 1);
  object = {};
  free_.giveBack(slot);
  changed(name, "removed");
}

void SceneModel::takeFreeSlot() noexcept {
  const std::uint32_t slot = free_.first();
  free_.takeFirst();
  if (++generation_[slot] == 0) generation_[slot] = 1;
}

}  // namespace hapticd
