// hapticctl list: the devices of this machine, open ones first.
#include <CLI/CLI.hpp>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {

void addList(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("list", "List devices: open ones first, then those found, then those missing");
  whenNamed(command, chosen, [](const Globals& globals) {
    const Daemon daemon(globals);
    const auto devices = daemon.ask<haptic_device_list>(haptic_device_list_all);
    if (globals.json) {
      Json all = Json::array();
      for (std::uint32_t i = 0; i < devices->count; ++i) all.push_back(toJson(*devices->items[i]));
      putJson(all);
      return kExitOk;
    }
    Table table({{"NAME"}, {"STATE"}, {"MODEL", false, 1}, {"SERIAL"}, {"URI"}});
    for (std::uint32_t i = 0; i < devices->count; ++i) {
      const haptic_device_info& d = *devices->items[i];
      table.row({d.name[0] != '\0' ? d.name : "-",
                 d.open != 0            ? "open"
                 : d.problem[0] != '\0' ? "missing"
                                        : "found",
                 d.model, d.serial, d.uri},
                d.open != 0 ? Style::kPlain : Style::kDim);
    }
    put(table.text());
    for (std::uint32_t i = 0; i < devices->count; ++i) {
      if (devices->items[i]->problem[0] != '\0')
        note(fmt::format("hapticctl: {}: {}", devices->items[i]->uri, devices->items[i]->problem));
    }
    if (table.empty()) note("hapticctl: no device; hapticctl doctor tells why");
    return kExitOk;
  });
}

}  // namespace hapticctl
