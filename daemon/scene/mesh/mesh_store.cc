#include "daemon/scene/mesh/mesh_store.h"

#include <sys/stat.h>

#include <algorithm>
#include <new>
#include <utility>

#include "rt/scene/vertex_motion.h"

namespace hapticd {

namespace {

enum class Spare { kNone, kAsked, kAnswered };

}  // namespace

/** A rigid mesh is one mapping for all servos, under nullptr; of a deformable one each servo has a copy. */
struct MeshStore::Entry : ShelfEntry<MeshInfo, std::unique_ptr<SnapshotMemory>> {
  UniqueFd fd;
  std::vector<std::unique_ptr<SnapshotMemory>> fresh;  ///< Of a deformable one, for servos that come.
  Spare spare = Spare::kNone;                          ///< Whether one more was asked for, which may have failed.
  std::unique_ptr<VolumeMemory> volume;                ///< Null: none.
};

MeshStore::MeshStore()
    : shelf_(std::make_unique<Shelf<Entry, kMaxMeshes>>(
          ShelfWords{"mesh", "meshes", "objects", "remove them or give them another shape first"})) {}
MeshStore::~MeshStore() = default;

Result<CheckedMesh> checkMesh(UniqueFd snapshot, UniqueFd volume, bool lock, std::size_t servos) {
  CheckedMesh mesh;
  std::size_t wanted = 1;
  while (mesh.memory.size() < wanted) {
    auto shared = duplicate(snapshot.get());
    if (!shared) return shared.error();
    auto memory = mesh.memory.empty() ? openSnapshot(std::move(*shared), lock)
                                      : copySnapshot(std::move(*shared), *mesh.memory.front(), lock);
    if (!memory) return memory.error();
    if ((memory->view.flags & HD_MESH_DEFORMABLE) != 0) wanted = std::max<std::size_t>(1, servos);
    mesh.memory.push_back(std::make_unique<SnapshotMemory>(std::move(*memory)));
  }
  mesh.fd = std::move(snapshot);
  if (!volume.valid()) return mesh;
  auto opened = openVolume(std::move(volume), lock);
  if (!opened) return opened.error();
  mesh.volume = std::make_unique<VolumeMemory>(std::move(*opened));
  return mesh;
}

Result<std::uint64_t> MeshStore::add(UniqueFd snapshot, UniqueFd volume, MeshInfo info) {
  auto mesh = checkMesh(std::move(snapshot), std::move(volume), lock_, servos());
  if (!mesh) return mesh.error();
  return add(std::move(*mesh), std::move(info));
}

Result<std::uint64_t> MeshStore::add(CheckedMesh mesh, MeshInfo info) {
  if (auto room = shelf_->room(info.owner); !room) return room.error();
  auto entry = std::make_unique<Entry>();
  const SnapshotMemory& memory = *mesh.memory.front();
  const MeshView& view = memory.view;
  const auto* header = memory.mapping.as<const hd_snapshot_header>();
  info.vertices = view.vertex_count;
  info.triangles = view.triangle_count;
  info.closed = (view.flags & HD_MESH_CLOSED) != 0;
  info.deformable = (view.flags & HD_MESH_DEFORMABLE) != 0;
  info.bytes = memory.mapping.size() + memory.motion.size();
  if (mesh.volume != nullptr) {
    entry->volume = std::move(mesh.volume);
    info.bytes += entry->volume->mapping.size();
    info.voxel = double{entry->volume->view.voxel};
  }
  for (int i = 0; i < 3; ++i) {
    info.lower[i] = header->lower[i];
    info.upper[i] = header->upper[i];
  }
  entry->info = std::move(info);
  entry->fd = std::move(mesh.fd);
  if (entry->info.deformable) {
    entry->fresh = std::move(mesh.memory);
  } else {
    entry->copies[nullptr] = std::move(mesh.memory.front());
  }
  const VolumeView* own = entry->volume != nullptr ? &entry->volume->view : nullptr;
  auto id = shelf_->put(
      std::move(entry), [&](std::uint32_t index, CommandSink& sink) { return publish(index, sink); },
      [&](std::uint32_t index) { unpublish(index); });
  if (id) giveBackFresh(*shelf_->find(*id));  // A servo has gone meanwhile, or there is none.
  if (id && own != nullptr) volumes_.publish(shelf_->indexOf(*id), own);
  return id;
}

Result<void> MeshStore::publish(std::uint32_t index, CommandSink& sink) {
  Entry& entry = *shelf_->entries()[index];
  SnapshotMemory* memory = nullptr;
  if (entry.info.deformable) {
    auto own = copyFor(entry);
    if (!own) return own.error();
    memory = entry.copies.insert_or_assign(&sink, std::move(*own)).first->second.get();
  } else {
    memory = entry.copies.at(nullptr).get();
  }
  sink.meshes().publish(index, &memory->view);
  if (published_) published_(sink, describe(index, sink));
  return {};
}

/** One that was made aside; else, for a servo that came in between, made now. */
Result<std::unique_ptr<SnapshotMemory>> MeshStore::copyFor(Entry& entry) const {
  if (!entry.fresh.empty()) {
    auto made = std::move(entry.fresh.back());
    entry.fresh.pop_back();
    return made;
  }
  auto fd = duplicate(entry.fd.get());
  if (!fd) return fd.error();
  auto copy = entry.copies.empty() ? openSnapshot(std::move(*fd), lock_)
                                   : copySnapshot(std::move(*fd), *entry.copies.begin()->second, lock_);
  if (!copy) return copy.error();
  return std::make_unique<SnapshotMemory>(std::move(*copy));
}

bool MeshStore::readyForServo() {
  bool ready = true;
  std::uint64_t at_once = 0;  ///< In attach().
  for (const auto& entry : shelf_->entries()) {
    if (entry == nullptr || entry->dropped || !entry->info.deformable) continue;
    at_once += entry->info.bytes;
    if (at_once < kLargeBytes) continue;
    at_once -= entry->info.bytes;
    if (entry->spare == Spare::kNone && entry->fresh.empty()) copyAside(*entry);
    ready = ready && entry->spare != Spare::kAsked;
  }
  return ready;
}

/** Of the file: what the servos' copies hold may go meanwhile. What fails then fails once more in attach(), which
 * tells. */
void MeshStore::copyAside(Entry& entry) {
  auto fd = duplicate(entry.fd.get());
  entry.spare = fd ? Spare::kAsked : Spare::kAnswered;
  if (!fd) return;
  aside_.start([fd = std::move(*fd), lock = lock_]() mutable { return openSnapshot(std::move(fd), lock); },
               [this, id = entry.info.id](Result<SnapshotMemory> copy) {
                 Entry* const asked = shelf_->find(id);
                 if (asked != nullptr) asked->spare = Spare::kAnswered;
                 if (!copy) return;
                 auto made = std::make_unique<SnapshotMemory>(std::move(*copy));
                 if (asked != nullptr) return asked->fresh.push_back(std::move(made));
                 giveBack(std::move(made), kLargeBytes);  // Dropped meanwhile.
               });
}

void MeshStore::noServoComes() {
  std::vector<std::unique_ptr<SnapshotMemory>> gone;
  std::uint64_t bytes = 0;
  for (const auto& entry : shelf_->entries()) {
    if (entry == nullptr) continue;
    entry->spare = Spare::kNone;
    for (auto& copy : std::exchange(entry->fresh, {})) {
      bytes += entry->info.bytes;
      gone.push_back(std::move(copy));
    }
  }
  giveBack(std::move(gone), bytes);
}

void MeshStore::giveBackFresh(Entry& entry) {
  for (auto& copy : std::exchange(entry.fresh, {})) giveBack(std::move(copy), entry.info.bytes);
}

/** What has many pages, also of many things, takes its time to go. */
template <class Memory>
void MeshStore::giveBack(Memory memory, std::uint64_t bytes) {
  if (bytes >= kLargeBytes) (void)aside_.letGo(std::move(memory), [] {});
}

std::size_t MeshStore::servos() const { return shelf_->sinks().size(); }

PublishedMesh MeshStore::describe(std::uint32_t index, CommandSink& sink) const {
  const Entry& entry = *shelf_->entries()[index];
  const auto& memory = entry.copies.at(entry.info.deformable ? &sink : nullptr);
  return {index, entry.info.deformable, memory->mapping.bytes(), entry.fd.get()};
}

std::vector<PublishedMesh> MeshStore::published(CommandSink& sink) const {
  std::vector<PublishedMesh> out;
  for (std::uint32_t i = 0; i < kMaxMeshes; ++i) {
    if (shelf_->entries()[i] != nullptr && sink.meshes().get(i) != nullptr) out.push_back(describe(i, sink));
  }
  return out;
}

void MeshStore::unpublish(std::uint32_t index) {
  volumes_.publish(index, nullptr);
  for (CommandSink* sink : shelf_->sinks()) sink->meshes().publish(index, nullptr);
}

Result<void> MeshStore::room(const Client& by) const { return shelf_->room(by); }

Result<void> MeshStore::drop(std::uint64_t id, const Client& by) { return shelf_->drop(id, by); }

void MeshStore::dropUnusedOf(std::uint64_t connection) { shelf_->dropUnusedOf(connection); }

const MeshInfo* MeshStore::find(std::uint64_t id) const {
  const Entry* entry = shelf_->find(id);
  return entry == nullptr ? nullptr : &entry->info;
}

std::vector<const MeshInfo*> MeshStore::list() const { return shelf_->list(); }

std::uint64_t MeshStore::bytesFor(const UniqueFd& snapshot, const UniqueFd& volume) const {
  const auto sizeOf = [](const UniqueFd& fd) {
    struct stat s {};
    return fd.valid() && ::fstat(fd.get(), &s) == 0 ? static_cast<std::uint64_t>(s.st_size) : 0;
  };
  std::uint64_t bytes = sizeOf(snapshot) + sizeOf(volume);
  hd_snapshot_header head{};
  if (::pread(snapshot.get(), &head, sizeof head, 0) != static_cast<ssize_t>(sizeof head)) return bytes;
  if ((head.flags & HD_MESH_DEFORMABLE) == 0) return bytes;
  bytes += head.vertex_count * sizeof(VertexMotion);
  return bytes * std::max<std::size_t>(1, shelf_->sinks().size());  // Each servo has its own.
}

std::uint32_t MeshStore::entryOf(std::uint64_t id) const {
  const std::uint32_t index = shelf_->indexOf(id);
  return index == kMaxMeshes ? 0 : index;
}

std::uint64_t MeshStore::lockedBytes() const { return shelf_->lockedBytes(); }

std::uint64_t MeshStore::bytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& entry : shelf_->entries()) {
    if (entry != nullptr && entry->info.owner.uid == uid)
      sum += entry->info.bytes * std::max<std::size_t>(1, entry->copies.size());
  }
  return sum;
}

