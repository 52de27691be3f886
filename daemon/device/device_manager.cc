#include "daemon/device/device_manager.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "daemon/device/buttons.h"
#include "daemon/device/finger_words.h"
#include "daemon/device/in_memory.h"
#include "daemon/device/limits.h"
#include "daemon/device/mount.h"
#include "daemon/log/log.h"
#include "drivers/link/io_device.h"

namespace hapticd {
static_assert(DeviceConfig::kMostRadius == ProxyRenderer::kMaxRadius);
static_assert(DeviceConfig::kMostDistance == Mount::kFarthest && DeviceConfig::kLeastScale == Mount::kLeast &&
              DeviceConfig::kMostScale == Mount::kLargest);
static_assert(GroupConfig::kMost == kMaxGroups);

DeviceManager::DeviceManager(const Config& config, Clock& clock, MeshStore& meshes, SceneModel& scene, bool threads)
    : config_(config),
      clock_(clock),
      meshes_(meshes),
      scene_(scene),
      threads_(threads),
      make_(makeDevice),
      find_(findDevices),
      choose_(chooseDevice) {}

DeviceManager::~DeviceManager() {
  (void)closeAll();
  for (auto& link : links_) (void)letGo(*link);  // Waits.
}

Result<void> DeviceManager::roomForGroup(const std::string& where) const {
  if (links_.size() + groups_opening_.size() + closer_.size() < kMaxGroups) return {};
  return Error{ErrorCode::kQuotaExceeded, where, fmt::format("there are {} device groups, the most", kMaxGroups),
               "close a device first, or end a program that has opened one"};
}

/** Whether its driver has let go of a device that was closed. */
Result<void> DeviceManager::notClosing(const std::string& canonical) const {
  if (!closer_.has(canonical)) return {};
  return Error{ErrorCode::kDeviceBusy, canonical, "it was closed, but its driver has not let go of it yet",
               "try again; if it stays so, unplug it, or restart hapticd"};
}

/** Its devices, not open yet; each of them once, and not open already. */
Result<std::vector<std::unique_ptr<Device>>> DeviceManager::makeGroup(const GroupConfig& group,
                                                                      const std::string& where,
                                                                      const std::string& within) {
  culprit_.clear();
  if (auto room = roomForGroup(where); !room) return room.error();
  if (group.devices.empty() || group.devices.size() > kMaxDevices) {
    return Error{ErrorCode::kInvalidArgument, where, fmt::format("a group has 1 to {} devices", kMaxDevices), {}};
  }
  std::vector<std::unique_ptr<Device>> made;
  for (const std::string& uri : group.devices) {
    culprit_ = uri;
    auto device = make_(uri, within);
    if (!device) return device.error();
    const std::string& canonical = (*device)->info().uri;
    if (auto r = notClosing(canonical); !r) return r.error();
    const bool here = std::any_of(made.begin(), made.end(), [&](const auto& d) { return d->info().uri == canonical; });
    if (here || lookUp(canonical) != nullptr) {
      return Error{ErrorCode::kDeviceBusy, where, fmt::format("{} is open already", canonical),
                   "name each device once"};
    }
    if (std::any_of(opening_.begin(), opening_.end(), [&](const Opening& o) { return o.canonical == canonical; })) {
      return Error{ErrorCode::kDeviceBusy, where, fmt::format("{} is being opened for another group", canonical),
                   "name each device once"};
    }
    made.push_back(std::move(*device));
  }
  culprit_.clear();
  return made;
}

Result<void> DeviceManager::openGroup(const GroupConfig& group) { return openGroup(group, std::string(), Admission()); }

Result<void> DeviceManager::openGroup(const GroupConfig& group, const std::string& within, const Admission& admission) {
  auto made = makeGroup(group, fmt::format("group '{}'", group.name), within);
  if (!made) return made.error();
  for (auto it = made->begin(); it != made->end(); ++it) {
    auto r = (*it)->open();
    if (r && admission) {
      r = admission(**it);
      if (!r) (*it)->close();
    }
    if (r) continue;
    while (it != made->begin()) (*--it)->close();
    return r;
  }
  return adopt(group, *made);
}

void DeviceManager::openGroup(const GroupConfig& group, GroupDone done, Turn turn) {
  auto made = makeGroup(group, fmt::format("group '{}'", group.name));
  if (made) return begin(group, std::move(*made), std::move(done), std::move(turn));
  if (!turn || turn()) return done(made.error());
  std::list<GroupOpening> one(1);
  GroupOpening& refused = one.front();
  refused.group = group;
  refused.done = std::move(done);
  refused.turn = std::move(turn);
  refused.ended = true;
  refused.devices = made.error();
  refused.culprit = culprit_;
  groups_opening_.splice(groups_opening_.end(), one);
}

void DeviceManager::begin(const GroupConfig& group, std::vector<std::unique_ptr<Device>> made, GroupDone done,
                          Turn turn, std::list<Asker> asker) {
  std::list<GroupOpening> one(1);
  std::list<Opening> rows;
  GroupOpening& opening = one.front();
  opening.group = group;
  opening.closed = std::move(made);
  opening.done = std::move(done);
  opening.turn = std::move(turn);
  opening.asker = std::move(asker);
  for (std::size_t i = 0; i < opening.closed.size(); ++i) {
    opening.canonical.push_back(opening.closed[i]->info().uri);
    rows.push_back({opening.canonical.back(), {group.devices[i]}, {}});
  }
  opening.open.reserve(opening.closed.size());
  groups_opening_.splice(groups_opening_.end(), one);  // Only now: one that never begins would never end.
  opening_.splice(opening_.end(), rows);
  openNext(opening);
}

void DeviceManager::openNext(GroupOpening& opening) {
  if (opening.closed.empty()) {
    opening.ended = true;
    return;
  }
  auto device = std::move(opening.closed.front());
  opening.closed.erase(opening.closed.begin());
  try {
    opener_.start(std::move(device), [this, &opening](DeviceOpener::Opened opened) {
      if (opened) {
        opening.open.push_back(std::move(*opened));
        return openNext(opening);
      }
      opening.devices = Aside::noMemory();  // Should there be none for what it says.
      opening.culprit = std::move(opening.group.devices[opening.open.size()]);
      opening.ended = true;
      opening.devices = opened.error();
    });
  } catch (const std::bad_alloc&) {
    opening.devices = Aside::noMemory();
    opening.ended = true;
  }
}

void DeviceManager::poll() {
  inMemory([&] {
    finder_.poll();
    if (!looking_ && !ask_.empty()) look();
  });
  opener_.poll();
  for (const std::string& uri : closer_.poll()) log::warn("{}: its driver has let go of it", log::printable(uri));
  for (auto it = groups_opening_.begin(); it != groups_opening_.end();) {
    if (!it->ended || (it->turn && !it->turn()) || (it->devices && !readyFor(*it))) {
      ++it;
      continue;
    }
    GroupOpening opening = std::move(*it);
    groups_opening_.erase(it);
    finish(opening);
    it = groups_opening_.begin();  // Again from the start: others may be free to finish, or newly begun.
  }
}

/** Whether what its servo needs of meshes and textures for itself has been made aside. */
bool DeviceManager::readyFor(const GroupOpening& opening) {
  const bool meshes = meshes_.readyForServo();
  return scene_.textures().readyForServo(options(opening.group, opening.open).cycle.period_ns) && meshes;
}

/** A group is open, or not: those who wait for one of its devices are told. */
void DeviceManager::finish(GroupOpening& opening) {
  Result<void> result;
  std::list<Opening> rows;
  for (const std::string& canonical : opening.canonical) takeOpening(canonical, rows);
  const bool asked = !opening.asker.empty();
  if (asked) rows.front().waiting.splice(rows.front().waiting.begin(), opening.asker);
  try {
    result = std::move(opening.devices);
    if (result && asked) result = admit(*opening.open.front(), rows.front().waiting);
    if (result) result = adopt(opening.group, opening.open);
  } catch (const std::bad_alloc&) {
    result = Aside::noMemory();
  }
  if (!result) inMemory([&] { closeUnused(opening.open); });
  if (!result && groups_opening_.empty()) {
    meshes_.noServoComes();
    scene_.textures().noServoComes();
  }
  for (const Opening& row : rows) {
    OpenDevice* const device = result ? lookUp(row.canonical) : nullptr;
    if (device == nullptr) continue;
    device->asked_for = asked;
    auto& aliases = device->aliases;
    for (const std::string& text : row.texts) {
      if (text == row.canonical || std::find(aliases.begin(), aliases.end(), text) != aliases.end()) continue;
      inMemory([&] { aliases.push_back(text); });
    }
    if (on_opened_) on_opened_(*device);
  }
  culprit_ = std::move(opening.culprit);
  if (!asked) inMemory([&] { opening.done(result); });
  for (const Opening& row : rows) {
    for (const Asker& one : row.waiting) {
      const Result<void>& answer = one.may ? result : one.may;
      inMemory(
          [&] { one.done(answer ? Result<OpenDevice*>(lookUp(row.canonical)) : Result<OpenDevice*>(answer.error())); });
    }
  }
}

/** Before any of them is charged: whether a device lives for one of them. What an administrator had first is free. */
Result<void> DeviceManager::admit(const Device& device, std::list<Asker>& askers) {
  bool lives = false;
  for (Asker& one : askers) {
    if (!one.admission && !lives) return {};
    if (one.admission) one.may = one.admission(device);
    lives = lives || one.may;
  }
  return lives ? Result<void>() : askers.front().may;
}

void DeviceManager::takeOpening(const std::string& canonical, std::list<Opening>& to) noexcept {
  const auto it =
      std::find_if(opening_.begin(), opening_.end(), [&](const Opening& o) { return o.canonical == canonical; });
  to.splice(to.end(), opening_, it);
}

/** Starts the servo of devices that are open, and takes them with it. */
Result<void> DeviceManager::adopt(const GroupConfig& group, std::vector<std::unique_ptr<Device>>& opened) {
  std::vector<std::unique_ptr<OpenDevice>> rows;
  std::vector<std::string> taken = names();
  GroupOptions group_options = options(group, opened);
  for (std::uint32_t i = 0; i < opened.size(); ++i) {
    const DeviceInfo& info = opened[i]->info();
    auto row = std::make_unique<OpenDevice>();
    row->name = shortName(info, taken);
    taken.push_back(row->name);
    row->index = i;
    row->maxima = deviceMaxima(info);
    const DeviceConfig* const entry = entryOf(info);
    row->limits = startLimits(entry == nullptr ? config_.limits : entry->limits, info);
    if (entry != nullptr) {
      row->radius = entry->radius_m;
      const Vec3 place(entry->mount_m.data()), turns(entry->mount_deg.data());
      row->mount = Mount(Pose{place, fromDegrees(turns)}, entry->scale);
      row->clutch_button = entry->clutch_button;
      if (const auto finger = parseFinger(entry->finger, info.uri)) row->wear(*finger, info);
    }
    group_options.cycle.guard[i].limits = row->limits;
    if (group.devices[i] != info.uri) row->aliases.push_back(group.devices[i]);
    rows.push_back(std::move(row));
  }
  devices_.reserve(devices_.size() + rows.size());
  links_.reserve(links_.size() + 1);
  auto link = GroupLink::start(group.name, group_options, std::move(opened), clock_);
  if (!link) return link.error();
  (*link)->setGiver(giver_);
  try {
    if (auto told = show(**link); !told) {
      (void)letGo(**link);
      return told;
    }
    for (auto& row : rows) tellStart(*row, **link);
  } catch (const std::bad_alloc&) {
    (void)letGo(**link);
    throw;
  }
  for (auto& row : rows) devices_.push_back(std::move(row));
  links_.push_back(std::move(*link));
  return {};
}

/** What there is in the world. */
Result<void> DeviceManager::show(GroupLink& link) {
  if (auto told = meshes_.attach(link); !told) return told;
  if (auto told = scene_.textures().attach(link); !told) return told;
  scene_.attach(link);
  return {};
}

/** Its servo, of how it begins. */
void DeviceManager::tellStart(OpenDevice& device, GroupLink& link) const {
  device.link = &link;
  if (device.radius > 0) device.applyRadius();
  if (!device.mount.identity()) device.applyMount();
  if (device.clutch_button != 0) device.applyClutch();
  const std::uint32_t buttons = buttonsOf(device.info(), lines_);
  if (device.clutch_button > buttons) {
    log::warn("device {}: clutch_button = {}, and it has {} buttons: none holds its clutch", device.name,
              device.clutch_button, buttons);
  }
  if (device.finger.law != 0) device.applyFinger();
  const DeviceGroup& group = link.group();
  log::info("device {}: {} ({}), group {}, {:g} Hz, {}", device.name, device.info().uri,
            log::printable(device.info().model), link.name(), 1e9 / static_cast<double>(link.periodNs()),
            group.realtime() ? "real-time" : "not real-time: " + group.schedulingNote());
  if (const auto* io = dynamic_cast<const IoDevice*>(&device.device()); io != nullptr && !io->schedulingNote().empty())
    log::warn("device {}: the thread that speaks with it may be late: {}", device.name, io->schedulingNote());
}

Result<OpenDevice*> DeviceManager::open(std::string_view uri, const std::string& within, const Admission& admission) {
  if (uri.empty() && !devices_.empty()) return devices_.front().get();
  if (OpenDevice* device = lookUp(uri)) return device;
  auto probe = make_(uri, within);
  if (!probe) return probe.error();
  if (OpenDevice* device = lookUp((*probe)->info().uri)) return device;
  probe->reset();
  if (auto r = openGroup(groupOf(uri), within, admission); !r) return r.error();
  devices_.back()->asked_for = true;
  return devices_.back().get();
}

/** A group of its own for a device. */
GroupConfig DeviceManager::groupOf(std::string_view uri) {
  GroupConfig group;
  const auto named = [&](const GroupConfig& other) { return other.name == group.name; };  // It may be missing yet.
  do {
    group.name = fmt::format("group{}", next_group_++);
  } while (std::any_of(config_.groups.begin(), config_.groups.end(), named) ||
           std::any_of(links_.begin(), links_.end(), [&](const auto& l) { return l->name() == group.name; }));
  group.devices = {std::string(uri)};
  group.rate_hz = config_.servo.rate_hz;
  return group;
}

void DeviceManager::open(std::string_view uri, Done done, const std::string& within, Admission admission) {
  if (uri.empty() && !devices_.empty()) return done(devices_.front().get());
  if (OpenDevice* device = lookUp(uri)) return done(device);
  std::unique_ptr<Device> made;
  std::string canonical;  // "": any will do
  const bool chosen = choose_ && uri.find("://") == std::string_view::npos;
  if (!uri.empty()) {
    if (chosen) return openChosen(uri, std::move(done), within, std::move(admission));
    auto one = make_(uri, within);
    if (!one) return done(one.error());
    made = std::move(*one);
    canonical = made->info().uri;
    if (OpenDevice* device = lookUp(canonical)) return done(device);
    if (auto r = notClosing(canonical); !r) return done(r.error());
    if (waitFor(canonical, uri, done, admission)) return;
  }
  if (isConfigured(canonical, made.get(), uri, done, admission)) return;
  if (auto room = roomForGroup(fmt::format("device '{}'", log::printable(uri.substr(0, 200)))); !room)
    return done(room.error());
  if (!made) {
    if (chosen) return openChosen(uri, std::move(done), within, std::move(admission));
    auto any = make_(uri, within);
    if (!any) return done(any.error());
    made = std::move(*any);
    canonical = made->info().uri;
    if (auto r = notClosing(canonical); !r) return done(r.error());
    if (waitFor(canonical, uri, done, admission)) return;
    if (isConfigured(canonical, made.get(), uri, done, admission)) return;  // Now that it has a name.
  }
  std::vector<std::unique_ptr<Device>> one;
  one.push_back(std::move(made));
  std::list<Asker> asker(1);
  asker.front().done = std::move(done);
  asker.front().admission = std::move(admission);
  begin(groupOf(uri), std::move(one), {}, {}, std::move(asker));
}

/** Whether that device is being opened: then `done` waits for it. */
bool DeviceManager::waitFor(const std::string& canonical, std::string_view text, Done& done, Admission& admission) {
  for (Opening& opening : opening_) {
    if (!isAskedFor(opening.canonical, canonical)) continue;
    if (opening.waiting.size() >= kMostWaiting) {
      done(tooManyWait(canonical, "wait for it to open"));
      return true;
    }
    opening.texts.emplace_back(text);
    Asker& asker = opening.waiting.emplace_back();
    asker.done = std::move(done);
    asker.admission = std::move(admission);
    return true;
  }
  return false;
}

}  // namespace hapticd
