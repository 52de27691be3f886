// hapticctl add SHAPE: an exact plane, sphere, box, capsule, cylinder, or a group for others to hang on.
#include <CLI/CLI.hpp>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/command/placement.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/lengths.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct AddOptions {
  std::string kind, size;
  Placement placement;
};

struct Kind {
  const char* name;
  haptic_shape_kind kind;
  std::size_t numbers;
  const char* size;
};
constexpr Kind kKinds[] = {{"plane", HAPTIC_SHAPE_PLANE, 0, "none: solid below its z = 0"},
                           {"sphere", HAPTIC_SHAPE_SPHERE, 1, "RADIUS"},
                           {"box", HAPTIC_SHAPE_BOX, 3, "HALF_X,HALF_Y,HALF_Z"},
                           {"capsule", HAPTIC_SHAPE_CAPSULE, 2, "RADIUS,HALF_LENGTH (along z, without the caps)"},
                           {"cylinder", HAPTIC_SHAPE_CYLINDER, 2, "RADIUS,HALF_LENGTH (along z)"},
                           {"group", HAPTIC_SHAPE_GROUP, 0, "none: a parent for others"}};

haptic_shape makeShape(const AddOptions& options) {
  for (const Kind& kind : kKinds) {
    if (options.kind != kind.name) continue;
    haptic_shape shape{};
    shape.kind = kind.kind;
    if (kind.numbers == 0) {
      if (!options.size.empty()) failUsage("--size", fmt::format("a {} has no size", kind.name));
      return shape;
    }
    if (options.size.empty())
      failUsage("--size", fmt::format("a {} needs its size", kind.name),
                fmt::format("--size {}, in metres or with units (10mm)", kind.size));
    const auto numbers = parseLengths("--size", options.size, kind.numbers);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      constexpr double kLeast_m = 1e-6;  // No hand feels less.
      if (!(numbers[i] >= kLeast_m)) {
        failUsage("--size", fmt::format("{} is too small: at least {:g} m", exact(numbers[i]), kLeast_m),
                  fmt::format("--size {}", kind.size));
      }
      shape.size[i] = numbers[i];
    }
    return shape;
  }
  failUsage(options.kind, "no such shape", "shapes are plane, sphere, box, capsule, cylinder and group");
}

/** "sphere of radius 10.0 mm": who thinks in other units sees it at once. */
std::string describe(const std::string& kind, const haptic_shape& shape) {
  const std::string a = length(shape.size[0]), b = length(shape.size[1]);
  switch (shape.kind) {
    case HAPTIC_SHAPE_SPHERE:
      return fmt::format("{} of radius {}", kind, a);
    case HAPTIC_SHAPE_BOX:
      return fmt::format("{} of half sides {}, {}, {}", kind, a, b, length(shape.size[2]));
    case HAPTIC_SHAPE_CAPSULE:
    case HAPTIC_SHAPE_CYLINDER:
      return fmt::format("{} of radius {}, half length {}", kind, a, b);
    default:
      return kind;
  }
}

}  // namespace

void addAdd(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("add", "Add a plane, sphere, box, capsule, cylinder or group to the scene");
  auto o = std::make_shared<AddOptions>();
  command->add_option("SHAPE", o->kind, "plane, sphere, box, capsule, cylinder or group")->required();
  command
      ->add_option("--size", o->size,
                   "sphere: R; box: half X,Y,Z; capsule, cylinder: R,half length; metres, or with units (10mm)")
      ->type_name("LENGTHS");
  addPlacement(*command, o->placement);
  whenNamed(command, chosen, [o](const Globals& globals) {
    if (o->placement.name.empty()) o->placement.name = o->kind;
    haptic_object object = makeObject(o->placement);
    object.shape = makeShape(*o);
    const Daemon daemon(globals);
    requirePlace(daemon, o->placement);
    const std::uint32_t id = place(daemon, o->placement, object);
    if (globals.json) {
      putJson({{"name", o->placement.name}, {"object", id}});
    } else {
      print("{}: {}, object {}\n", o->placement.name, describe(o->kind, object.shape), id);
    }
    return kExitOk;
  });
}

void addRemove(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("remove", "Remove objects from the scene, with their children");
  auto names = std::make_shared<std::vector<std::string>>();
  command->add_option("NAME", *names, "Names of objects")->required();
  whenNamed(command, chosen, [names](const Globals& globals) {
    const Daemon daemon(globals);
    std::vector<Owned<haptic_object_state>> old;  // All are looked for before the first one goes.
    for (const std::string& name : *names)
      old.push_back(daemon.ask<haptic_object_state>(haptic_object_find, name.c_str()));
    for (std::size_t i = 0; i < old.size(); ++i) {
      haptic_error error = HAPTIC_ERROR_INIT;
      const int code = haptic_object_remove(daemon.client(), (*names)[i].c_str(), &error);
      if (code != HAPTIC_NOT_FOUND || i == 0) check(code, error);  // Gone with its parent, or named twice.
      // Its mesh goes too, unless another object shows it: then the daemon refuses, and is right.
      if (old[i]->object->shape.kind == HAPTIC_SHAPE_MESH)
        haptic_mesh_drop(daemon.client(), old[i]->object->shape.mesh, nullptr);
    }
    if (globals.json) putJson({{"removed", *names}});
    return kExitOk;
  });
}

}  // namespace hapticctl
