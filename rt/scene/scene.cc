#include "rt/scene/scene.h"

#include <algorithm>
#include <tuple>

#include "rt/geometry/sweep/sweep.h"

namespace hapticd {
namespace {

bool isRotation(const Quat& q) HD_RT { return isFinite(q) && std::abs(q.squaredNorm() - 1.0) < 1e-3; }

bool isValid(const hd_material& m) HD_RT {
  const auto good = [](double x) { return std::isfinite(x) && x >= 0; };
  return good(m.stiffness) && good(m.damping) && good(m.friction_static) && good(m.friction_dynamic) &&
         m.friction_dynamic <= m.friction_static;
}

bool isValid(const SurfaceParameters& s) HD_RT {
  for (const double x :
       {s.smooth_cosine, s.transient_gain, s.relief_depth, s.relief_size[0], s.relief_size[1], s.vibration_mass}) {
    if (!std::isfinite(x) || x < 0) return false;
  }
  // A ringing that dies out: r^2 < 1 and |2 r cos(theta)| <= 2 r.
  const bool dies = s.transient_decay >= 0 && s.transient_decay < 1 &&
                    s.transient_turn * s.transient_turn <= 4 * s.transient_decay && std::abs(s.transient_first) <= 1;
  return dies && (s.relief == 0 || (s.relief_size[0] > 0 && s.relief_size[1] > 0));
}

bool isValid(const EffectParameters& e) HD_RT {
  if (e.kind > static_cast<std::uint32_t>(EffectKind::kGuide) || e.points > kMaxPathPoints || e.points == 1)
    return false;
  for (std::uint32_t i = 0; i < e.points; ++i) {
    for (const float x : e.path[i])
      if (!std::isfinite(x)) return false;
  }
  const auto good = [](double x) HD_RT { return x >= 0 && x < 1e6; };  // Sums and products stay finite.
  return good(e.force) && good(e.stiffness) && good(e.damping) && good(e.frequency) && good(e.reach) &&
         (e.reach > 0 || e.kind == static_cast<std::uint32_t>(EffectKind::kNone));
}

/** What is beyond the last point of its path says nothing. */
bool isSame(const EffectParameters& a, const EffectParameters& b) HD_RT {
  const auto all = [](const EffectParameters& e) HD_RT {
    return std::tie(e.kind, e.points, e.force, e.stiffness, e.damping, e.reach, e.frequency, e.until_ns);
  };
  const auto ends = [](const EffectParameters& e) HD_RT { return std::begin(e.path) + e.points; };
  const auto isOne = [](const auto& p, const auto& q) HD_RT { return std::equal(std::begin(p), std::end(p), q); };
  return all(a) == all(b) && std::equal(std::begin(a.path), ends(a), std::begin(b.path), isOne);
}

/** What such a command changes of an object; kParts: something that only control changes, or vertices. */
SceneObject::Part partOf(CommandKind kind) HD_RT {
  switch (kind) {
    case CommandKind::kObjectPose:
      return SceneObject::kPlace;
    case CommandKind::kObjectMaterial:
      return SceneObject::kMaterial;
    case CommandKind::kObjectFlags:
      return SceneObject::kFlags;
    default:
      return SceneObject::kParts;
  }
}

}  // namespace

void SceneObject::placeBall() HD_RT {
  const Ball ball = boundingBall(shape);
  center_W = toWorld(ball.center);
  radius = ball.radius;
}

const SceneObject* Scene::find(std::uint32_t id) const HD_RT {
  const std::uint32_t slot = objectSlot(id);
  return id != 0 && slot != 0 && slot < kMaxObjects && objects_[slot].id == id ? &objects_[slot] : nullptr;
}

Vec3 Scene::velocityAt(const SceneObject& object, std::uint32_t feature, const Vec3& x_W) const HD_RT {
  Vec3 v = object.velocityAt(x_W);
  if (object.shape.kind != ShapeKind::kMesh || object.shape.mesh->deform.motion == nullptr) return v;
  const Vec3 x = object.toLocal(x_W);
  return v + object.R_WO * deformingVelocity(*object.shape.mesh, feature, x, time_);
}

SceneObject* Scene::findMutable(std::uint32_t id) HD_RT { return const_cast<SceneObject*>(find(id)); }

ErrorCode Scene::apply(const Command& command) HD_RT {
  const ErrorCode code = change(command);
  const SceneObject::Part part = partOf(command.kind);
  if (code == ErrorCode::kOk && part != SceneObject::kParts && command.session != kControlSession) {
    SceneObject* const object = findMutable(command.as<ObjectRef>().object);  // Such commands start alike.
    if (object) ++object->client_edits[part];
  }
  if (code == ErrorCode::kOk && part == SceneObject::kPlace)
    motion_[objectSlot(command.as<hd_object_pose>().object)].mover = command.session;
  return code;
}

void Scene::halt(std::uint32_t session) HD_RT {
  for (std::uint32_t i = 0; i < order_count_; ++i) {
    SceneObject& object = objects_[order_[i]];
    if (motion_[order_[i]].mover != session || isZero(object.V_PO)) continue;
    halt(object);
    settled_ = false;
  }
}

void Scene::halt(SceneObject& object) HD_RT {
  object.V_PO = {};
  ++object.client_edits[SceneObject::kPlace];
}

std::uint32_t Scene::leaseOf(std::uint32_t id) const HD_RT {
  const double lease = find(id) == nullptr ? 0 : motion_[objectSlot(id)].lease;
  return lease > 0 ? std::max(1u, static_cast<std::uint32_t>(std::round(lease * 1e6))) : 0;
}

std::uint32_t Scene::moverOf(std::uint32_t id) const HD_RT {
  const SceneObject* const object = find(id);
  return object == nullptr || isZero(object->V_PO) ? kControlSession : motion_[objectSlot(id)].mover;
}

ErrorCode Scene::change(const Command& command) HD_RT {
  switch (command.kind) {
    case CommandKind::kAddObject:
      return add(command.as<AddObject>());
    case CommandKind::kRemoveObject:
      return remove(command.as<ObjectRef>().object);
    case CommandKind::kSetShape:
      return setShape(command.as<SetShape>());
    case CommandKind::kSetSurface:
      return setSurface(command.as<SetSurface>());
    case CommandKind::kSetEffect:
      return setEffect(command.as<SetEffect>());
    case CommandKind::kObjectPose:
      return setPose(command.as<hd_object_pose>());
    case CommandKind::kObjectMaterial:
      return setMaterial(command.as<hd_object_material>());
    case CommandKind::kObjectFlags:
      return setFlags(command.as<hd_object_flags>());
    case CommandKind::kObjectVertices:
      return moveVertices(command.as<hd_object_vertices>());
    default:
      return ErrorCode::kUnsupported;
  }
}

ErrorCode Scene::makeShape(const ShapeParameters& parameters, Shape& shape) const HD_RT {
  shape.kind = static_cast<ShapeKind>(parameters.kind);
  shape.size = vec3(parameters.size);
  shape.mesh = nullptr;
  static std::atomic<std::uint64_t> made{0};  // In all scenes: the meshes of one may stand where another's stood.
  shape.number = made.fetch_add(1, std::memory_order_relaxed) + 1;
  const auto positive = [&](int i) { return std::isfinite(shape.size[i]) && shape.size[i] > 0; };
  bool good = true;
  switch (shape.kind) {
    case ShapeKind::kGroup:
    case ShapeKind::kPlane:
      break;
    case ShapeKind::kSphere:
      good = positive(0);
      break;
    case ShapeKind::kBox:
      good = positive(0) && positive(1) && positive(2);
      break;
    case ShapeKind::kCapsule:
      good = positive(0) && std::isfinite(shape.size[1]) && shape.size[1] >= 0;
      break;
    case ShapeKind::kCylinder:
      good = positive(0) && positive(1);
      break;
    case ShapeKind::kMesh:
      shape.mesh = meshes_->get(parameters.mesh);
      shape.mesh_entry = parameters.mesh;
      if (!shape.mesh) return ErrorCode::kNotFound;
      break;
    default:
      good = false;
  }
  return good ? ErrorCode::kOk : ErrorCode::kInvalidArgument;
}

ErrorCode Scene::add(const AddObject& order) HD_RT {
  const std::uint32_t slot = objectSlot(order.object);
  const Quat q = quat(order.q);
  if (slot == 0 || slot >= kMaxObjects || !isRotation(q) || !isFinite(vec3(order.p)) || !isValid(order.material)) {
    return ErrorCode::kInvalidArgument;
  }
  if (objects_[slot].id != 0) return ErrorCode::kAlreadyExists;
  const SceneObject* parent = &objects_[0];
  if (order.parent != 0 && !(parent = find(order.parent))) return ErrorCode::kNotFound;
  SceneObject object;
  if (const ErrorCode code = makeShape(order.shape, object.shape); code != ErrorCode::kOk) return code;
  object.id = order.object;
  object.parent = static_cast<std::uint32_t>(parent - objects_.data());
  object.flags = order.flags;
  object.X_PO = {vec3(order.p), q.normalized()};
  object.place(parent->X_WO * object.X_PO);
  object.X_WO_before = object.X_WO;
  object.material = order.material;
  object.placeBall();
  objects_[slot] = object;
  motion_[slot] = Motion{};
  motion_[slot].X_PO_before = object.X_PO;
  motion_[slot].jump = true;
  motion_[slot].pose_time = time_ + dt_;                      // In the tick that comes.
  order_[order_count_++] = static_cast<std::uint16_t>(slot);  // The parent stands before it already.
  settled_ = false;
  rebuildTouchable();
  return ErrorCode::kOk;
}

ErrorCode Scene::remove(std::uint32_t id) HD_RT {
  SceneObject* object = findMutable(id);
  if (!object) return ErrorCode::kNotFound;
  const std::uint32_t slot = objectSlot(id);
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < order_count_; ++i) {
    if (objects_[order_[i]].parent == slot) return ErrorCode::kInvalidArgument;
  }
  for (std::uint32_t i = 0; i < order_count_; ++i) {
    if (order_[i] != slot) order_[kept++] = order_[i];
  }
  order_count_ = kept;
  (void)setEffect(SetEffect{id, 0, {}});
  *object = SceneObject{};
  rebuildTouchable();
  return ErrorCode::kOk;
}

