// Which devices are open, by what they are called. device_manager.cc opens and closes them.
#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <utility>

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

void DeviceManager::found(Found done) {
  ask_.push_back(std::move(done));
  if (looking_) return;
  try {
    look();
  } catch (const std::bad_alloc&) {
    ask_.pop_back();
    throw;
  }
}

void DeviceManager::look() {
  (void)finder_.start([find = find_]() -> Result<std::vector<DeviceFound>> { return find(); },
                      [this](const Result<std::vector<DeviceFound>>& found) { tellFound(found); });
  looking_ = true;
  asked_.swap(ask_);
}

void DeviceManager::tellFound(const Result<std::vector<DeviceFound>>& found) {
  const std::list<Found> told = std::exchange(asked_, {});  // They may ask again.
  looking_ = false;
  Result<std::vector<DeviceInfo>> all = std::vector<DeviceInfo>();
  if (!found) all = found.error();
  for (std::size_t i = 0; found && i < found->size(); ++i) {
    const DeviceInfo& info = found.value()[i].info;
    const bool open = std::any_of(devices_.begin(), devices_.end(),
                                  [&](const auto& d) { return isAskedFor(d->info().uri, info.uri); });
    if (!open) all->push_back(info);
  }
  for (const Found& done : told) done(all);
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
