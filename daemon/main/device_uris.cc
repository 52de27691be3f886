#include "daemon/main/device_uris.h"

#include <fmt/format.h>

#include <set>

#include "drivers/named_file.h"
#include "drivers/registry.h"

namespace hapticd {
namespace {

bool isUri(const std::string& text) { return text.find("://") != std::string::npos; }

/** Its device, not to be used. A recorded motion that it names is read, too. */
Result<std::unique_ptr<Device>> checked(const std::string& text) {
  auto made = makeDevice(text);
  const auto uri = parseDeviceUri(text);
  if (!made || !uri || namedMotion(*uri).empty()) return made;
  if (auto read = (*made)->open(); !read) return read.error();
  return made;
}

/** `entry` is where it was named: "file:line:column: [[device]]". */
Error at(std::string entry, const std::string& uri, Error error) {
  error.where = fmt::format("{} \"{}\": {}", entry, uri, error.where);
  return error;
}

Error twice(std::string entry, const std::string& spelt, const std::string& uri, std::string remedy) {
  return at(std::move(entry), spelt, {ErrorCode::kInvalidArgument, uri, "it is there twice", std::move(remedy)});
}

}  // namespace

Result<void> resolveDeviceLimits(LoadedConfig& loaded) {
  std::set<std::string> known;
  for (std::size_t i = 0; i < loaded.config.devices.size(); ++i) {
    DeviceConfig& device = loaded.config.devices[i];
    const std::string spelt = device.uri;
    const auto entry = [&] { return loaded.place("device", "uri", i) + ": [[device]]"; };
    std::string serial;
    if (isUri(spelt)) {
      const auto made = checked(spelt);
      if (made) {
        device.uri = (*made)->info().uri;
        serial = (*made)->info().serial;
      } else if (made.error().code != ErrorCode::kUnsupported) {
        return at(entry(), spelt, made.error());
      }
    }
    const bool fresh = known.insert(device.uri).second;
    if (!fresh || (!serial.empty() && !known.insert(serial).second))
      return twice(entry(), spelt, device.uri, "only the first one's limits would hold: keep one");
  }
  return {};
}

Result<void> checkGroupUris(const Options& options) {
  std::set<std::string> known;
  for (std::size_t i = 0; i < options.loaded.config.groups.size(); ++i) {
    const GroupConfig& group = options.loaded.config.groups[i];
    const auto entry = [&] {
      return options.devices_named ? "--device" : options.loaded.place("group", "devices", i) + ": group " + group.name;
    };
    for (const std::string& uri : group.devices) {
      if (!isUri(uri)) continue;
      const auto made = checked(uri);
      if (!made) return at(entry(), uri, made.error());
      if (!known.insert((*made)->info().uri).second)
        return twice(entry(), uri, (*made)->info().uri, "name each device once");
    }
  }
  return {};
}

}  // namespace hapticd