std::uint64_t MeshStore::trianglesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const MeshInfo* info : shelf_->list()) {
    if (info->owner.uid == uid) sum += info->triangles;
  }
  return sum;
}

void MeshStore::use(std::uint64_t id) { shelf_->use(id); }

void MeshStore::release(std::uint64_t id) { shelf_->release(id); }

Result<void> MeshStore::attach(CommandSink& sink) {
  auto attached = shelf_->attach(sink, [&](std::uint32_t index, CommandSink& s) { return publish(index, s); });
  for (const auto& entry : shelf_->entries())
    if (entry != nullptr) entry->spare = Spare::kNone;  // The next one needs its own.
  return attached;
}

void MeshStore::detach(CommandSink& sink) {
  std::vector<std::unique_ptr<SnapshotMemory>> gone;
  std::uint64_t bytes = 0;
  try {
    gone.reserve(kMaxMeshes);
    for (const auto& entry : shelf_->entries()) {
      if (entry == nullptr) continue;
      const auto own = entry->copies.find(&sink);
      if (own == entry->copies.end()) continue;
      bytes += entry->info.bytes;
      gone.push_back(std::move(own->second));
    }
  } catch (const std::bad_alloc&) {  // Then here.
  }
  shelf_->detach(sink);
  giveBack(std::move(gone), bytes);
}

void MeshStore::reclaim() {
  aside_.poll();
  std::vector<std::unique_ptr<Entry>> gone;
  std::uint64_t bytes = 0;
  shelf_->reclaim([&](std::uint32_t index) { unpublish(index); },
                  [&](std::unique_ptr<Entry> entry) {
                    bytes += entry->info.bytes;
                    gone.push_back(std::move(entry));
                  });
  giveBack(std::move(gone), bytes);
}

}  // namespace hapticd
