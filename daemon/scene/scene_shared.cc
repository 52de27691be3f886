// What clients change through the rings of one servo is handed on to all others.
#include <algorithm>
#include <tuple>

#include "daemon/scene/scene_model.h"

namespace hapticd {
namespace {

auto asTuple(const hd_material& m) { return std::tie(m.stiffness, m.damping, m.friction_static, m.friction_dynamic); }

}  // namespace

void SceneModel::followClients() {
  for (const auto& [name, slot] : by_name_) follow(slots_[slot]);
}

/** Only what differs from what all were told: else who moves an object would put back, for the other servos, all else
 * that others change about it. */
void SceneModel::follow(Object& object) {
  constexpr std::array kAll{kPlace, kMaterial, kFlags};
  for (std::size_t i = 0; i < sinks_.size(); ++i) {
    PosedObject first, now;
    const auto has = [&](Part part) { return posed(object, i, part, first); };
    if (std::none_of(kAll.begin(), kAll.end(), has) || first.client_edits == object.client_edits[i]) continue;
    bool all = true;
    for (const Part part : kAll) {
      if (!posed(object, i, part, now)) {
        all = false;  // What we have said of it is on its way.
      } else if (const Shared shared = sharedOf(now); differ(shared, object.told, part)) {
        takeOver(shared, part, object);
        postPart(object, part, sinks_[i]);
      }
    }
    if (all) object.client_edits[i] = first.client_edits;
  }
}

void SceneModel::refresh(Object& object) {
  follow(object);
  for (const Part part : {kPlace, kMaterial, kFlags}) {
    PosedObject now;
    std::size_t i = 0;
    while (i < sinks_.size() && !posed(object, i, part, now)) ++i;
    if (i < sinks_.size()) takeOver(sharedOf(now), part, object);
  }
}

void SceneModel::madeAnew(const CommandSink& sink) {
  const auto i = std::find(sinks_.begin(), sinks_.end(), &sink) - sinks_.begin();
  if (static_cast<std::size_t>(i) == sinks_.size()) return;
  for (Object& object : slots_) object.client_edits[static_cast<std::size_t>(i)] = 0;
}

/** As it now is, to all servos but one. */
void SceneModel::postPart(Object& object, Part part, const CommandSink* but) {
  const Command command = part == kPlace      ? poseCommand(object)
                          : part == kMaterial ? materialCommand(object)
                                              : flagsCommand(object);
  if (part == kPlace) object.told.X_PO = object.spec.X_PO, object.told.V_PO = object.V_PO;
  if (part == kMaterial) object.told.material = object.spec.material;
  if (part == kFlags) object.told.flags = object.spec.flags;
  for (std::size_t i = 0; i < sinks_.size(); ++i) {
    if (sinks_[i] == nullptr || sinks_[i] == but || !sinks_[i]->accepting()) continue;
    object.edit[i][part] = sinks_[i]->post(command);
  }
}

bool SceneModel::posed(const Object& object, std::size_t sink, Part part, PosedObject& out) const {
  return sinks_[sink] != nullptr && sinks_[sink]->posed(objectSlot(object.id), object.edit[sink][part], out) &&
         out.object == object.id;
}

SceneModel::Shared SceneModel::sharedOf(const PosedObject& posed) {
  return {{vec3(posed.p_PO), quat(posed.q_PO)},
          {vec3(posed.v_PO), vec3(posed.w_PO)},
          posed.material,
          {.enabled = (posed.flags & HD_OBJECT_ENABLED) != 0,
           .visible = (posed.flags & HD_OBJECT_VISIBLE) != 0,
           .two_sided = (posed.flags & HD_OBJECT_TWO_SIDED) != 0}};
}

bool SceneModel::differ(const Shared& a, const Shared& b, Part part) {
  switch (part) {
    case kPlace:
      return a.X_PO.p != b.X_PO.p || a.X_PO.q.coeffs() != b.X_PO.q.coeffs() || a.V_PO.v != b.V_PO.v ||
             a.V_PO.w != b.V_PO.w;
    case kMaterial:
      return asTuple(a.material) != asTuple(b.material);
    default:
      return a.flags != b.flags;
  }
}

void SceneModel::takeOver(const Shared& now, Part part, Object& object) {
  if (part == kPlace) object.spec.X_PO = now.X_PO, object.V_PO = now.V_PO;
  if (part == kMaterial) object.spec.material = now.material;
  if (part == kFlags) object.spec.flags = now.flags;
}

}  // namespace hapticd
