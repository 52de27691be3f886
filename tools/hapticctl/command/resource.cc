// hapticctl get PATH, set PATH VALUE: resources by name, and dump: all of them for a bug report.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/command/host_checks.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

/** The daemon's JSON, indented; as it came if it is none. A text of several lines, /config, for people as it reads. */
void show(const haptic_text& text, bool as_json) {
  const std::string_view raw(text.text, text.length);
  const Json json = Json::parse(raw, nullptr, false);
  if (json.is_discarded()) {
    put(std::string(raw) + "\n");
  } else if (!as_json && json.is_string() && json.get_ref<const std::string&>().ends_with('\n')) {
    put(json.get_ref<const std::string&>());
  } else {
    putJson(json);
  }
}

std::string checkedPath(const std::string& path) {
  if (path.empty() || path.front() != '/')
    failUsage(path, "a resource begins with '/'", "for instance /objects/NAME/pos or /_objects");
  return path;
}

/** PATH?value=VALUE for a value as the user writes it, words of it parted by commas: 1 2 3 and '1 2 3' are 1,2,3. */
std::string withValue(const std::string& path, const std::vector<std::string>& words) {
  constexpr std::string_view kReserved = "%&?=#";
  const std::string begin = path + "?value=";
  std::string uri = begin;
  bool parted = false;
  for (const std::string& word : words) {
    parted = parted || uri != begin;
    for (const char c : word) {
      if (c == ' ' || c == '\t') {
        parted = true;
        continue;
      }
      if (parted && uri != begin && c != ',' && uri.back() != ',') uri += ',';
      parted = false;
      uri += kReserved.find(c) == std::string_view::npos ? std::string(1, c)
                                                         : fmt::format("%{:02x}", static_cast<unsigned char>(c));
    }
  }
  return uri;
}

}  // namespace

void addGet(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("get", "Read a resource: /objects/NAME/pos, /_objects/A/B, /devices/NAME, /statistics");
  auto path = std::make_shared<std::string>();
  command->add_option("PATH", *path, "Name of the resource")->required();
  whenNamed(command, chosen, [path](const Globals& globals) {
    const std::string name = checkedPath(*path);
    if (name.find('?') != std::string::npos) failUsage(name, "get changes nothing", "use hapticctl set '" + name + "'");
    const Daemon daemon(globals);
    show(*daemon.ask<haptic_text>(haptic_get, name.c_str()), globals.json);
    return kExitOk;
  });
}

void addSet(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("set", "Change a resource: /objects/NAME/pos 0,0,0.02");
  auto path = std::make_shared<std::string>();
  auto value = std::make_shared<std::vector<std::string>>();
  command->add_option("PATH", *path, "Name of the resource, or PATH?value=VALUE in quotes, as shells know '?'")
      ->required();
  command->add_option("VALUE", *value, "What it shall be; several numbers with commas or blanks");
  whenNamed(command, chosen, [path, value](const Globals& globals) {
    std::string name = checkedPath(*path);
    if (!value->empty()) {
      if (name.find('?') != std::string::npos)
        failUsage(name, "has a value, and another behind it", "leave out one of them");
      name = withValue(name, *value);
    }
    if (name.find('?') == std::string::npos) {
      const std::size_t equals = name.find('=');  // '/objects/ball/pos=1,2,3'
      const std::string given = equals == std::string::npos ? "VALUE" : name.substr(equals + 1);
      failUsage(name, "no value to set", "write hapticctl set " + name.substr(0, equals) + " " + given);
    }
    const Daemon daemon(globals);
    show(*daemon.ask<haptic_text>(haptic_set, name.c_str()), globals.json);
    return kExitOk;
  });
}

void addDump(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("dump", "Print all there is to know, as JSON, for a bug report");
  whenNamed(command, chosen, [](const Globals& globals) {
    Json out = {{"hapticctl", haptic_version()}, {"host", toJson(hostChecks())}};
    try {
      const Daemon daemon(globals);
      const auto dump = daemon.ask<haptic_text>(haptic_get_dump);
      out["daemon"] = Json::parse(std::string_view(dump->text, dump->length), nullptr, false);
      const auto toml = daemon.ask<haptic_text>(haptic_get_configuration);
      out["configuration"] = std::string(toml->text, toml->length);
    } catch (const Failure&) {
      putJson(out);  // What the host tells is still worth reporting.
      throw;
    }
    putJson(out);
    return kExitOk;
  });
}

}  // namespace hapticctl
