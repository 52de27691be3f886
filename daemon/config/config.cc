#include "daemon/config/config.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "daemon/ipc/unique_fd.h"
#include "daemon/log/log.h"

namespace hapticd {
namespace {

constexpr std::size_t kMostConfigBytes = 1 << 20;  ///< A configuration is a few kilobytes; this stops /dev/zero.

Result<std::string> readFile(const std::string& path) {
  const UniqueFd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!fd.valid()) {
    const bool missing = errno == ENOENT;
    Error error = systemError(path, "open", errno,
                              missing ? "name a file that is there, or none for the built-in defaults"
                                      : "this user must be able to read it; --config names another");
    if (missing) error.code = ErrorCode::kNotFound;
    return error;
  }
  // Only the opening of a pipe that nobody writes must not wait; one that is still being written is read to its end.
  (void)::fcntl(fd.get(), F_SETFL, 0);
  std::string text;
  char buffer[4096];
  for (;;) {
    const ssize_t n = ::read(fd.get(), buffer, sizeof buffer);
    if (n < 0) return systemError(path, "read", errno);
    if (n == 0) return text;
    text.append(buffer, static_cast<std::size_t>(n));
    if (text.size() > kMostConfigBytes)
      return Error{ErrorCode::kInvalidArgument, path, "is larger than a configuration may be (1 MiB)", {}};
  }
}

bool exists(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 || (errno != ENOENT && errno != ENOTDIR);
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace

std::string serviceFolder(const char* name) {
  const std::string all = variable(name);
  return all.substr(0, all.find(':'));
}

std::vector<GroupConfig> Config::effectiveGroups() const {
  std::vector<GroupConfig> all = groups;
  if (all.empty()) all.push_back({"default", {""}, 0, {}});
  for (GroupConfig& group : all)
    if (group.rate_hz == 0) group.rate_hz = servo.rate_hz;
  return all;
}

const DeviceConfig* Config::entryOf(std::string_view uri, std::string_view serial) const {
  for (const DeviceConfig& device : devices)
    if (device.uri == uri || (!serial.empty() && device.uri == serial)) return &device;
  return nullptr;
}

ConfigEnvironment ConfigEnvironment::fromProcess() {
  ConfigEnvironment e;
  e.hapticd_config = variable("HAPTICD_CONFIG");
  e.configuration_directory = serviceFolder("CONFIGURATION_DIRECTORY");
  e.config_home = variable("XDG_CONFIG_HOME");
  const std::string home = variable("HOME");
  if (e.config_home.empty() && !home.empty()) e.config_home = home + "/.config";
  return e;
}

Result<LoadedConfig> loadConfig(const std::string& option, const ConfigEnvironment& environment) {
  std::string file = !option.empty() ? option : environment.hapticd_config;
  if (file.empty() && !environment.configuration_directory.empty())
    if (const std::string path = environment.configuration_directory + "/hapticd.toml"; exists(path)) file = path;
  if (file.empty() && environment.configuration_directory.empty() && !environment.config_home.empty())
    if (const std::string path = environment.config_home + "/hapticd/hapticd.toml"; exists(path)) file = path;
  if (file.empty()) return LoadedConfig{};
  auto text = readFile(file);
  if (!text) return text.error();
  auto config = parseConfig(*text, file);
  if (!config) return config.error();
  return LoadedConfig{std::move(config).value(), file, std::move(text).value()};
}

std::string LoadedConfig::place(const char* section, const char* key, std::size_t entry) const {
  return file.empty() ? std::string() : placeInConfig(text, file, section, key, entry);
}

Result<void> checkFolders(const LoadedConfig& loaded) {
  const std::string& folder = loaded.config.motions.folder;
  if (folder.empty()) return {};
  struct stat status {};
  const int code = ::stat(folder.c_str(), &status) != 0 ? errno : S_ISDIR(status.st_mode) ? 0 : ENOTDIR;
  if (code == 0) return {};
  return Error{ErrorCode::kNotFound, loaded.place("motions", "folder"),
               fmt::format("folder = \"{}\": {}", log::printable(folder), std::strerror(code)),
               "make the folder, or correct the line: no client finds a motion there"};
}

}  // namespace hapticd
