// How groups of devices end: their servo first, then what it read; and what they leave in the scene.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/device/device_manager.h"
#include "daemon/device/in_memory.h"
#include "daemon/log/log.h"

namespace hapticd {

Result<void> DeviceManager::endServo(GroupLink& link) {
  const bool known = link.standsStill();
  if (link.endThreads(kEnd_ns)) return {};
  std::string of;
  for (std::size_t i = 0; i < link.group().deviceCount(); ++i)
    of += (of.empty() ? "" : ", ") + link.group().device(i).info().uri;
  if (!known) {
    log::error("group {}: its servo has not come back from the driver of {}, which was told to bring it to zero",
               link.name(), log::printable(of));
  }
  return Error{ErrorCode::kTimeout, of, "the servo has not come back from its driver",
               "unplug it, or restart hapticd: systemctl restart hapticd"};
}

Result<std::vector<std::string>> DeviceManager::close(OpenDevice& device) {
  GroupLink* link = device.link;
  for (const auto& other : devices_) {
    if (other->link == link && other->sessions != 0) {
      return Error{ErrorCode::kDeviceBusy, other->name,
                   other->sessions == 1 ? "a session uses it" : fmt::format("{} sessions use it", other->sessions),
                   "end them first; hapticctl status lists them"};
    }
  }
  if (auto r = endServo(*link); !r) return r.error();
  log::info("device group {} closes", link->name());
  keepThings(*link);
  devices_.erase(std::remove_if(devices_.begin(), devices_.end(), [&](const auto& d) { return d->link == link; }),
                 devices_.end());
  auto left = letGo(*link);
  links_.erase(std::remove_if(links_.begin(), links_.end(), [&](const auto& l) { return l.get() == link; }),
               links_.end());
  return left;
}

std::vector<std::string> DeviceManager::closeAll() {
  auto [opened, standing] = opener_.stop(kEnd_ns);
  for (const std::string& uri : standing)
    log::error("{}: its driver does not come back from opening it; nothing was commanded", log::printable(uri));
  for (GroupOpening& opening : groups_opening_) closeUnused(opening.open);
  closeUnused(opened);
  groups_opening_.clear();
  opening_.clear();
  ask_.clear();  // What a look that ends from now on tells would open devices, and ask who is there no more.
  asked_.clear();
  devices_.clear();
  for (auto it = links_.begin(); it != links_.end();) {
    if (const auto ended = endServo(**it); !ended) {
      standing.push_back(ended.error().where);
      ++it;
      continue;
    }
    (void)letGo(**it);
    it = links_.erase(it);
  }
  for (std::string& uri : closer_.names()) standing.push_back(std::move(uri));
  if (!hasLooked(kEnd_ns)) standing.emplace_back("the look for devices");
  return standing;
}

/** Those that no servo has had; each by itself, so that none waits for another's driver. */
void DeviceManager::closeUnused(std::vector<std::unique_ptr<Device>>& devices) {
  for (auto& device : devices) {
    if (!device) continue;
    DeviceGroup::Leaving one;
    one.devices.push_back(std::move(device));
    for (const std::string& uri : closer_.close(std::move(one), kEnd_ns))
      log::error("{}: its driver does not let go of it; it was told to bring it to zero", log::printable(uri));
  }
  devices.clear();
}

/** Where its servo, which has ended, has them, for nobody else knows. What its hands and sessions move stands there. */
void DeviceManager::keepThings(GroupLink& link) {
  Servo& servo = link.group().servo();
  const Scene& last = servo.cycle().scene();
  servo.publishPoses();
  inMemory([&] { scene_.refresh(); });
  scene_.detach(link);
  inMemory([&] {
    for (const std::uint16_t slot : last.used()) {
      const SceneObject& object = last.slot(slot);
      if (last.moverOf(object.id) != kControlSession) scene_.stand(object.id, object.V_PO);
    }
  });
}

/** After the end of its servo: first that, then what it read. Devices that are not closed yet. */
std::vector<std::string> DeviceManager::letGo(GroupLink& link) {
  scene_.detach(link);
  std::vector<std::string> left;
  inMemory([&] { left = closer_.close(link.stop(), kEnd_ns); });
  if (!left.empty()) {
    log::error("group {}: the driver of {} does not let go of it; it was told to bring it to zero", link.name(),
               log::printable(left.front()));
  }
  meshes_.detach(link);
  scene_.textures().detach(link);
  return left;
}

}  // namespace hapticd
