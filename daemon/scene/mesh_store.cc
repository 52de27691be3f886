#include "daemon/scene/mesh_store.h"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/snapshot_memory.h"
#include "daemon/volume_memory.h"

namespace hapticd {

/** One entry of the mesh tables. A rigid mesh is one mapping for all servos; a deformable one has a copy for each. */
struct MeshStore::Entry {
  MeshInfo info;
  UniqueFd fd;
  std::map<CommandSink*, std::unique_ptr<SnapshotMemory>> copies;  ///< Under nullptr: the shared one.
  std::unique_ptr<VolumeMemory> volume;                            ///< Null: none.
  bool dropped = false;
  std::map<CommandSink*, std::uint64_t> waits_for;  ///< Ticket each servo has to pass before the memory goes.
};

MeshStore::MeshStore() = default;
MeshStore::~MeshStore() = default;

Result<std::uint64_t> MeshStore::add(UniqueFd snapshot, UniqueFd volume, MeshInfo info) {
  const auto free = std::find(entries_.begin(), entries_.end(), nullptr);
  if (free == entries_.end()) {
    return Error{ErrorCode::kQuotaExceeded, "mesh", fmt::format("the daemon holds {} meshes, its most", kMaxMeshes),
                 "drop meshes that no object shows"};
  }
  auto entry = std::make_unique<Entry>();
  auto shared = duplicate(snapshot.get());
  if (!shared) return shared.error();
  auto memory = openSnapshot(std::move(*shared), lock_);
  if (!memory) return memory.error();
  const MeshView& view = memory->view;
  const auto* header = memory->mapping.as<const hd_snapshot_header>();
  info.vertices = view.vertex_count;
  info.triangles = view.triangle_count;
  info.closed = (view.flags & HD_MESH_CLOSED) != 0;
  info.deformable = (view.flags & HD_MESH_DEFORMABLE) != 0;
  info.bytes = memory->mapping.size();
  if (volume.valid()) {
    auto opened = openVolume(std::move(volume), lock_);
    if (!opened) return opened.error();
    entry->volume = std::make_unique<VolumeMemory>(std::move(*opened));
    info.bytes += entry->volume->mapping.size();
    info.voxel = double{entry->volume->view.voxel};
  }
  for (int i = 0; i < 3; ++i) {
    info.lower[i] = header->lower[i];
    info.upper[i] = header->upper[i];
  }
  info.id = next_id_;
  info.uses = 0;
  entry->info = std::move(info);
  entry->fd = std::move(snapshot);
  const bool deformable = entry->info.deformable;
  if (!deformable) entry->copies.emplace(nullptr, std::make_unique<SnapshotMemory>(std::move(*memory)));

  const auto index = static_cast<std::uint32_t>(free - entries_.begin());
  *free = std::move(entry);
  if (const auto& own = (*free)->volume) volumes_.publish(index, &own->view);
  for (CommandSink* sink : sinks_) {
    if (auto r = publish(index, *sink); !r) {
      unpublish(index);
      entries_[index].reset();  // no order names it yet
      return r.error();
    }
  }
  by_id_.emplace(next_id_, index);
  return next_id_++;
}

Result<void> MeshStore::publish(std::uint32_t index, CommandSink& sink) {
  Entry& entry = *entries_[index];
  SnapshotMemory* memory = nullptr;
  if (entry.info.deformable) {
    auto fd = duplicate(entry.fd.get());
    if (!fd) return fd.error();
    auto copy = openSnapshot(std::move(*fd), lock_);
    if (!copy) return copy.error();
    memory =
        entry.copies.insert_or_assign(&sink, std::make_unique<SnapshotMemory>(std::move(*copy))).first->second.get();
  } else {
    memory = entry.copies.at(nullptr).get();
  }
  sink.meshes().publish(index, &memory->view);
  if (published_) published_(sink, describe(index, sink));
  return {};
}

PublishedMesh MeshStore::describe(std::uint32_t index, CommandSink& sink) const {
  const Entry& entry = *entries_[index];
  const auto& memory = entry.copies.at(entry.info.deformable ? &sink : nullptr);
  return {index, entry.info.deformable, memory->mapping.bytes(), entry.fd.get()};
}

std::vector<PublishedMesh> MeshStore::published(CommandSink& sink) const {
  std::vector<PublishedMesh> out;
  for (std::uint32_t i = 0; i < kMaxMeshes; ++i) {
    if (entries_[i] != nullptr && sink.meshes().get(i) != nullptr) out.push_back(describe(i, sink));
  }
  return out;
}

void MeshStore::unpublish(std::uint32_t index) {
  volumes_.publish(index, nullptr);
  for (CommandSink* sink : sinks_) sink->meshes().publish(index, nullptr);
}

Result<void> MeshStore::drop(std::uint64_t id, const Client& by) {
  const auto it = by_id_.find(id);
  if (it == by_id_.end()) {
    return Error{ErrorCode::kNotFound, "mesh", fmt::format("there is no mesh {}", id),
                 "hapticctl get /meshes lists them"};
  }
  Entry& entry = *entries_[it->second];
  if (entry.info.owner.uid != by.uid && !by.administration) {
    return Error{ErrorCode::kPermissionDenied, "mesh",
                 fmt::format("mesh {} belongs to user {}", id, entry.info.owner.uid), "use the administration socket"};
  }
  if (entry.info.uses != 0) {
    return Error{ErrorCode::kInvalidArgument, "mesh",
                 fmt::format("mesh {} is shown by {} objects", id, entry.info.uses),
                 "remove them or give them another shape first"};
  }
  entry.dropped = true;
  for (CommandSink* sink : sinks_) entry.waits_for[sink] = sink->posted();
  by_id_.erase(it);
  return {};
}

void MeshStore::dropUnusedOf(std::uint64_t connection) {
  std::vector<std::uint64_t> ids;
  for (const auto& [id, index] : by_id_) {
    MeshInfo& info = entries_[index]->info;
    if (info.owner.connection == connection) ids.push_back(id);
  }
  for (const std::uint64_t id : ids) {
    Entry& entry = *entries_[by_id_.at(id)];
    entry.info.owner.connection = 0;  // its maker has left: it goes with its last object
    if (entry.info.uses == 0) (void)drop(id, entry.info.owner);
  }
}

const MeshInfo* MeshStore::find(std::uint64_t id) const {
  const auto it = by_id_.find(id);
  return it == by_id_.end() ? nullptr : &entries_[it->second]->info;
}

std::vector<const MeshInfo*> MeshStore::list() const {
  std::vector<const MeshInfo*> all;
  for (const auto& [id, index] : by_id_) all.push_back(&entries_[index]->info);
  return all;
}

std::uint32_t MeshStore::entryOf(std::uint64_t id) const {
  const auto it = by_id_.find(id);
  return it == by_id_.end() ? 0 : it->second;
}

std::uint64_t MeshStore::lockedBytes() const {
  std::uint64_t sum = 0;
  for (const auto& entry : entries_) {
    if (entry != nullptr) sum += entry->info.bytes * entry->copies.size();
  }
  return sum;
}

std::uint64_t MeshStore::bytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& entry : entries_) {
    if (entry != nullptr && entry->info.owner.uid == uid)
      sum += entry->info.bytes * std::max<std::size_t>(1, entry->copies.size());
  }
  return sum;
}

