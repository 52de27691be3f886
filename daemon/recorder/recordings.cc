#include "daemon/recorder/recordings.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <iterator>
#include <new>

#include "daemon/ipc/snapshot_memory.h"
#include "daemon/log/log.h"
#include "daemon/version.h"
#include "rt/cycle/cycle_start.h"

namespace hapticd {
namespace {

constexpr std::int64_t kServoPatienceNs = 200'000'000;  ///< A servo that has not passed by then is dead.

constexpr const char* kDaemonStops = "the daemon stops";

std::int64_t wallClock() {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

/** As the builder made it, sealed: what every rigid mesh is, and a deformable one that nothing has moved yet. */
Result<Recorder::Mesh> share(const PublishedMesh& mesh) {
  auto fd = duplicate(mesh.fd);
  if (!fd) return fd.error();
  auto file = Memfd::adopt(std::move(*fd));
  if (!file) return file.error();
  auto mapping = file->map(Memfd::Access::kRead);
  if (!mapping) return mapping.error();
  Recorder::Mesh out;
  out.entry = mesh.entry;
  out.shared = std::move(*mapping);
  return out;
}

/** The number of a mesh's file; 0: it has none. */
std::uint64_t numberOf(int fd) {
  struct stat file {};
  return ::fstat(fd, &file) == 0 ? file.st_ino : 0;
}

/** Of a servo that runs: so far as is seen; what it has moved stays so. */
bool hasMoved(GroupLink& link, const PublishedMesh& mesh) {
  return mesh.deformable &&
         std::atomic_ref(link.meshes().get(mesh.entry)->deform.moves).load(std::memory_order_relaxed) != 0;
}

std::vector<PublishedMesh> deformedOf(GroupLink& link, const std::vector<PublishedMesh>& all) {
  std::vector<PublishedMesh> deformed;
  std::ranges::copy_if(all, std::back_inserter(deformed), [&](const auto& mesh) { return hasMoved(link, mesh); });
  return deformed;
}

Error armed(const std::string& device) {
  return {ErrorCode::kInvalidArgument, device, "it is armed, and a recording begins with the group's cycle made anew",
          "disarm it, start the recording, then arm again"};
}

RecordingHeader describe(const GroupLink& link, const DeviceManager& devices) {
  RecordingHeader header;
  header.program = kVersion;
  header.build = realtimeBuild();
  header.instructions = instructionSet();
  header.started_ns = wallClock();
  header.group = link.name();
  for (const auto& device : devices.devices()) {
    if (device->link != &link) continue;
    header.devices.push_back({device->name, device->info().uri, device->info().model});
    header.start.resolution[device->index] = {device->info().position_resolution, device->info().rotation_resolution};
  }
  return header;
}

}  // namespace

Recordings::Recordings(SceneModel& scene, MeshStore& meshes, SessionManager& sessions, bool lock)
    : scene_(scene), meshes_(meshes), sessions_(sessions), lock_(lock) {
  meshes_.onPublish([this](CommandSink& sink, const PublishedMesh& mesh) { published(sink, mesh); });
  scene_.textures().onPublish([this](CommandSink& sink, const PublishedTexture& texture) {
    for (auto& [id, recording] : all_) {
      if (recording.link == &sink && recording.reason.empty()) recording.recorder->add(texture);
    }
  });
}

Recordings::~Recordings() {
  constexpr std::int64_t kPatienceNs = 500'000'000;
  for (auto& [id, recording] : all_) recording.recorder->finish(kDaemonStops);
  const std::int64_t since_ns = clock_.now();
  for (auto& [id, recording] : all_) {
    while (!recording.recorder->done() && clock_.now() - since_ns < kPatienceNs)
      clock_.sleepUntil(clock_.now() + 1'000'000);
  }
}

Result<void> Recordings::mayRecord(const OpenDevice& device, const Client& by) const {
  for (const auto& [id, recording] : all_) {
    if (recording.link == device.link && !isOver(recording)) {
      return Error{ErrorCode::kAlreadyExists, device.name,
                   fmt::format("its group is being recorded by '{}' (pid {})", recording.by.name, recording.by.pid),
                   "wait for its end"};
    }
  }
  for (const Session* session : sessions_.all()) {
    if (by.administration || session->link != device.link || session->client.uid == by.uid) continue;
    return Error{
        ErrorCode::kPermissionDenied, device.name,
        fmt::format("user {} has a session there, and a recording holds what every client sends", session->client.uid),
        "use the administration socket"};
  }
  for (std::uint32_t d = 0; d < device.link->group().deviceCount(); ++d) {
    hd_sample sample{};
    if (device.link->latest(d, sample) && (sample.flags & HD_SAMPLE_ARMED) != 0) return armed(device.name);
  }
  return {};
}

Result<Recordings::Started> Recordings::start(OpenDevice& device, const Client& by, const DeviceManager& devices) {
  if (auto r = mayRecord(device, by); !r) return r.error();
  auto recorder = Recorder::create(lock_);
  if (!recorder) return recorder.error();
  GroupLink& link = *device.link;
  // All that could fail for want of memory comes before the servo has the log.
  std::map<std::uint64_t, Recording> made;
  Recording& recording = made[next_];
  recording.link = &link;
  recording.by = by;
  RecordingHeader header = describe(link, devices);
  header.flush_denormals = link.group().options().threads;
  const std::vector<PublishedMesh> published = meshes_.published(link);
  std::vector<Recorder::Mesh> meshes;
  for (const PublishedMesh& mesh : published) {
    auto shared = share(mesh);
    if (!shared) return shared.error();
    meshes.push_back(std::move(*shared));
  }
  // With pages for what moves change, and what they do not: neither takes time of the servo's.
  for (const PublishedMesh& mesh : deformedOf(link, published)) {
    const auto same = std::ranges::find(meshes, mesh.entry, &Recorder::Mesh::entry);
    same->copy = copyAsBuilt(mesh, same->shared.bytes());
    same->shared = {};
  }
  forgetCopies();
  std::vector<Recorder::Texture> textures;
  Result<void> outcome;
  // Made of orders, as for a servo that has just started, and not a copy of its insides: docs/recording.md says why.
  const auto begin = [&](Servo& servo) {
    const Cycle& former = servo.cycle();
    CycleStart& start = header.start;
    start.config = former.config();
    for (std::uint32_t d = 0; d < start.config.device_count; ++d) {
      if (former.deviceGuard(d).armed()) {
        outcome = armed(device.name);
        return;
      }
      start.config.guard[d].limits = former.deviceGuard(d).limits();
      start.config.guard[d].heat = former.deviceGuard(d).heat();
    }
    std::uint64_t uncopied = 0;
    for (std::size_t i = 0; i < published.size(); ++i)
      uncopied += meshes[i].shared && hasMoved(link, published[i]) ? published[i].bytes.size() : 0;
    if (uncopied >= kLargeBytes) {  // The servo would stand too long.
      outcome = Error{ErrorCode::kWouldBlock, device.name, "meshes are being deformed for the first time", "try again"};
      return;
    }
    for (std::size_t i = 0; i < published.size(); ++i) {
      if (!hasMoved(link, published[i])) continue;
      Recorder::Mesh& to = meshes[i];
      if (to.shared) {  // It moved only since.
        to.copy = copyAsBuilt(published[i], to.shared.bytes());
        to.shared = {};
      }
      copyMoved(published[i].bytes, to.copy);
      to.open = true;
    }
    for (PublishedTexture& texture : scene_.textures().published(link)) textures.push_back({0, std::move(texture)});
    start.tick = servo.lastInput().tick;
    start.now_ns = servo.lastInput().now_ns;
    servo.publishPoses();  // where clients moved things, up to this cycle
    start.orders = scene_.orders(link);
    restate(former, start.now_ns, start.orders);
    const auto cycle = makeCycle(start, link.meshes());
    cycle->tellOn(former);
    servo.replaceCycle(*cycle);
    servo.publishPoses();  // with counts of changes that begin anew
    scene_.madeAnew(link);
    link.forgetSceneOrders();
    servo.log.store(&(*recorder)->log(), std::memory_order_release);
  };
  if (auto r = link.group().betweenCycles(begin); !r) return r.error();
  if (!outcome) return outcome.error();

  Started started{next_++, (*recorder)->takeStream()};
  (*recorder)->begin(std::move(header), std::move(meshes), std::move(textures));
  recording.recorder = std::move(*recorder);
  all_.merge(made);
  log::info("{}: '{}' (pid {}) records it", link.name(), log::printable(by.name), by.pid);
  return started;
}

std::vector<std::byte> Recordings::copyAsBuilt(const PublishedMesh& mesh, std::span<const std::byte> bytes) {
  const auto made = made_.find(numberOf(mesh.fd));
  if (made != made_.end() && made->second.size() == bytes.size()) return std::move(made_.extract(made).mapped());
  return {bytes.begin(), bytes.end()};
}

bool Recordings::ready(OpenDevice& device, const Client& by) {
  GroupLink& link = *device.link;
  if (!mayRecord(device, by)) return true;  // start() says so.
  const std::vector<PublishedMesh> deformed = deformedOf(link, meshes_.published(link));
  if (deformed.empty()) return true;
  if (copies_for_ != nullptr && (copies_for_ != &link || copied_ns_ == 0)) return false;
  if (copies_failed_) return true;
  std::uint64_t bytes = 0;
  std::vector<UniqueFd> files;
  for (const PublishedMesh& mesh : deformed) {
    if (made_.contains(numberOf(mesh.fd))) continue;  // Others may have been moved since.
    auto file = duplicate(mesh.fd);
    if (!file) return true;
    bytes += mesh.bytes.size();
    files.push_back(std::move(*file));
  }
  if (bytes < kLargeBytes) return true;
  (void)copies_.start(
      [files = std::move(files)]() mutable -> Result<Copies> {
        Copies made;
        for (UniqueFd& fd : files) {
          const std::uint64_t number = numberOf(fd.get());
          auto file = Memfd::adopt(std::move(fd));
          if (!file) return file.error();
          const auto mapping = file->map(Memfd::Access::kRead);
          if (!mapping) return mapping.error();
          const auto bytes = mapping->bytes();
          made.emplace(number, std::vector<std::byte>(bytes.begin(), bytes.end()));
        }
        return made;
      },
      [this](Result<Copies> made) {
        copied_ns_ = clock_.now();
        copies_failed_ = !made;  // Then start() makes them.
        if (made) made_.merge(*made);
      });
  copies_for_ = &link;
  copied_ns_ = 0;
  return false;
}

void Recordings::forgetCopies() {
  copies_for_ = nullptr;
  copied_ns_ = 0;
  copies_failed_ = false;
  if (!made_.empty()) (void)copies_.letGo(std::exchange(made_, {}), [] {});
}

void Recordings::endRecording(Recording& recording, const std::string& reason) {
  if (!recording.reason.empty()) return;
  recording.reason = reason;
  recording.ending_since_ns = clock_.now();
  if (recording.link == nullptr) return;
  recording.link->group().servo().log.store(nullptr, std::memory_order_relaxed);
  // The cycle under way may still be writing to the log, the next one is not. Both have ended, and what was written
  // is visible, when cycles() has counted them.
  recording.let_go_after = recording.link->cycles() + 2;
}

bool Recordings::letGo(const Recording& recording) {
  return recording.link == nullptr || recording.link->cycles() >= recording.let_go_after;
}

bool Recordings::isOver(const Recording& recording) {
  return !recording.reason.empty() && letGo(recording) && recording.recorder->done();
}

void Recordings::stop(std::uint64_t id, Done done) {
  const auto it = all_.find(id);
  if (it == all_.end()) return done(RecordingEnd{"it has ended before", 0, 0});
  it->second.done.push_back(std::move(done));
  endRecording(it->second, "stopped");
}

void Recordings::drop(std::uint64_t id) noexcept {
  const auto it = all_.find(id);
  if (it == all_.end()) return;
  it->second.dropped = true;
  it->second.done.clear();
  try {
    endDropped(it->second);
  } catch (const std::bad_alloc&) {  // poll() does.
  }
}

void Recordings::endDropped(Recording& recording) {
  endRecording(recording, stopping_ ? kDaemonStops : "its client has left");
}

void Recordings::sessionOpens(const GroupLink& link, std::uint32_t uid) {
  for (auto& [id, recording] : all_) {
    if (recording.link != &link || recording.by.administration || recording.by.uid == uid) continue;
    endRecording(recording, "another user's session opened on the device");
  }
}

bool Recordings::of(const GroupLink& link) const {
  return std::any_of(all_.begin(), all_.end(), [&](const auto& row) { return row.second.link == &link; });
}

bool Recordings::ends(const GroupLink& link) const {
  return std::any_of(all_.begin(), all_.end(), [&](const auto& row) {
    return row.second.link == &link && !row.second.reason.empty() && !isOver(row.second);
  });
}

void Recordings::groupClosed(const GroupLink& link) {
  for (auto& [id, recording] : all_) {
    if (recording.link != &link) continue;
    recording.link = nullptr;
    endRecording(recording, "the device was closed");
  }
}

void Recordings::poll() {
  constexpr std::int64_t kKept_ns = 1'000'000'000;
  copies_.poll();
  if (copied_ns_ != 0 && clock_.now() - copied_ns_ > kKept_ns) forgetCopies();  // Whoever wanted them has gone.
  for (auto it = all_.begin(); it != all_.end();) {
    Recording& recording = it->second;
    Recorder& recorder = *recording.recorder;
    if (recording.reason.empty() && recorder.done()) endRecording(recording, recorder.end().reason);
    if (recording.dropped && recording.reason.empty()) endDropped(recording);
    const bool let_go = !recording.reason.empty() && letGo(recording);
    const bool servo_dead = !recording.reason.empty() && clock_.now() - recording.ending_since_ns > kServoPatienceNs;
    if (let_go || servo_dead) recorder.finish(recording.reason);
    if (recorder.done()) {
      for (const Done& done : std::exchange(recording.done, {})) done(recorder.end());
    }
    const bool over = isOver(recording) && recording.dropped;  // the log goes only when the servo has
    if (over) log::info("a recording of {} cycles has ended: {}", recorder.end().cycles, recorder.end().reason);
    it = over ? all_.erase(it) : std::next(it);
  }
}

void Recordings::published(CommandSink& sink, const PublishedMesh& mesh) {
  for (auto& [id, recording] : all_) {
    if (recording.link != &sink || !recording.reason.empty()) continue;
    if (auto kept = share(mesh)) {
      recording.recorder->add(std::move(*kept));
    } else {
      endRecording(recording, toString(kept.error()));
    }
  }
}

std::uint64_t Recordings::bytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& [id, recording] : all_) sum += recording.by.uid == uid ? sizeof(CycleLog) : 0;
  return sum;
}

}  // namespace hapticd