ErrorCode Scene::setPose(const hd_object_pose& pose) HD_RT {
  SceneObject* object = findMutable(pose.object);
  if (!object) return ErrorCode::kNotFound;
  const Pose X{vec3(pose.p), quat(pose.q)};
  const Twist V{vec3(pose.v), vec3(pose.w)};
  if (!isFinite(X.p) || !isRotation(X.q) || !isFinite(V.v) || !isFinite(V.w)) return ErrorCode::kInvalidArgument;
  object->X_PO = {X.p, X.q.normalized()};
  object->V_PO = V;
  Motion& motion = motion_[objectSlot(pose.object)];
  motion.pose_set = true;
  motion.lease = pose.lease_us * 1e-6;
  settled_ = false;
  return ErrorCode::kOk;
}

ErrorCode Scene::setShape(const SetShape& order) HD_RT {
  SceneObject* object = findMutable(order.object);
  if (!object) return ErrorCode::kNotFound;
  Shape shape;
  if (const ErrorCode code = makeShape(order.shape, shape); code != ErrorCode::kOk) return code;
  object->shape = shape;
  object->placeBall();
  motion_[objectSlot(order.object)].reshaped = true;
  motion_[objectSlot(order.object)].unmet = time_;
  noteEffect(objectSlot(order.object));
  settled_ = false;
  rebuildTouchable();
  return ErrorCode::kOk;
}