std::uint64_t MeshStore::trianglesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& [id, index] : by_id_) {
    if (entries_[index]->info.owner.uid == uid) sum += entries_[index]->info.triangles;
  }
  return sum;
}

void MeshStore::use(std::uint64_t id) {
  if (const auto it = by_id_.find(id); it != by_id_.end()) ++entries_[it->second]->info.uses;
}

void MeshStore::release(std::uint64_t id) {
  const auto it = by_id_.find(id);
  if (it == by_id_.end()) return;
  MeshInfo& info = entries_[it->second]->info;
  if (info.uses > 0) --info.uses;
  if (info.uses == 0 && info.owner.connection == 0) (void)drop(id, info.owner);
}

Result<void> MeshStore::attach(CommandSink& sink) {
  for (std::uint32_t i = 0; i < kMaxMeshes; ++i) {
    if (entries_[i] == nullptr || entries_[i]->dropped) continue;
    if (auto r = publish(i, sink); !r) {
      for (auto& entry : entries_) {
        if (entry != nullptr) entry->copies.erase(&sink);
      }
      return r;
    }
  }
  sinks_.push_back(&sink);
  return {};
}

void MeshStore::detach(CommandSink& sink) {
  sinks_.erase(std::remove(sinks_.begin(), sinks_.end(), &sink), sinks_.end());
  for (auto& entry : entries_) {
    if (entry == nullptr) continue;
    entry->copies.erase(&sink);
    entry->waits_for.erase(&sink);
  }
}

void MeshStore::reclaim() {
  for (std::uint32_t i = 0; i < kMaxMeshes; ++i) {
    Entry* entry = entries_[i].get();
    if (entry == nullptr || !entry->dropped) continue;
    const bool all = std::all_of(entry->waits_for.begin(), entry->waits_for.end(),
                                 [](const auto& wait) { return wait.first->passed(wait.second); });
    if (!all) continue;
    unpublish(i);
    entries_[i].reset();
  }
}

}  // namespace hapticd
