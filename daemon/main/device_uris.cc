#include "daemon/main/device_uris.h"

#include <fmt/format.h>

#include <set>

#include "drivers/registry.h"

namespace hapticd {
namespace {

bool isUri(const std::string& text) { return text.find("://") != std::string::npos; }

Error at(std::string entry, const std::string& uri, Error error) {
  error.where = fmt::format("{} \"{}\": {}", entry, uri, error.where);
  return error;
}

Error twice(std::string entry, const std::string& spelt, const std::string& uri, std::string remedy) {
  return at(std::move(entry), spelt, {ErrorCode::kInvalidArgument, uri, "it is there twice", std::move(remedy)});
}

}  // namespace

Result<void> resolveDeviceLimits(Config& config) {
  std::set<std::string> known;
  for (DeviceConfig& device : config.devices) {
    const std::string spelt = device.uri;
    std::string serial;
    if (isUri(spelt)) {
      const auto made = makeDevice(spelt);
      if (made) {
        device.uri = (*made)->info().uri;
        serial = (*made)->info().serial;
      } else if (made.error().code != ErrorCode::kUnsupported) {
        return at("[[device]]", spelt, made.error());
      }
    }
    const bool fresh = known.insert(device.uri).second;
    if (!fresh || (!serial.empty() && !known.insert(serial).second))
      return twice("[[device]]", spelt, device.uri, "only the first one's limits would hold: keep one");
  }
  return {};
}

Result<void> checkGroupUris(const Config& config) {
  std::set<std::string> known;
  for (const GroupConfig& group : config.groups) {
    for (const std::string& uri : group.devices) {
      if (!isUri(uri)) continue;
      const auto made = makeDevice(uri);
      if (!made) return at("group " + group.name, uri, made.error());
      if (!known.insert((*made)->info().uri).second)
        return twice("group " + group.name, uri, (*made)->info().uri, "name each device once");
    }
  }
  return {};
}

}  // namespace hapticd
