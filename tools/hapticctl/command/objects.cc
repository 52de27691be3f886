// hapticctl objects: what there is to touch.
#include <CLI/CLI.hpp>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

const char* shapeName(std::uint32_t kind) {
  constexpr const char* kNames[] = {"group", "plane", "sphere", "box", "capsule", "cylinder", "mesh"};
  return kind < std::size(kNames) ? kNames[kind] : "unknown";
}

Json objectToJson(const haptic_object_state& o) {
  const haptic_material& m = o.object->material;
  return {{"name", o.object->name},
          {"path", o.path},
          {"object", o.id},
          {"owner", o.owner},
          {"shape", shapeName(o.object->shape.kind)},
          {"size", o.object->shape.size},
          {"mesh", o.object->shape.mesh},
          {"triangles", o.triangles},
          {"pose", toJson(o.object->pose)},
          {"world_pose", toJson(o.world_pose)},
          {"material",
           {{"stiffness", m.stiffness},
            {"damping", m.damping},
            {"friction_static", m.friction_static},
            {"friction_dynamic", m.friction_dynamic}}},
          {"enabled", (o.object->flags & HAPTIC_OBJECT_ENABLED) != 0},
          {"visible", (o.object->flags & HAPTIC_OBJECT_VISIBLE) != 0},
          {"two_sided", (o.object->flags & HAPTIC_OBJECT_TWO_SIDED) != 0},
          {"keep", (o.object->flags & HAPTIC_OBJECT_KEEP) != 0}};
}

}  // namespace

void addObjects(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("objects", "List the objects of the scene");
  whenNamed(command, chosen, [](const Globals& globals) {
    const Daemon daemon(globals);
    const auto objects = daemon.ask<haptic_object_list>(haptic_object_list_all);
    if (globals.json) {
      Json all = Json::array();
      for (std::uint32_t i = 0; i < objects->count; ++i) all.push_back(objectToJson(*objects->items[i]));
      putJson(all);
      return kExitOk;
    }
    Table table({{"PATH"},
                 {"SHAPE"},
                 {"TRIANGLES", true, 2},
                 {"AT mm"},
                 {"N/m", true},
                 {"MU s/d"},
                 {"STATE"},
                 {"OWNER", false, 1}});
    for (std::uint32_t i = 0; i < objects->count; ++i) {
      const haptic_object_state& o = *objects->items[i];
      const double(&p)[3] = o.world_pose.p;
      const bool enabled = (o.object->flags & HAPTIC_OBJECT_ENABLED) != 0;
      table.row({o.path, shapeName(o.object->shape.kind), o.triangles > 0 ? grouped(o.triangles) : "",
                 fmt::format("{}, {}, {}", fixed(p[0] * 1e3, 1), fixed(p[1] * 1e3, 1), fixed(p[2] * 1e3, 1)),
                 fixed(o.object->material.stiffness, 0),
                 fmt::format("{:.3g}/{:.3g}", o.object->material.friction_static, o.object->material.friction_dynamic),
                 enabled ? "touchable" : "disabled", o.owner},
                enabled ? Style::kPlain : Style::kDim);
    }
    put(table.empty() ? "the scene is empty (hapticctl load, hapticctl add)\n" : table.text());
    return kExitOk;
  });
}

}  // namespace hapticctl
