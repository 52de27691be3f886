#include "daemon/control/core.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <new>

#include "daemon/log/log.h"
#include "drivers/link/holds_memory.h"
#include "drivers/named_file.h"
#include "drivers/registry.h"
#include "rt/cycle/realtime.h"

namespace hapticd {
namespace {

constexpr std::size_t kMostWhere = 200;  ///< Bytes of a URI in an error.

std::uint64_t heldBytes(const Device& device) {
  const auto* const holds = dynamic_cast<const HoldsMemory*>(&device);
  return holds == nullptr ? 0 : holds->heldBytes();
}

/** Whoever may do himself what the daemon may. */
bool mayItself(const Client& by) { return by.administration || by.uid == 0 || by.uid == ::geteuid(); }

}  // namespace

Core::Core(const CoreOptions& options, Clock& clock)
    : options_(options),
      clock_(clock),
      started_ns_(clock.now()),
      events_(options.config.sessions.event_buffer),
      scene_(meshes_),
      sessions_({options.epoch, options.config.quotas.sessions,
                 options.config.servo.lock_memory && !options.config.servo.allow_no_rt},
                {[this](Session& session) {
                   session.device->left_ns = clock_.now();
                   if (session.device->lease == session.id) loseLease(*session.device, session.why);
                 },
                 [this](std::uint32_t uid, std::uint64_t bytes) { return checkQuota(uid, bytes, 0); },
                 [this](const Session& session, ErrorCode code, const std::string& what) {
                   tellRefused(session, code, what, {});
                 }}),
      uploads_(meshes_, scene_.textures(),
               [this](std::uint32_t uid, std::uint64_t bytes, std::uint64_t triangles) {
                 return checkQuota(uid, bytes, triangles);
               }),
      recordings_(scene_, meshes_, sessions_, options.config.servo.lock_memory && !options.config.servo.allow_no_rt),
      devices_(options_.config, clock, meshes_, scene_, options.threads),
      wanted_(devices_, clock) {
  devices_.setLines(lines_);
  devices_.onOpened(
      [this](const OpenDevice& device) { publish(EventKind::kDeviceAdded, device.name, device.info().uri); });
  scene_.setQuota(options_.config.quotas.objects);
  meshes_.setLock(options_.config.servo.lock_memory && !options_.config.servo.allow_no_rt);
  scene_.textures().setLock(options_.config.servo.lock_memory && !options_.config.servo.allow_no_rt);
  scene_.onChange([this](const std::string& name, const char* what) {
    try {
      Event event;
      event.kind = EventKind::kObjectChanged;
      event.t_ns = clock_.now();
      event.object = name;
      event.text = what;
      events_.publish(event);
    } catch (const std::bad_alloc&) {
      events_.lost(1);
    }
  });
}

Core::~Core() { (void)closeAll(); }

Result<void> Core::openConfigured(const std::function<bool()>& go_on) {
  constexpr std::int64_t kLook_ns = 1'000'000;
  const std::vector<GroupConfig> groups = options_.config.effectiveGroups();
  if (options_.devices_required) {
    for (const GroupConfig& group : groups) {
      // Shared: should nobody wait for it any more, a later poll() still has its answer to give.
      const auto answer = std::make_shared<std::optional<Result<void>>>();
      devices_.openGroup(group, [answer](const Result<void>& result) { *answer = result; });
      for (; !*answer && (!go_on || go_on()); clock_.sleepUntil(clock_.now() + kLook_ns)) devices_.poll();
      if (!*answer) return {};
      if (!**answer) return **answer;
    }
  } else {
    if (auto r = wanted_.begin(groups); !r) return r;
    for (; wanted_.fatal() && !wanted_.settled() && (!go_on || go_on()); clock_.sleepUntil(clock_.now() + kLook_ns)) {
      devices_.poll();
      wanted_.poll();
    }
    if (wanted_.fatal()) devices_.poll();  // What has waited for one that outlasted all patience.
    if (!wanted_.fatal()) return wanted_.fatal();
    if (devices_.links().empty()) {
      if (auto r = mayRunServos(); !r) return r;
    }
  }
  for (const DeviceConfig& wanted : options_.config.devices) {
    const auto is = [&](const auto& device) {
      return device->info().uri == wanted.uri || device->info().serial == wanted.uri;
    };
    if (std::any_of(devices_.devices().begin(), devices_.devices().end(), is)) continue;
    log::warn("[[device]] \"{}\" is none of the open devices: its limits wait until it is opened",
              log::printable(wanted.uri));
  }
  return {};
}

/** Tried on a thread of its own where no servo has: without the right the daemon must not start. */
Result<void> Core::mayRunServos() const {
  if (options_.config.servo.allow_no_rt || !options_.threads) return {};
  constexpr std::size_t kStackBytes = 64 * 1024;
  Result<void> may;
  RtThread probe;
  auto started = probe.start("probe", kStackBytes,
                             [&] { may = becomeRealtime(static_cast<int>(options_.config.servo.servo_priority)); });
  probe.join();
  return started ? may : started;
}

void Core::poll() {
  const std::int64_t now = clock_.now();
  bool no_memory = false;
  std::exception_ptr defect;
  const auto go = [&](auto&& work) {
    try {
      work();
    } catch (const std::bad_alloc&) {
      no_memory = true;
    } catch (...) {
      defect = std::current_exception();
    }
  };
  go([&] { devices_.poll(); });
  go([&] { wanted_.poll(); });
  busy_ = devices_.opening() != 0;
  for (const auto& link : devices_.links()) {
    busy_ = link->flush() || busy_;
    go([&] { drain(*link); });
  }
  go([&] { pollOffs(); });
  go([&] { pollDisarmed(); });
  go([&] { pollArms(); });
  go([&] { pollListed(); });
  go([&] { sessions_.poll(now); });
  go([&] { pollLeft(); });
  go([&] { pollWishes(); });
  go([&] { closeUnused(); });
  go([&] { scene_.followClients(); });
  go([&] { meshes_.reclaim(); });
  go([&] { scene_.textures().reclaim(); });
  go([&] { uploads_.poll(); });
  busy_ = busy_ || uploads_.busy() || meshes_.busy() || scene_.textures().busy() || recordings_.copies().size() != 0;
  go([&] { recordings_.poll(); });
  if (defect) std::rethrow_exception(defect);
  if (no_memory) throw std::bad_alloc();
}

void Core::beginShutdown() {
  stopping_ = true;
  recordings_.daemonStops();
  for (const auto& device : devices_.devices()) switchOff(*device, CommandKind::kDisarm);
}

bool Core::quiet(std::int64_t since_ns) {
  constexpr std::int64_t kPatienceNs = 500'000'000;
  if (clock_.now() - since_ns > kPatienceNs) return true;
  return std::all_of(devices_.devices().begin(), devices_.devices().end(),
                     [](const auto& device) { return powerless(*device); });
}

void Core::introduce(std::uint64_t connection, std::string name) {
  Client* const client = clients_.find(connection);
  if (client == nullptr) return;
  const bool first = client->name.empty();
  client->name = std::move(name);
  if (!first) return;
  log::info("client '{}' (pid {}, uid {}) joins", log::printable(client->name), client->pid, client->uid);
  publish(EventKind::kClientJoined, {}, client->name);
}

const Client& Core::client(std::uint64_t connection) const {
  static const Client kNobody{.uid = ~std::uint32_t{0}};  // Not 0: that is root.
  const Client* const found = clients_.find(connection);
  return found == nullptr ? kNobody : *found;
}

void Core::disconnect(std::uint64_t connection) noexcept {
  Client* const gone = clients_.find(connection);
  if (gone == nullptr) return;
  sessions_.endAllOf(connection, "the client has left");
  gone->left = true;
  try {
    leave(*gone);
  } catch (const std::bad_alloc&) {  // pollLeft() goes on with it.
  }
}

/** Whatever of it has gone before. */
void Core::leave(Client& gone) {
  const std::uint64_t connection = gone.connection;
  scene_.clientLeft(connection);
  meshes_.dropUnusedOf(connection);
  scene_.textures().dropUnusedOf(connection);
  for (const auto& device : devices_.devices()) std::erase(device->askers, connection);
  if (!gone.name.empty()) {
    log::info("client '{}' (pid {}) leaves", log::printable(gone.name), gone.pid);
    publish(EventKind::kClientLeft, {}, gone.name);
  }
  clients_.remove(connection);
}

void Core::pollLeft() {
  const auto& all = clients_.all();
  const auto it = std::find_if(all.begin(), all.end(), [](const auto& one) { return one.second.left; });
  if (it != all.end()) leave(*clients_.find(it->first));  // Of several the next poll() takes the next.
}

Result<OpenDevice*> Core::openDevice(std::string_view uri) {
  auto device = openNow(uri);
  if (device) (*device)->kept = true;
  return device;
}

Result<OpenDevice*> Core::openNow(std::string_view uri, const std::string& within,
                                  const DeviceManager::Admission& admission) {
  const std::size_t before = devices_.devices().size();
  auto device = devices_.open(uri, within, admission);
  if (!device) return device;
  for (std::size_t i = before; i < devices_.devices().size(); ++i) {
    publish(EventKind::kDeviceAdded, devices_.devices()[i]->name, devices_.devices()[i]->info().uri);
  }
  return device;
}

/** The folder in which motions that it names must lie when they are read; "": anywhere. */
Result<std::string> Core::mayOpen(std::string_view text, std::uint64_t connection) {
  const auto uri = parseDeviceUri(text);
  const std::string motion = uri ? namedMotion(uri.value()) : std::string();
  const bool known = devices_.find(text) || wanted_.names(text);  // Open, or configured: the administrator's choice.
  // Of a folder's, whoever opens it judges: two judges would tell by their words what is there.
  if (!motion.empty() && !mayItself(client(connection)) && !known && options_.config.motions.folder.empty()) {
    return Error{ErrorCode::kPermissionDenied, log::printable(motion.substr(0, 200)),
                 "which files the daemon reads is the administrator's choice",
                 "set motions.folder in hapticd.toml, or connect to the administration socket"};
  }
  const std::string line = uri ? namedLine(uri.value()) : std::string();
  if (!line.empty() && !mayItself(client(connection)) && !known) {
    return Error{ErrorCode::kPermissionDenied, log::printable(line.substr(0, 200)),
                 "which serial lines the daemon writes to is the administrator's choice",
                 "name the device in hapticd.toml, or connect to the administration socket"};
  }
  const std::string model = uri ? namedModel(uri.value()) : std::string();
  if (!model.empty() && !mayItself(client(connection)) && !known) {  // It scales the motors.
    return Error{ErrorCode::kPermissionDenied, log::printable(model.substr(0, 200)),
                 "which model a board drives is the administrator's choice",
                 "name the device in hapticd.toml, or connect to the administration socket"};
  }
  const bool tuned = uri && !uri.value().query.empty() && isHardware(uri.value().scheme);
  if (tuned && !client(connection).administration && !known) {
    return Error{ErrorCode::kPermissionDenied, log::printable(std::string(text.substr(0, 200))),
                 "the parameters of a real device are the administrator's",
                 "open it without them, name it in hapticd.toml, or connect to the administration socket"};
  }
  return motion.empty() || mayItself(client(connection)) || known ? std::string() : options_.config.motions.folder;
}

Result<OpenDevice*> Core::openDevice(std::string_view text, std::uint64_t connection) {
  const auto within = mayOpen(text, connection);
  if (!within) return within.error();
  auto device = openNow(text, within.value(), admissionFor(client(connection)));
  if (device) noteAsker(**device, client(connection));
  return device;
}

void Core::openDevice(std::string_view text, std::uint64_t connection, DeviceManager::Done done) {
  const auto within = mayOpen(text, connection);
  if (!within) return done(within.error());
  devices_.open(
      text,
      [this, by = client(connection), done = std::move(done)](const Result<OpenDevice*>& device) {
        if (device) noteAsker(*device.value(), by);
        done(device);
      },
      within.value(), admissionFor(client(connection)));
}

/** What a device holds counts for whoever asks for it, until he has left; for the administrator's nobody is charged. */
DeviceManager::Admission Core::admissionFor(const Client& by) const {
  if (by.administration) return {};
  return [this, uid = by.uid, connection = by.connection](const Device& device) -> Result<void> {
    const std::uint64_t bytes = heldBytes(device);
    if (bytes == 0) return {};
    if (!clients_.has(connection)) return Error{ErrorCode::kTimeout, "connection", "the client has left", {}};
    const auto may = checkQuota(uid, bytes, 0);
    if (may) return {};
    return Error{may.error().code, device.info().uri.substr(0, kMostWhere), "its recorded motion: " + may.error().what,
                 "thin the file out, drop meshes or close devices, or raise quotas.memory_mb in the configuration"};
  };
}

const Client* Core::payerOf(const OpenDevice& device) const {
  for (const std::uint64_t asker : device.askers)
    if (!client(asker).administration) return &client(asker);
  return nullptr;
}

std::uint64_t Core::heldBytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& device : devices_.devices()) {
    const Client* const payer = device->asked_for && !device->free ? payerOf(*device) : nullptr;
    if (payer != nullptr && payer->uid == uid) sum += heldBytes(device->device());
  }
  return sum;
}

