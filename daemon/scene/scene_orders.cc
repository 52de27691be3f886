// What the scene model tells the servos: each edit as an order, and all of it to a servo that comes later. The edits
// are in scene_model.cc.
#include <algorithm>
#include <utility>

#include "daemon/scene/body.h"
#include "daemon/scene/scene_model.h"
#include "rt/cycle/restated.h"

namespace hapticd {
namespace {

ShapeParameters parameters(const ShapeSpec& shape, const MeshStore& meshes) {
  ShapeParameters out{};
  out.kind = static_cast<std::uint32_t>(shape.kind);
  out.mesh = shape.kind == ShapeKind::kMesh ? meshes.entryOf(shape.mesh) : 0;
  store(shape.size, out.size);
  return out;
}

template <class Visit, std::size_t... kNumbers>
void visitKinds(Visit&& visit, std::index_sequence<kNumbers...>) {
  // The highest number first: a body is told its velocity when it is one.
  (visit(std::integral_constant<CommandKind, static_cast<CommandKind>(kMostKinds - 1 - kNumbers)>()), ...);
}

}  // namespace

void SceneModel::attach(CommandSink& sink) {
  const auto free = std::find(sinks_.begin(), sinks_.end(), nullptr);
  if (free == sinks_.end()) return;
  if (!gravity_.isZero(0)) (void)sink.post(gravityCommand());
  const auto index = static_cast<std::size_t>(free - sinks_.begin());
  replay(sink,
         [&](Object& object, const Command& command) { object.known[index].fill({.ticket = sink.post(command)}); });
  *free = &sink;                   // Only now: what clients changed meanwhile would go to it before the object itself.
  for (Object& object : slots_) {  // What moves in another servo has gone on when this one takes the orders.
    if (object.placed_in != nullptr && !isZero(object.V_PO)) object.known[index][SceneObject::kPlace].behind = true;
  }
}

std::vector<Command> SceneModel::orders(const CommandSink& sink) {
  std::vector<Command> all;
  if (!gravity_.isZero(0)) all.push_back(gravityCommand());
  replay(sink, [&](Object&, const Command& command) { all.push_back(command); });
  return all;
}

void SceneModel::replay(const CommandSink& sink, const std::function<void(Object&, const Command&)>& give) {
  std::vector<std::uint32_t> open = childSlots(0);
  for (std::size_t i = 0; i < open.size(); ++i) {
    Object& object = slots_[open[i]];
    refresh(object, &sink);
    give(object, addCommand(object));
    const auto giveLasting = [&](auto kind) {
      constexpr CommandKind kKind = kind;
      if constexpr (whoRestates(kKind) == Restated::kSceneOrder) {
        if constexpr (kKind == CommandKind::kSetSurface) {
          if (object.spec.surface != SurfaceSpec{}) give(object, surfaceCommand(object, sink.periodNs()));
        } else if constexpr (kKind == CommandKind::kSetBody) {
          if (object.spec.body.mass > 0) give(object, bodyCommand(object));
        } else if constexpr (kKind == CommandKind::kSetEffect) {
          if (object.spec.effect.kind != EffectKind::kNone) give(object, effectCommand(object));
        } else if constexpr (kKind == CommandKind::kObjectPose) {
          if (!object.V_PO.v.isZero() || !object.V_PO.w.isZero()) give(object, poseCommand(object));
        } else {
          static_assert(kKind == CommandKind::kNone, "a servo that comes later must be told of this order too");
        }
      }
    };
    visitKinds(giveLasting, std::make_index_sequence<kMostKinds>());
    for (const std::uint32_t child : childSlots(open[i])) open.push_back(child);
  }
}

void SceneModel::detach(CommandSink& sink) {
  std::replace(sinks_.begin(), sinks_.end(), &sink, static_cast<CommandSink*>(nullptr));
  for (Object& object : slots_) {
    if (object.placed_in == &sink) object.placed_in = nullptr;
    if (object.teller == &sink) object.teller = nullptr;
  }
}

Result<void> SceneModel::accepting() const {
  for (const CommandSink* sink : sinks_) {
    if (sink != nullptr && !sink->accepting()) {
      return Error{ErrorCode::kWouldBlock, "scene", "too many edits wait for a servo",
                   "edit less often; if it stays so, see hapticctl status"};
    }
  }
  return {};
}

void SceneModel::post(Object& object, const Command& command) {
  const bool made = command.kind == CommandKind::kAddObject;
  for (std::size_t i = 0; i < sinks_.size(); ++i) {
    if (sinks_[i] == nullptr) continue;
    const std::uint64_t ticket = sinks_[i]->post(command);
    if (made) object.known[i].fill({.ticket = ticket});
  }
}

/** Where what flew stops each servo would say otherwise: until its teller has, nobody is told that it flies on. */
void SceneModel::postBody(Object& object, bool was_body) {
  post(object, bodyCommand(object));
  object.settles = was_body && object.spec.body.mass == 0 && !object.in_hand;
  if (!object.settles) return;
  object.V_PO = {};
  for (std::size_t i = 0; i < sinks_.size(); ++i) {
    Known& known = object.known[i][SceneObject::kPlace];
    if (sinks_[i] != nullptr) known.ticket = sinks_[i]->posted();
    known.behind = false;
    known.crossed = true;
  }
}

void SceneModel::setInHand(std::uint32_t id, bool in_hand) {
  Object& object = slots_[objectSlot(id)];
  if (id == 0 || object.id != id || object.in_hand == in_hand) return;
  object.in_hand = in_hand;
  post(object,
       makeCommand(CommandKind::kObjectFlags, hd_object_flags{id, kObjectInHand, in_hand ? kObjectInHand : 0, 0}));
}

void SceneModel::postSurface(const Object& object) {
  for (CommandSink* const sink : sinks_) {
    if (sink != nullptr) (void)sink->post(surfaceCommand(object, sink->periodNs()));
  }
}

Command SceneModel::surfaceCommand(const Object& object, std::int64_t period_ns) const {
  return makeCommand(CommandKind::kSetSurface,
                     SetSurface{object.id, 0, surfaceParameters(object.spec.surface, textures_, period_ns)});
}

Command SceneModel::bodyCommand(const Object& object) const {
  const BodySpec& body = object.spec.body;
  SetBody order{};
  order.object = object.id;
  order.falls = body.falls ? 1 : 0;
  order.damping = body.damping;
  if (body.mass > 0) {
    const MassProperties mass = massOf(object.spec.shape, meshes_, body.mass);
    order.mass = mass.mass;
    store(mass.com_O, order.com);
    storeInertia(mass.inertia_O, order.inertia);
  }
  return makeCommand(CommandKind::kSetBody, order);
}

Command SceneModel::effectCommand(const Object& object) {
  return makeCommand(CommandKind::kSetEffect,
                     SetEffect{object.id, 0, effectParameters(object.spec.effect, object.effect_until_ns)});
}

Command SceneModel::gravityCommand() const {
  SetGravity order{};
  store(gravity_, order.g);
  return makeCommand(CommandKind::kSetGravity, order);
}

Command SceneModel::shapeCommand(const Object& object) const {
  return makeCommand(CommandKind::kSetShape, SetShape{object.id, 0, parameters(object.spec.shape, meshes_)});
}

Command SceneModel::addCommand(const Object& object) const {
  AddObject add{};
  add.object = object.id;
  add.parent = slots_[object.parent_slot].id;
  add.flags = objectFlags(object.spec) | (object.in_hand ? kObjectInHand : 0);
  add.shape = parameters(object.spec.shape, meshes_);
  add.material = object.spec.material;
  store(object.spec.X_PO.p, add.p);
  store(object.spec.X_PO.q, add.q);
  return makeCommand(CommandKind::kAddObject, add);
}

Command SceneModel::poseCommand(const Object& object) {
  return makeCommand(CommandKind::kObjectPose, poseMessage(object.id, object.spec.X_PO, object.V_PO));
}

Command SceneModel::materialCommand(const Object& object) {
  return makeCommand(CommandKind::kObjectMaterial, hd_object_material{object.id, 0, object.spec.material});
}

Command SceneModel::flagsCommand(const Object& object) {
  constexpr std::uint32_t kAll = HD_OBJECT_ENABLED | HD_OBJECT_VISIBLE | HD_OBJECT_TWO_SIDED;
  return makeCommand(CommandKind::kObjectFlags, hd_object_flags{object.id, kAll, objectFlags(object.spec), 0});
}

}  // namespace hapticd
