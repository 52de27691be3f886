// How devices close: at a client's wish, and by themselves when nobody wants them any more.
#include <algorithm>
#include <new>
#include <utility>

#include "daemon/control/core.h"
#include "daemon/log/log.h"
#include "drivers/registry.h"

namespace hapticd {
namespace {

/** Nothing real moves, and it is open because somebody asked for it. */
bool harmless(const OpenDevice& device) {
  const auto uri = parseDeviceUri(device.info().uri);
  return device.asked_for && uri && !isHardware(uri.value().scheme);
}

}  // namespace

void Core::noteAsker(OpenDevice& device, const Client& by) const {
  if (device.kept && payerOf(device) == nullptr) device.free = true;
  if (by.administration) device.kept = true;
  if (!clients_.has(by.connection)) return;  // It has left meanwhile.
  auto& askers = device.askers;
  if (std::find(askers.begin(), askers.end(), by.connection) == askers.end()) askers.push_back(by.connection);
}

bool Core::mayClose(const OpenDevice& device, std::uint64_t connection) const {
  if (client(connection).administration) return true;
  return harmless(device) && !device.kept && device.askers == std::vector{connection};
}

Result<void> Core::closeDevice(std::string_view uri, std::uint64_t connection) {
  auto device = devices_.find(uri);
  if (device ? !mayClose(**device, connection) : !client(connection).administration) {
    return Error{ErrorCode::kPermissionDenied, "closeDevice",
                 "closing a device that is real, configured or that others have asked for needs the administration "
                 "socket",
                 "connect to " + (facts_.admin_socket.empty() ? std::string("it") : facts_.admin_socket)};
  }
  if (!device) return device.error();
  if (auto r = mayGo(*(*device)->link, client(connection).administration); !r) return r;
  return closeGroupOf(**device);
}

Result<void> Core::mayGo(const GroupLink& link, bool administration) {
  const std::int64_t now = clock_.now();
  for (const auto& device : devices_.devices()) {
    if (device->link != &link) continue;
    if (sessions_.inUse(*device)) {
      return Error{ErrorCode::kDeviceBusy, device->name, "a session uses it",
                   "end it first; hapticctl status lists them"};
    }
    if (powerless(*device)) continue;  // Sessions that have ended go with it.
    if (administration && now - device->left_ns >= kLowered_ns) {
      log::warn("{}: closed although its servo has not lowered its force", device->name);
      continue;
    }
    return Error{ErrorCode::kWouldBlock, device->name, "its force is still being lowered",
                 "try again; it takes two seconds at most"};
  }
  return {};
}

Result<void> Core::closeGroupOf(OpenDevice& device) {
  std::vector<std::pair<std::string, HeldObject>> hands;
  GroupLink* const link = device.link;
  const std::string group = link->name();
  std::vector<std::string> canonical;
  for (std::size_t i = 0; i < link->group().deviceCount(); ++i) canonical.push_back(link->group().device(i).info().uri);
  for (const auto& other : devices_.devices()) {
    if (other->link == link) hands.emplace_back(other->name, other->tool);
  }
  if (auto r = devices_.endServo(*device.link); !r) return r;  // It may yet write what sessions that ended have mapped.
  try {
    drain(*link);  // Whoever closes as soon as he may does so before the next poll().
    tellMissed(*link, true);
  } catch (const std::bad_alloc&) {  // The devices must go all the same.
    events_.lost(1);
  }
  const SessionManager::Ended ended = sessions_.takeEnded(*link);
  const auto closed = devices_.close(device);
  if (!closed) return closed.error();
  recordings_.groupClosed(*link);
  wanted_.closed(group, std::move(canonical));
  events_dropped_.erase(link);
  missed_.erase(link);
  for (const auto& [name, held] : hands) {
    tellDisarmed(name);
    putAway(name, held);
    publish(EventKind::kDeviceRemoved, name);
  }
  if (closed->empty()) return {};
  return Error{ErrorCode::kTimeout, closed->front(), "it is out of use, but its driver does not let go of it",
               "unplug it, or restart hapticd; it can be opened again once its driver has come back"};
}

std::vector<std::string> Core::closeAll() {
  for (const auto& link : devices_.links()) recordings_.groupClosed(*link);
  return devices_.closeAll();
}

bool Core::powerless(const OpenDevice& device) {
  hd_sample sample;
  if (!device.link->latest(device.index, sample)) return true;
  return (sample.flags & HD_SAMPLE_ARMED) == 0 && sample.force[0] == 0 && sample.force[1] == 0 && sample.force[2] == 0;
}

/** What is asked for is a group of its own: nothing else goes with it. */
bool Core::unused(const OpenDevice& device) const {
  return harmless(device) && !device.link->standsStill() && !device.kept && device.askers.empty() &&
         device.sessions == 0 && !recordings_.of(*device.link) && powerless(device);
}

void Core::closeUnused() {
  const auto& all = devices_.devices();
  const auto it = std::find_if(all.begin(), all.end(), [this](const auto& device) { return unused(*device); });
  if (it == all.end()) return;  // Of several the next poll() takes the next.
  log::info("{}: those who asked for it have left", (*it)->name);
  (void)closeGroupOf(**it);
}

}  // namespace hapticd
