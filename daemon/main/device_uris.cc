#include "daemon/main/device_uris.h"

#include <fmt/format.h>

#include "drivers/registry.h"

namespace hapticd {
namespace {

bool isUri(const std::string& text) { return text.find("://") != std::string::npos; }

Error at(std::string entry, const std::string& uri, Error error) {
  error.where = fmt::format("{} \"{}\": {}", entry, uri, error.where);
  return error;
}

}  // namespace

Result<void> resolveDeviceLimits(Config& config) {
  for (DeviceConfig& device : config.devices) {
    if (!isUri(device.uri)) continue;
    const auto made = makeDevice(device.uri);
    if (made) {
      device.uri = (*made)->info().uri;
    } else if (made.error().code != ErrorCode::kUnsupported) {
      return at("[[device]]", device.uri, made.error());
    }
  }
  return {};
}

Result<void> checkGroupUris(const Config& config) {
  for (const GroupConfig& group : config.groups) {
    for (const std::string& uri : group.devices) {
      if (!isUri(uri)) continue;
      if (const auto made = makeDevice(uri); !made) return at("group " + group.name, uri, made.error());
    }
  }
  return {};
}

}  // namespace hapticd
