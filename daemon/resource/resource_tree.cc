#include "daemon/resource/resource_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "daemon/resource/properties.h"
#include "daemon/version.h"
#include "drivers/did_you_mean.h"

namespace hapticd {
namespace {

const std::vector<std::string>& roots() {
  static const std::vector<std::string> kRoots{"objects", "_objects", "devices", "statistics", "clients",
                                               "meshes",  "textures", "config",  "world",      "volumes"};
  return kRoots;
}

template <class Table>
std::vector<std::string> namesOf(const Table& table) {
  std::vector<std::string> names;
  for (const auto& row : table) names.emplace_back(row.name);
  return names;
}

template <class Table>
auto* findRow(const Table& table, const std::string& name) {
  for (const auto& row : table) {
    if (name == row.name) return &row;
  }
  return static_cast<decltype(&*table.begin())>(nullptr);
}

Error tooDeep(const ResourceName& name, std::size_t i) {
  return {ErrorCode::kNotFound, name.upTo(i), fmt::format("there is nothing below {}", name.upTo(i - 1)),
          "name that itself"};
}

/** A refusal of a write to `path`, in whatever words its place was told below. */
Error refusedAt(const std::string& path, Error error) {
  if (error.where.rfind('/', 0) == 0) return error;
  const bool told = error.where.empty() || (path + "/").find("/" + error.where + "/") != std::string::npos;
  error.where = told ? path : path + " (" + error.where + ")";
  return error;
}

Json describe(const ObjectNow& object, Core& core) {
  Json json = Json::object();
  for (const ObjectProperty& property : objectProperties()) json[property.name] = property.get(object, core);
  return json;
}

Json describe(const OpenDevice& device, Core& core) {
  const DeviceNow status = statusOf(device);
  Json json{{"name", device.name}};
  for (const DeviceProperty& property : deviceProperties()) json[property.name] = property.get(device, status, core);
  return json;
}

Json statistics(const OpenDevice& device) {
  const DeviceNow status = statusOf(device);
  Json json{{"period_ns", device.link->group().options().cycle.period_ns},
            {"cycles", status.cycles},
            {"missed", status.missed},
            {"overruns", status.overruns},
            {"stale", status.stale},
            {"busy", number(status.busy)}};
  const CollideNow collide = collideOf(device.link->group());
  json["collide"] = {{"queries", collide.queries}, {"exhausted", collide.exhausted}, {"unsent", collide.unsent}};
  for (const Stage& stage : stagesOf(device.link->group())) {
    const Histogram::Summary s = stage.histogram->summary();
    json["stages"][stage.name] = {{"count", s.count},      {"p50_ns", s.p50_ns},      {"p99_ns", s.p99_ns},
                                  {"p99.9_ns", s.p999_ns}, {"p99.99_ns", s.p9999_ns}, {"max_ns", s.max_ns}};
  }
  return json;
}

Json clients(Core& core) {
  Json json = Json::array();
  for (const auto& [id, client] : core.clients().all()) {
    Json c{{"name", client.name}, {"pid", client.pid}, {"uid", client.uid}, {"administration", client.administration}};
    c["sessions"] = Json::array();
    for (const Session* session : core.sessions().all()) {
      if (session->client.connection != id || core.sessions().find(session->id) == nullptr) continue;
      const SessionNow status = statusOf(*session);
      c["sessions"].push_back({{"id", session->id},
                               {"device", session->device->name},
                               {"lease", session->device->lease == session->id},
                               {"received", status.received},
                               {"rejected", status.rejected},
                               {"stale", status.stale},
                               {"models", status.models},
                               {"fade", number(status.fade)},
                               {"heartbeat_age_ns", status.heartbeat_age_ns},
                               {"bytes", session->regions.bytes()}});
    }
    json.push_back(std::move(c));
  }
  return json;
}

/** The cache on disk, with the objects that show each volume. */
Json volumes(Core& core) {
  Json json = Json::array();
  VolumeCache* cache = core.uploads().cache();
  if (cache == nullptr) return json;
  std::map<std::string, Json> shown_by;
  for (const ObjectNow& object : core.scene().list()) {
    const MeshInfo* mesh = core.meshes().find(object.spec.shape.mesh);
    if (object.spec.shape.kind == ShapeKind::kMesh && mesh != nullptr)
      shown_by[mesh->cache_key].push_back(object.spec.name);
  }
  for (const CachedVolume& volume : cache->list()) {
    const auto objects = shown_by.find(volume.key);
    json.push_back({{"key", volume.key},
                    {"objects", objects == shown_by.end() ? Json::array() : objects->second},
                    {"bytes", volume.bytes},
                    {"vdb_bytes", volume.vdb_bytes},
                    {"unused_s", number(volume.unused_s)}});
  }
  return json;
}

Json branch(SceneModel& scene, const std::string& name) {
  Json json = Json::object();
  for (const std::string& child : scene.childrenOf(name)) json[child] = branch(scene, child);
  return json;
}

/** What a store holds, named by its numbers. */
template <class Store>
Result<Json> readById(const ResourceName& name, const Store& store) {
  Json all = Json::object();
  std::vector<std::string> ids;
  for (const auto* info : store.list()) {
    ids.push_back(std::to_string(info->id));
    all[ids.back()] = toJson(*info);
  }
  if (name.element.size() == 1) return all;
  if (!all.contains(name.element[1])) return noSuchElement(name, 1, std::move(ids));
  if (name.element.size() > 2) return tooDeep(name, 2);
  return all[name.element[1]];
}

}  // namespace

Error noSuchElement(const ResourceName& name, std::size_t i, std::vector<std::string> valid) {
  const std::string near = nearestNames(name.element[i], std::move(valid), 9);
  return {ErrorCode::kNotFound, name.upTo(i),
          fmt::format("there is no '{}' in {}", name.element[i].substr(0, 80), i == 0 ? "/" : name.upTo(i - 1)),
          near.empty() ? "it is empty" : "there is " + near};
}

Result<std::string> ResourceTree::get(std::string_view path, const Client&) {
  auto name = parseResourceName(path);
  if (!name) return name.error();
  if (!name->query.empty()) {
    return Error{ErrorCode::kInvalidArgument, name->upTo(name->element.size()), "a read takes no query",
                 "write with set"};
  }
  auto json = read(*name);
  if (!json) return json.error();
  return json->print();
}

Result<std::string> ResourceTree::setOfDevice(const ResourceName& name, std::string_view value, const Client& by) {
  auto device = core_.devices().find(name.element[1]);
  if (!device) return noSuchElement(name, 1, core_.devices().names());
  if (name.element.size() > 3) return tooDeep(name, 3);
  const DeviceProperty* property = findRow(deviceProperties(), name.element[2]);
  if (property == nullptr) return noSuchElement(name, 2, namesOf(deviceProperties()));
  if (property->set == nullptr) {
    return Error{ErrorCode::kPermissionDenied, name.upTo(2), fmt::format("'{}' cannot be written", property->name),
                 "limits and arming have commands of their own"};
  }
  if (auto r = property->set(core_, **device, value, name.upTo(2), by); !r) return refusedAt(name.upTo(2), r.error());
  return property->get(**device, statusOf(**device), core_).print();
}

Result<std::string> ResourceTree::setOfWorld(const ResourceName& name, std::string_view value) {
  if (name.element.size() > 2) return tooDeep(name, 2);
  if (name.element[1] != "gravity") return noSuchElement(name, 1, {"gravity"});
  auto n = parseNumbers(value, 3, name.upTo(1));
  if (!n) return n.error();
  if (auto r = core_.scene().setGravity({(*n)[0], (*n)[1], (*n)[2]}); !r) return refusedAt(name.upTo(1), r.error());
  return toJson(core_.scene().gravity()).print();
}

Result<Json> ResourceTree::readWorld(const ResourceName& name) {
  const Json gravity = toJson(core_.scene().gravity());
  if (name.element.size() == 1) return Json{{"gravity", gravity}};
  if (name.element[1] != "gravity") return noSuchElement(name, 1, {"gravity"});
  if (name.element.size() > 2) return tooDeep(name, 2);
  return gravity;
}

Result<std::string> ResourceTree::set(std::string_view uri, const Client& by) {
  auto name = parseResourceName(uri);
  if (!name) return name.error();
  const std::string* value = name->find("value");
  if (value == nullptr || name->query.size() != 1) {
    return Error{ErrorCode::kInvalidArgument, name->upTo(name->element.size()), "a write has one query: ?value=...",
                 "for example /objects/motor/pos?value=0,0,0.02"};
  }
  const std::size_t last = name->element.size();
  if (last >= 3 && name->element[0] == "devices") return setOfDevice(*name, *value, by);
  if (last >= 2 && name->element[0] == "world") return setOfWorld(*name, *value);
  const bool known = last == 0 || std::count(roots().begin(), roots().end(), name->element[0]) != 0;
  if (!known) return noSuchElement(*name, 0, {"objects", "_objects", "devices", "world"});
  if (last < 3 || (name->element[0] != "objects" && name->element[0] != "_objects")) {
    return Error{ErrorCode::kPermissionDenied, name->upTo(last),
                 "only properties of objects, devices and the world can be written",
                 "limits, arming and the rest have commands of their own"};
  }
  std::string object = name->element[1];
  std::size_t at = 2;
  if (name->element[0] == "_objects") {
    auto walked = walk(*name, 1);
    if (!walked) return walked.error();
    std::tie(object, at) = *walked;
  } else if (!core_.scene().has(object)) {
    return noSuchElement(*name, 1, core_.scene().names());
  }
  if (at + 1 != last) {
    return at >= last ? Error{ErrorCode::kInvalidArgument, name->upTo(last), "that is an object, not a property",
                              "name one of its properties"}
                      : tooDeep(*name, at + 1);
  }
  const ObjectProperty* property = findRow(objectProperties(), name->element[at]);
  if (property == nullptr) return noSuchElement(*name, at, namesOf(objectProperties()));
  if (property->set == nullptr) {
    return Error{ErrorCode::kPermissionDenied, name->upTo(at), fmt::format("'{}' cannot be written", property->name),
                 "it follows from the others, or stays as the object was made"};
  }
  auto now = core_.scene().find(object);
  if (!now) return now.error();
  if (auto r = property->set(core_, *now, *value, name->upTo(at)); !r) return refusedAt(name->upTo(at), r.error());
  now = core_.scene().find(object);
  if (!now) return now.error();
  return property->get(*now, core_).print();
}

Result<Json> ResourceTree::read(const ResourceName& name) {
  if (name.element.empty()) return Json(roots());
  const std::string& root = name.element[0];
  if (root == "objects") {
    if (name.element.size() == 1) {
      Json all = Json::object();
      for (const ObjectNow& object : core_.scene().list()) all[object.spec.name] = describe(object, core_);
      return all;
    }
    if (!core_.scene().has(name.element[1])) return noSuchElement(name, 1, core_.scene().names());
    return readObject(name, 2, name.element[1]);
  }
  if (root == "_objects") return readTree(name);
  if (root == "devices") return readDevices(name);
  if (root == "statistics") return readStatistics(name);
  if (root == "meshes") return readMeshes(name);
  if (root == "textures") return readTextures(name);
  if (root == "world") return readWorld(name);
  if (root != "clients" && root != "config" && root != "volumes") return noSuchElement(name, 0, roots());
  if (name.element.size() > 1) return tooDeep(name, 1);
  if (root == "volumes") return volumes(core_);
  return root == "clients" ? clients(core_) : Json(toToml(core_.config()));
}

Result<Json> ResourceTree::readObject(const ResourceName& name, std::size_t at, const std::string& object) {
  auto now = core_.scene().find(object);
  if (!now) return now.error();
  if (at >= name.element.size()) return describe(*now, core_);
  const ObjectProperty* property = findRow(objectProperties(), name.element[at]);
  if (property == nullptr) return noSuchElement(name, at, namesOf(objectProperties()));
  if (at + 1 < name.element.size()) return tooDeep(name, at + 1);
  return property->get(*now, core_);
}

Result<Json> ResourceTree::readTree(const ResourceName& name) {
  if (name.element.size() == 1) return branch(core_.scene(), "");
  auto walked = walk(name, 1);
  if (!walked) return walked.error();
  if (walked->second < name.element.size()) return readObject(name, walked->second, walked->first);
  return branch(core_.scene(), walked->first);
}

Result<std::pair<std::string, std::size_t>> ResourceTree::walk(const ResourceName& name, std::size_t at) {
  std::string object;
  for (; at < name.element.size(); ++at) {
    const std::vector<std::string> children = core_.scene().childrenOf(object);
    const std::string& wanted = name.element[at];
    if (std::find(children.begin(), children.end(), wanted) != children.end()) {
      object = wanted;
      continue;
    }
    if (!object.empty() && findRow(objectProperties(), wanted) != nullptr) break;
    std::vector<std::string> valid = children;
    if (!object.empty()) {
      for (auto& property : namesOf(objectProperties())) valid.push_back(std::move(property));
    }
    return noSuchElement(name, at, std::move(valid));
  }
  return std::make_pair(object, at);
}

Result<Json> ResourceTree::readDevices(const ResourceName& name) {
  if (name.element.size() == 1) {
    Json all = Json::object();
    for (const auto& device : core_.devices().devices()) all[device->name] = describe(*device, core_);
    return all;
  }
  auto device = core_.devices().find(name.element[1]);
  if (!device) return noSuchElement(name, 1, core_.devices().names());
  if (name.element.size() == 2) return describe(**device, core_);
  const DeviceProperty* property = findRow(deviceProperties(), name.element[2]);
  if (property == nullptr) return noSuchElement(name, 2, namesOf(deviceProperties()));
  if (name.element.size() > 3) return tooDeep(name, 3);
  return property->get(**device, statusOf(**device), core_);
}

Result<Json> ResourceTree::readStatistics(const ResourceName& name) {
  if (name.element.size() == 1) {
    Json all = Json::object();
    for (const auto& device : core_.devices().devices()) all[device->name] = statistics(*device);
    return all;
  }
  auto device = core_.devices().find(name.element[1]);
  if (!device) return noSuchElement(name, 1, core_.devices().names());
  if (name.element.size() > 2) return tooDeep(name, 2);
  return statistics(**device);
}

Result<Json> ResourceTree::readMeshes(const ResourceName& name) { return readById(name, core_.meshes()); }

Result<Json> ResourceTree::readTextures(const ResourceName& name) { return readById(name, core_.scene().textures()); }

std::string ResourceTree::dump() {
  Json json;
  for (const std::string& root : roots()) {
    ResourceName name;
    name.element = {root};
    if (auto part = read(name)) json[root] = std::move(*part);
  }
  json["daemon"] = {{"version", kVersion},
                    {"epoch", fmt::format("{:016x}", core_.epoch())},
                    {"realtime", core_.devices().realtime()},
                    {"scheduling_note", core_.devices().schedulingNote()},
                    {"config_file", core_.facts().config_file},
                    {"uptime_ns", core_.now() - core_.started()},
                    {"locked_bytes", core_.lockedBytes()}};
  return json.print();
}

}  // namespace hapticd
