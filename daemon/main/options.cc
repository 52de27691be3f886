#include "daemon/main/options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <sstream>

#include "daemon/control/core.h"
#include "daemon/leash/find_builder.h"
#include "daemon/main/device_uris.h"
#include "daemon/panel/panel.h"
#include "daemon/rpc/listen_socket.h"
#include "daemon/version.h"
#include "drivers/number.h"
#include "rt/base/standard_streams.h"

namespace hapticd {
namespace {

/** What stands on the command line besides `Options`. */
struct Words {
  std::string config_file, socket, admin_socket;
  std::optional<std::string> level;
  std::vector<std::string> devices;
  bool allow_no_rt = false;
  bool foreground = false;
  double rate_hz = 0;
};

std::string isRate(const std::string& text) {
  const auto rate = parseNumber(text);
  if (!rate) return fmt::format("'{}' is not a finite number", text);
  return *rate >= 1000 && *rate <= 4000 ? std::string() : fmt::format("{} is out of range: from 1000 to 4000", text);
}

/** A variable of a script that was never set must not mean "as if nothing had been asked for". */
std::string isNotEmpty(const std::string& text) {
  return text.empty() ? "the name is empty: name a file, or leave the option out" : std::string();
}

/** As isNotEmpty(): else any device would be meant, a real one first. */
std::string isADevice(const std::string& text) {
  return text.empty() ? "the device is empty: name one by URI or serial, or leave the option out" : std::string();
}

void addOptions(CLI::App& app, Words& words, Options& options) {
  app.set_version_flag("--version", fmt::format("hapticd {}", kVersion));
  app.add_option("--config", words.config_file,
                 "TOML file; else $HAPTICD_CONFIG, the service's or\n"
                 "the user's hapticd.toml, else built-in defaults")
      ->check(isNotEmpty);
  app.add_option("--device", words.devices,
                 "device URI or serial, e.g. sim://omega3; may be\n"
                 "given several times. It must open, or hapticd ends")
      ->allow_extra_args(false)
      ->check(isADevice);
  app.add_option("--rate", words.rate_hz, "servo rate, 1000 to 4000 [Hz]")->check(isRate);
  app.add_option("--socket", words.socket, "path of the control socket")->check(isNotEmpty);
  app.add_option("--admin-socket", words.admin_socket, "path of the administration socket")->check(isNotEmpty);
  app.add_option("--log-level", words.level, "trace, debug, info, warn, error or off");
  app.add_flag("--allow-no-rt", words.allow_no_rt, "run without real-time scheduling; every status\nthen says so");
  app.add_flag("--foreground", words.foreground, "stay in the foreground (hapticd always does)");
  app.add_flag("--check-config", options.check_config, "check the configuration and end");
  app.add_flag("--print-config", options.print_config, "print the configuration in force as TOML and end");
  app.footer(
      "Exit codes: 0 ended as asked, 1 wrong usage, 2 configuration, 3 no real-time\n"
      "rights, 4 device, 5 socket, 6 other failure.");
}

/** The command line's changes to the configuration. */
Result<void> apply(const Words& words, Options& options) {
  Config& config = options.loaded.config;
  if (words.level) {
    auto parsed = log::parseLevel(*words.level);
    if (!parsed) return parsed.error();
    config.log.level = *parsed;
  }
  if (!words.socket.empty()) {
    config.sockets.control = words.socket;
    config.sockets.admin.clear();  // beside the control socket, unless named too
  }
  if (!words.admin_socket.empty()) config.sockets.admin = words.admin_socket;
  if (words.allow_no_rt) config.servo.allow_no_rt = true;
  if (!words.devices.empty()) {
    options.devices_named = true;
    config.groups.clear();
    for (std::size_t i = 0; i < words.devices.size(); ++i) {
      GroupConfig group;
      group.name = i == 0 ? "default" : fmt::format("default{}", i + 1);
      group.devices = {words.devices[i]};
      config.groups.push_back(std::move(group));
    }
  }
  if (words.rate_hz > 0) {
    config.servo.rate_hz = words.rate_hz;
    for (GroupConfig& group : config.groups) group.rate_hz = words.rate_hz;
  }
  return {};
}

/** Says as well where it stands in the file. */
Result<void> standingAt(const std::string& place, Result<void> good) {
  if (good || place.empty()) return good;
  Error error = good.error();
  error.where = place + ": " + error.where;
  return error;
}

/** A servo that is to run where there is no processor does not start. */
Result<void> checkProcessors(const LoadedConfig& loaded) {
  const long processors = ::sysconf(_SC_NPROCESSORS_CONF);
  for (std::size_t i = 0; i < loaded.config.groups.size(); ++i) {
    const GroupConfig& group = loaded.config.groups[i];
    for (const std::uint32_t cpu : group.cpus) {
      if (processors < 1 || static_cast<long>(cpu) < processors) continue;
      return standingAt(
          loaded.place("group", "cpus", i),
          Error{ErrorCode::kInvalidArgument, fmt::format("group {}: cpus", group.name),
                fmt::format("there is no processor {}", cpu), fmt::format("this machine has 0 to {}", processors - 1)});
    }
  }
  return {};
}

/** A builder that is named is there; without one a start goes on, and refuses meshes. */
Result<void> checkBuilder(const std::string& program) {
  if (program.empty()) return {};
  auto found = findBuilder(program);
  return found ? Result<void>() : found.error();
}

/** What must be right in any case, and with --check-config what a start would find. */
Result<void> checkWhole(Options& options) {
  Config& config = options.loaded.config;
  Result<void> good = resolveDeviceLimits(options.loaded);
  if (!options.check_config) return good;
  if (good) good = checkGroupUris(options);
  if (good) good = checkProcessors(options.loaded);
  if (good) good = checkFolders(options.loaded);
  if (good) good = checkSocketPaths(config.sockets.control, config.sockets.admin);
  if (good) good = checkGroup(options.loaded);
  if (good) good = standingAt(options.loaded.place("builder", "program"), checkBuilder(config.builder.program));
  if (good) good = findLines(lineRequests(config.lines));
  return good;
}

}  // namespace

Result<void> checkGroup(const LoadedConfig& loaded) {
  return standingAt(loaded.place("sockets", "group"), checkSocketGroup(loaded.config.sockets.group));
}

int answer(const std::string& text) {
  if (std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0) return kExitOk;
  tellError(fmt::format("hapticd: standard output: {} (send it where there is room)\n", std::strerror(errno)));
  return kExitFailure;
}

std::optional<Options> readOptions(int argc, char** argv, int& exit_code) {
  CLI::App app(
      "hapticd: the haptic device server. It owns the devices and the servo; programs\nsay what is to be felt.");
  Words words;
  Options options;
  addOptions(app, words, options);
  const auto refuse = [&](int code, const std::string& sentence) {
    tellError(fmt::format("hapticd: {}\n", log::printable(sentence)));
    exit_code = code;
    return std::nullopt;
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) {
      return refuse(kExitUsage, fmt::format("{} (hapticd --help lists the options)", e.what()));
    }
    std::ostringstream text;
    app.exit(e, text, text);
    exit_code = answer(text.str());  // --help, --version
    return std::nullopt;
  }
  if (words.devices.size() > GroupConfig::kMost) {
    return refuse(kExitUsage,
                  fmt::format("--device: {} are named, and each has a servo of its own, of which a daemon has {} "
                              "at most (put some together, in a [[group]] of a configuration)",
                              words.devices.size(), GroupConfig::kMost));
  }
  auto loaded = loadConfig(words.config_file);
  if (!loaded) return refuse(kExitConfig, toString(loaded.error()));
  options.loaded = std::move(*loaded);
  if (const auto applied = apply(words, options); !applied) {
    return refuse(kExitUsage, "--log-level: " + toString(applied.error()));
  }
  if (const auto good = checkWhole(options); !good) return refuse(kExitConfig, toString(good.error()));
  return options;
}

}  // namespace hapticd
