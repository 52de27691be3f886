// Which devices are open, by what they are called. device_manager.cc opens and closes them.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <thread>
#include <utility>

#include "daemon/device/device_manager.h"
#include "daemon/log/log.h"
#include "drivers/did_you_mean.h"

namespace hapticd {
namespace {

/** Whether it says which device, and not how that is driven. */
bool onlyNames(std::string_view text) {
  const auto uri = parseDeviceUri(text);
  return uri && std::all_of(uri->query.begin(), uri->query.end(),
                            [](const auto& item) { return item.first == "serial" || item.first == "path"; });
}

}  // namespace

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
  look([this, done = std::move(done)](const Result<std::vector<DeviceFound>>& found) {
    if (!found) return done(found.error());
    std::vector<DeviceInfo> all;
    for (const DeviceFound& one : found.value()) {
      const bool open = std::any_of(devices_.begin(), devices_.end(),
                                    [&](const auto& d) { return isAskedFor(d->info().uri, one.info.uri); });
      if (!open) all.push_back(one.info);
    }
    done(all);
  });
}

Result<std::string> DeviceManager::recognise(std::string_view text) const {
  if (choose_ && text.find("://") == std::string_view::npos) {
    if (found_ != nullptr) return choose_(text, *found_);
    return Error{ErrorCode::kNotFound, "device", "nobody has looked for it", {}};
  }
  const auto made = make_(text, {});
  if (!made) return made.error();
  return (*made)->info().uri;
}

/** Which device the configuration means by it; `made` is that which is asked for by its URI, not open. */
Result<std::string> DeviceManager::advised(const std::string& canonical, const Device* made) {
  const bool known = made != nullptr && found_ == nullptr && !made->info().serial.empty() &&
                     isHardware(canonical.substr(0, canonical.find("://"))) && onlyNames(canonical);
  if (!known) return advice_(canonical);
  const std::vector<DeviceFound> just_this{{made->info(), true}};
  const Known one(*this, &just_this);
  return advice_(canonical);
}

/** Whether it is, or is about to be, open as the configuration wants it, or cannot be. */
bool DeviceManager::isConfigured(const std::string& canonical, const Device* made, std::string_view text, Done& done,
                                 Admission& admission) {
  if (!advice_) return false;
  const auto meant = advised(canonical, made);
  OpenDevice* const device = meant ? lookUp(*meant) : nullptr;
  if (meant && device == nullptr) return !meant->empty() && waitFor(*meant, text, done, admission);
  done(meant ? Result<OpenDevice*>(device) : Result<OpenDevice*>(meant.error()));
  return true;
}

/** Which device is meant, those on the buses tell. */
void DeviceManager::openChosen(std::string_view serial, Done done, const std::string& within, Admission admission) {
  look([this, serial = std::string(serial), done = std::move(done), within,
        admission = std::move(admission)](const Result<std::vector<DeviceFound>>& found) {
    if (!found) return done(found.error());
    if (serial.empty() && !devices_.empty()) return done(devices_.front().get());  // Opened meanwhile.
    if (OpenDevice* device = lookUp(serial)) return done(device);
    Done any = done;
    Admission of_any = admission;
    if (serial.empty() && isConfigured({}, nullptr, {}, any, of_any)) return;
    const auto uri = choose_(serial, found.value());
    if (!uri) return done(uri.error());
    const auto opened = [this, serial, done](const Result<OpenDevice*>& device) {
      if (device && !serial.empty() && lookUp(serial) == nullptr) device.value()->aliases.push_back(serial);
      done(device);
    };
    open(uri.value(), opened, within, admission);
  });
}

Error DeviceManager::tooManyWait(const std::string& where, const char* what) {
  return {ErrorCode::kQuotaExceeded, where, fmt::format("{} {}, the most", kMostWaiting, what),
          "wait for the answers before asking again"};
}

void DeviceManager::look(Looked done) {
  if (ask_.size() + asked_.size() >= kMostWaiting) return done(tooManyWait("devices", "wait for a look at them"));
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
                      [this](const Result<std::vector<DeviceFound>>& found) {
                        const std::list<Looked> told = std::exchange(asked_, {});  // They may ask again.
                        looking_ = false;
                        for (const Looked& done : told) {
                          const Known all(*this, found ? &found.value() : nullptr);
                          try {
                            done(found);
                          } catch (const std::bad_alloc&) {  // Who waits for it hears so when its answer goes.
                          }
                        }
                      });
  looking_ = true;
  asked_.swap(ask_);
}

/** Whether no look for devices is under way; one on a bus that stands does not come back. */
bool DeviceManager::hasLooked(std::int64_t most_ns) {
  constexpr std::chrono::milliseconds kStep(1);
  finder_.poll();
  for (std::chrono::nanoseconds waited{0}; finder_.size() != 0 && waited.count() < most_ns; waited += kStep) {
    std::this_thread::sleep_for(kStep);
    finder_.poll();
  }
  return finder_.size() == 0;
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
