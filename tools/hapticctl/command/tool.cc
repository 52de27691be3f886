// hapticctl tool: the object in a device's hand.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct ToolOptions {
  std::string device, object;
  double mass = 0.1;
  double stiffness = 0;
  bool weighs = false, direct = false;
};

/** Its short name, as resources have it. */
std::string nameOf(const Daemon& daemon, const std::string& text) {
  const auto status = daemon.ask<haptic_status>(haptic_get_status);
  const std::string uri = deviceUri(daemon, text);
  for (std::uint32_t i = 0; i < status->device_count; ++i) {
    if (uri.empty() || uri == status->devices[i]->uri) return status->devices[i]->name;
  }
  throw Failure{kExitRefused, text, "no such device is open", "hapticctl list shows them", "NOT_FOUND"};
}

void tell(const std::string& name, const haptic_text& answer, const Globals& globals) {
  const Json tool = Json::parse(std::string_view(answer.text, answer.length), nullptr, false);
  if (globals.json) {
    putJson({{"device", name}, {"tool", tool}});
  } else if (!tool.is_object()) {
    print("{}: holds nothing\n", name);
  } else {
    print("{}: holds {}, {:g} kg at {:.4g} N/m{}{}{}\n", name, tool.value("object", ""), tool.value("mass", 0.0),
          tool.value("stiffness", 0.0), tool.value("rendering", "") == "direct" ? ", without a coupling" : "",
          tool.value("weight", "") == "felt" ? ", its weight is felt" : "",
          tool.value("torque_shown", false) ? "" : "; torque is not shown");
    if (const std::string note = tool.value("note", ""); !note.empty()) print("  {}\n", note);
  }
}

int set(const ToolOptions& o, const std::string& value, const Globals& globals) {
  const Daemon daemon(globals);
  const std::string name = nameOf(daemon, o.device);
  const std::string uri = "/devices/" + name + "/tool?value=" + value;
  tell(name, *daemon.ask<haptic_text>(haptic_set, uri.c_str()), globals);
  return kExitOk;
}

}  // namespace

void addTool(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("tool", "Put an object into a device's hand, take it away, or show it");
  command->require_subcommand(0, 1);
  const auto o = std::make_shared<ToolOptions>();
  CLI::App* attach = command->add_subcommand("attach", "The object follows the hand and is stopped by the scene");
  attach->add_option("OBJECT", o->object, "Directly below the root: sphere, box, capsule, cylinder or mesh")
      ->required();
  attach->add_option("DEVICE", o->device, "URI, name or serial; without it: the first open one");
  attach->add_option("--mass", o->mass, "Mass of the tool, 0.01 to 10")
      ->type_name("KG")
      ->capture_default_str()
      ->check(number(0.01, 10));
  attach->add_option("--stiffness", o->stiffness, "Stiffness of the coupling; without it: the stiffest that is passive")
      ->type_name("N/m")
      ->check(number(0, 1e6));
  attach->add_flag("--weighs", o->weighs, "The hand carries it, where the world has gravity; else it weighs nothing");
  attach->add_flag("--direct", o->direct, "Without a coupling: the tool is where the hand is, and overlap pushes back");
  whenNamed(attach, chosen, [o](const Globals& globals) {
    return set(*o,
               fmt::format("{},{},{}{}{}", o->object, o->mass, o->stiffness, o->weighs ? ",weighs" : "",
                           o->direct ? ",direct" : ""),
               globals);
  });
  CLI::App* detach = command->add_subcommand("detach", "The hand is empty again");
  detach->add_option("DEVICE", o->device, "URI, name or serial; without it: the first open one");
  whenNamed(detach, chosen, [o](const Globals& globals) { return set(*o, "", globals); });
  command->callback([&chosen, command, o] {
    if (!command->get_subcommands().empty()) return;
    chosen = [o](const Globals& globals) {
      const Daemon daemon(globals);
      const std::string name = nameOf(daemon, o->device);
      tell(name, *daemon.ask<haptic_text>(haptic_get, ("/devices/" + name + "/tool").c_str()), globals);
      return kExitOk;
    };
  });
}

}  // namespace hapticctl
