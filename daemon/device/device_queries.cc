// Which devices are open, by what they are called. device_manager.cc opens and closes them.
#include <fmt/format.h>

#include <algorithm>

#include "daemon/device/device_manager.h"
#include "daemon/log/log.h"
#include "drivers/did_you_mean.h"

namespace hapticd {

Result<OpenDevice*> DeviceManager::find(std::string_view text) {
  if (text.empty() && !devices_.empty()) return devices_.front().get();
  if (OpenDevice* device = lookUp(text)) return device;
  return Error{ErrorCode::kNotFound, "device",
               fmt::format("no open device is called '{}'", log::printable(text.substr(0, 200))),
               devices_.empty() ? "open one first" : "open devices: " + nearestNames(text, names())};
}

OpenDevice* DeviceManager::lookUp(std::string_view text) {
  if (text.empty()) return nullptr;
  for (const auto& device : devices_) {
    const DeviceInfo& info = device->info();
    if (device->name == text || info.uri == text || info.serial == text ||
        std::find(device->aliases.begin(), device->aliases.end(), text) != device->aliases.end()) {
      return device.get();
    }
  }
  for (const auto& device : devices_)
    if (isAskedFor(device->info().uri, text)) return device.get();
  return nullptr;
}

OpenDevice* DeviceManager::at(const GroupLink& link, std::uint32_t index) {
  for (const auto& device : devices_) {
    if (device->link == &link && device->index == index) return device.get();
  }
  return nullptr;
}

std::vector<std::string> DeviceManager::names() const {
  std::vector<std::string> all;
  for (const auto& device : devices_) all.push_back(device->name);
  return all;
}

std::vector<DeviceInfo> DeviceManager::found() const {
  std::vector<DeviceInfo> all;
  for (auto& device : find_()) {
    const bool open = std::any_of(devices_.begin(), devices_.end(),
                                  [&](const auto& d) { return isAskedFor(d->info().uri, device.info.uri); });
    if (!open) all.push_back(std::move(device.info));
  }
  return all;
}

bool DeviceManager::realtime() const {
  return std::all_of(links_.begin(), links_.end(), [](const auto& l) { return l->group().realtime(); });
}

std::string DeviceManager::schedulingNote() const {
  for (const auto& link : links_) {
    if (!link->group().realtime()) return link->group().schedulingNote();
  }
  return {};
}

}  // namespace hapticd