Result<void> Core::checkQuota(std::uint32_t uid, std::uint64_t bytes, std::uint64_t triangles) const {
  const auto most = static_cast<std::uint64_t>(options_.config.quotas.memory_mb * 1e6);
  const std::uint64_t have = bytesOf(uid);
  if (bytes > most || have > most - bytes) {
    return Error{ErrorCode::kQuotaExceeded, "memory",
                 fmt::format("user {} has {} bytes and wants {} more; {} are allowed", uid, have, bytes, most),
                 "drop meshes or end sessions, or raise quotas.memory_mb in the configuration"};
  }
  const std::uint64_t shown = meshes_.trianglesOf(uid);
  if (shown + triangles > options_.config.quotas.triangles) {
    return Error{ErrorCode::kQuotaExceeded, "triangles",
                 fmt::format("user {} has {} triangles and wants {} more; {} are allowed", uid, shown, triangles,
                             options_.config.quotas.triangles),
                 "drop meshes, or raise quotas.triangles in the configuration"};
  }
  return {};
}

std::uint64_t Core::bytesOf(std::uint32_t uid) const {
  return sessions_.bytesOf(uid) + meshes_.bytesOf(uid) + scene_.textures().bytesOf(uid) + uploads_.bytesOf(uid) +
         recordings_.bytesOf(uid) + heldBytesOf(uid);
}

std::uint64_t Core::lockedBytes() const {
  std::uint64_t held = 0;
  for (const auto& device : devices_.devices()) held += heldBytes(device->device());
  return held + sessions_.bytes() + meshes_.lockedBytes() + scene_.textures().lockedBytes() +
         recordings_.size() * sizeof(CycleLog) + devices_.links().size() * GroupLink::monitorBytes();
}

void Core::publish(EventKind kind, std::string_view device, std::string_view text, std::uint64_t session) noexcept {
  try {
    Event event;
    event.kind = kind;
    event.t_ns = clock_.now();
    event.device = device;
    event.text = text;
    event.session = session;
    events_.publish(event);
  } catch (const std::bad_alloc&) {
    events_.lost(1);
  }
}

}  // namespace hapticd
