// What the scene model answers; the edits are in scene_model.cc.
#include <fmt/format.h>

#include <algorithm>

#include "daemon/scene/scene_model.h"
#include "drivers/did_you_mean.h"

namespace hapticd {

Result<ObjectNow> SceneModel::find(std::string_view name) {
  const Object* object = lookUp(name);
  if (object == nullptr) return notFound(name, "name");
  return describe(objectSlot(object->id));
}

std::vector<ObjectNow> SceneModel::list() {
  std::vector<ObjectNow> all;
  all.reserve(by_name_.size());
  for (const auto& [name, slot] : by_name_) all.push_back(describe(slot));
  return all;
}

std::vector<std::string> SceneModel::names() const {
  std::vector<std::string> all;
  for (const auto& [name, slot] : by_name_) all.push_back(name);
  return all;
}

std::vector<std::string> SceneModel::childrenOf(std::string_view name) const {
  std::uint32_t parent = 0;
  if (!name.empty()) {
    const auto it = by_name_.find(name);
    if (it == by_name_.end()) return {};
    parent = it->second;
  }
  std::vector<std::string> children;
  for (const std::uint32_t slot : childSlots(parent)) children.push_back(slots_[slot].spec.name);
  std::sort(children.begin(), children.end());
  return children;
}

std::string SceneModel::nameOf(std::uint32_t id) const {
  const std::uint32_t slot = objectSlot(id);
  return slot != 0 && slot < kMaxObjects && slots_[slot].id == id ? slots_[slot].spec.name : std::string();
}

std::string SceneModel::lastNameOf(std::uint32_t id) const {
  const std::uint32_t slot = objectSlot(id);
  return id != 0 && slot < kMaxObjects && gone_[slot].id == id ? gone_[slot].name.data() : nameOf(id);
}

Pose SceneModel::worldPose(std::string_view name) {
  const Object* object = name.empty() ? nullptr : lookUp(name);
  return object == nullptr ? Pose{} : worldPoseOf(objectSlot(object->id));
}

std::uint64_t SceneModel::triangles() const {
  std::uint64_t sum = 0;
  for (const auto& [name, slot] : by_name_) {
    const ShapeSpec& shape = slots_[slot].spec.shape;
    if (shape.kind != ShapeKind::kMesh) continue;
    if (const MeshInfo* mesh = meshes_.find(shape.mesh)) sum += mesh->triangles;
  }
  return sum;
}

std::uint32_t SceneModel::countOf(std::uint32_t uid) const {
  return static_cast<std::uint32_t>(
      std::count_if(slots_.begin(), slots_.end(), [&](const Object& o) { return o.id != 0 && o.owner.uid == uid; }));
}

SceneModel::Object* SceneModel::lookUp(std::string_view name) {
  const auto it = by_name_.find(name);
  return it == by_name_.end() ? nullptr : &slots_[it->second];
}

Error SceneModel::notFound(std::string_view name, const std::string& where) const {
  const std::string near = nearestNames(name, names());
  return {ErrorCode::kNotFound, where, fmt::format("there is no object '{}'", name.substr(0, 80)),
          near.empty() ? "the scene is empty" : "nearest: " + near};
}

std::vector<std::uint32_t> SceneModel::childSlots(std::uint32_t slot) const {
  std::vector<std::uint32_t> children;
  for (std::uint32_t i = 1; i < kMaxObjects; ++i) {
    if (slots_[i].id != 0 && slots_[i].parent_slot == slot) children.push_back(i);
  }
  return children;
}

ObjectNow SceneModel::describe(std::uint32_t slot) {
  Object& object = slots_[slot];
  ObjectNow now;
  now.X_WO = worldPoseOf(slot);  // refreshes it and its ancestors
  now.spec = object.spec;
  now.spec.parent = object.parent_slot == 0 ? std::string() : slots_[object.parent_slot].spec.name;
  now.id = object.id;
  now.V_PO = object.V_PO;
  now.path = pathOf(slot);
  now.owner = object.owner.name;
  if (object.spec.shape.kind == ShapeKind::kMesh) {
    if (const MeshInfo* mesh = meshes_.find(object.spec.shape.mesh)) now.triangles = mesh->triangles;
  }
  return now;
}

Pose SceneModel::worldPoseOf(std::uint32_t slot) {
  Pose X_WO;
  for (std::uint32_t i = slot; i != 0; i = slots_[i].parent_slot) {
    refresh(slots_[i]);
    X_WO = slots_[i].spec.X_PO * X_WO;
  }
  return X_WO;
}

std::string SceneModel::pathOf(std::uint32_t slot) const {
  std::string path;
  for (std::uint32_t i = slot; i != 0; i = slots_[i].parent_slot) path.insert(0, "/" + slots_[i].spec.name);
  return "/_objects" + path;
}

}  // namespace hapticd