ErrorCode Scene::setMaterial(const hd_object_material& order) HD_RT {
  SceneObject* object = findMutable(order.object);
  if (!object) return ErrorCode::kNotFound;
  if (!isValid(order.material)) return ErrorCode::kInvalidArgument;
  const bool before = isFelt(*object);
  object->material = order.material;
  noteFelt(objectSlot(order.object), before);
  return ErrorCode::kOk;
}

ErrorCode Scene::setSurface(const SetSurface& order) HD_RT {
  SceneObject* object = findMutable(order.object);
  if (!object) return ErrorCode::kNotFound;
  Surface surface;
  surface.parameters = order.surface;
  if (!isValid(surface.parameters)) return ErrorCode::kInvalidArgument;
  if (order.surface.relief != 0) {
    const TextureView* texture = meshes_->texture(order.surface.relief - 1);
    if (!texture || !texture->relief.pixel) return ErrorCode::kNotFound;
    surface.relief = &texture->relief;
  }
  if (order.surface.vibration != 0) {
    const TextureView* texture = meshes_->texture(order.surface.vibration - 1);
    if (!texture || !texture->vibration.model) return ErrorCode::kNotFound;
    surface.vibration = &texture->vibration;
  }
  surface.changes = object->surface.changes + 1;
  object->surface = surface;
  return ErrorCode::kOk;
}

