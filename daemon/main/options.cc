#include "daemon/main/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "daemon/control/core.h"
#include "daemon/main/device_uris.h"
#include "drivers/number.h"

namespace hapticd {
namespace {

/** CLI::Range lets "nan" through. */
std::string isNumber(const std::string& text) {
  return parseNumber(text) ? std::string() : fmt::format("'{}' is not a finite number", text);
}

}  // namespace

std::optional<Options> readOptions(int argc, char** argv, int& exit_code) {
  CLI::App app(
      "hapticd: the haptic device server. It owns the devices and the servo; programs say what is to be felt.");
  app.set_version_flag("--version", fmt::format("hapticd {}", kVersion));
  std::string config_file, socket, admin_socket, level;
  std::vector<std::string> devices;
  bool allow_no_rt = false;
  bool foreground = false;
  double rate_hz = 0;
  Options options;
  app.add_option("--config", config_file,
                 "TOML file; else $HAPTICD_CONFIG, the service's or the user's hapticd.toml, else built-in defaults");
  app.add_option("--device", devices,
                 "device URI or serial, e.g. sim://omega3; may be given several times. It must open, or hapticd ends")
      ->allow_extra_args(false);
  app.add_option("--rate", rate_hz, "servo rate [Hz]")->check(CLI::Range(1000.0, 4000.0))->check(isNumber);
  app.add_option("--socket", socket, "path of the control socket");
  app.add_option("--admin-socket", admin_socket, "path of the administration socket");
  app.add_option("--log-level", level, "trace, debug, info, warn, error or off");
  app.add_flag("--allow-no-rt", allow_no_rt, "run without real-time scheduling; every status then says so");
  app.add_flag("--foreground", foreground, "stay in the foreground (hapticd always does)");
  app.add_flag("--check-config", options.check_config, "check the configuration and end");
  app.add_flag("--print-config", options.print_config, "print the configuration in force as TOML and end");
  app.footer(
      "Exit codes: 0 ended as asked, 1 wrong usage, 2 configuration, 3 no real-time rights, 4 device, 5 socket in use, "
      "6 other failure.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {  // --help, --version
      exit_code = app.exit(e);
    } else {
      fmt::print(stderr, "hapticd: {} (hapticd --help lists the options)\n", e.what());
      exit_code = kExitUsage;
    }
    return std::nullopt;
  }
  auto loaded = loadConfig(config_file);
  if (!loaded) {
    fmt::print(stderr, "hapticd: {}\n", toString(loaded.error()));
    exit_code = kExitConfig;
    return std::nullopt;
  }
  options.loaded = std::move(*loaded);
  Config& config = options.loaded.config;
  if (!level.empty()) {
    auto parsed = log::parseLevel(level);
    if (!parsed) {
      fmt::print(stderr, "hapticd: --log-level: {}\n", toString(parsed.error()));
      exit_code = kExitUsage;
      return std::nullopt;
    }
    config.log.level = *parsed;
  }
  if (!socket.empty()) {
    config.sockets.control = socket;
    config.sockets.admin.clear();  // beside the control socket, unless named too
  }
  if (!admin_socket.empty()) config.sockets.admin = admin_socket;
  if (allow_no_rt) config.servo.allow_no_rt = true;
  if (!devices.empty()) {
    options.devices_named = true;
    config.groups.clear();
    for (std::size_t i = 0; i < devices.size(); ++i) {
      GroupConfig group;
      group.name = i == 0 ? "default" : fmt::format("default{}", i + 1);
      group.devices = {devices[i]};
      config.groups.push_back(std::move(group));
    }
  }
  if (rate_hz > 0) {
    config.servo.rate_hz = rate_hz;
    for (GroupConfig& group : config.groups) group.rate_hz = rate_hz;
  }
  Result<void> good = resolveDeviceLimits(config);
  if (good && options.check_config) good = checkGroupUris(config);
  if (good && options.check_config) good = checkFolders(options.loaded);
  if (!good) {
    fmt::print(stderr, "hapticd: {}\n", toString(good.error()));
    exit_code = kExitConfig;
    return std::nullopt;
  }
  return options;
}

}  // namespace hapticd
