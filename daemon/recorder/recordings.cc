#include "daemon/recorder/recordings.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
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

/** A rigid mesh is shared and sealed; a deformable one is copied as it is now, unless nothing has moved it yet. */
Result<Recorder::Mesh> keep(const PublishedMesh& mesh, bool fresh) {
  Recorder::Mesh out;
  out.entry = mesh.entry;
  if (!mesh.deformable || fresh) {
    auto fd = duplicate(mesh.fd);
    if (!fd) return fd.error();
    auto file = Memfd::adopt(std::move(*fd));
    if (!file) return file.error();
    auto mapping = file->map(Memfd::Access::kRead);
    if (!mapping) return mapping.error();
    out.shared = std::move(*mapping);
    return out;
  }
  out.copy = copyDeformed(mesh.bytes);
  return out;
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
  std::vector<Recorder::Mesh> meshes;
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
    for (const PublishedMesh& mesh : meshes_.published(link)) {
      auto kept = keep(mesh, false);
      if (!kept) {
        outcome = kept.error();
        return;
      }
      meshes.push_back(std::move(*kept));
    }
    for (PublishedTexture& texture : scene_.textures().published(link)) textures.push_back({0, std::move(texture)});
    start.tick = servo.lastInput().tick;
    start.now_ns = servo.lastInput().now_ns;
    servo.publishPoses();  // where clients moved things, up to this cycle
    start.orders = scene_.orders(start.config.period_ns);
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
    if (auto kept = keep(mesh, true)) {
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