ErrorCode Scene::setFlags(const hd_object_flags& order) HD_RT {
  SceneObject* object = findMutable(order.object);
  if (!object) return ErrorCode::kNotFound;
  const bool before = isFelt(*object);
  const std::uint32_t flags = (object->flags & ~order.mask) | (order.value & order.mask);
  if (order.mask == kObjectInHand) {  // Nobody feels that.
    object->flags = flags;
    return ErrorCode::kOk;
  }
  if (flags != object->flags) noteEffect(objectSlot(order.object));
  object->flags = flags;
  noteFelt(objectSlot(order.object), before);
  settled_ = false;
  rebuildTouchable();
  return ErrorCode::kOk;
}

void Scene::noteFelt(std::uint32_t slot, bool before) HD_RT {
  if (!before && isFelt(objects_[slot])) motion_[slot].unmet = time_;
}

ErrorCode Scene::setEffect(const SetEffect& order) HD_RT {
  if (find(order.object) == nullptr) return ErrorCode::kNotFound;
  if (!isValid(order.effect)) return ErrorCode::kInvalidArgument;
  const auto slot = static_cast<std::uint16_t>(objectSlot(order.object));
  const auto none = static_cast<std::uint32_t>(EffectKind::kNone);
  const bool was = effects_[slot].kind != none, is = order.effect.kind != none;
  if (is && !was) {
    if (effecting_count_ == kMaxEffects) return ErrorCode::kQuotaExceeded;
    effecting_[effecting_count_++] = slot;
  }
  if (was && !is) {
    effecting_count_ = static_cast<std::uint32_t>(
        std::remove(effecting_.begin(), effecting_.begin() + effecting_count_, slot) - effecting_.begin());
  }
  if (isSame(effects_[slot], order.effect)) return ErrorCode::kOk;
  noteEffect(slot);
  effects_[slot] = order.effect;
  noteEffect(slot);
  return ErrorCode::kOk;
}

void Scene::rebuildTouchable() HD_RT {
  ++arrivals_;
  touchable_count_ = 0;
  for (std::uint32_t slot = 1; slot < kMaxObjects; ++slot) {
    const SceneObject& object = objects_[slot];
    if (object.id == 0 || !(object.flags & HD_OBJECT_ENABLED) || object.shape.kind == ShapeKind::kGroup) continue;
    touchable_[touchable_count_++] = static_cast<std::uint16_t>(slot);
  }
}

}  // namespace hapticd
