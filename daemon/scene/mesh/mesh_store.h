/** @file
 * Built meshes: mapped, checked, locked and published to the servos; given back once every servo has passed.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/ipc/snapshot_memory.h"
#include "daemon/ipc/unique_fd.h"
#include "daemon/ipc/volume_memory.h"
#include "daemon/scene/command_sink.h"
#include "daemon/scene/object.h"
#include "daemon/scene/upload/aside.h"
#include "daemon/scene/upload/shelf.h"
#include "rt/volume/volume_table.h"

namespace hapticd {

/** What the builder says of a mesh, and who made it. */
struct MeshInfo {
  std::uint64_t id = 0;
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
  std::uint64_t bytes = 0;                          ///< With its volume.
  double voxel = 0;                                 ///< Side of its volume's voxels [m]; 0: it has no volume.
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();  ///< Bounding box [m].
  bool closed = false;
  bool deformable = false;
  std::vector<std::string> notes;  ///< Repairs, each naming its triangle.
  std::int64_t build_ns = 0;
  std::uint32_t uses = 0;  ///< Objects that show it.
  Client owner;
  std::string cache_key;  ///< Of its volume (volume_cache.h); empty: it has none there.
};

/** What the builder made, checked to the last index, mapped and locked. */
struct CheckedMesh {
  UniqueFd fd;                                          ///< Of the snapshot, from which deformable ones are copied.
  std::vector<std::unique_ptr<SnapshotMemory>> memory;  ///< One; of a deformable mesh one for each servo.
  std::unique_ptr<VolumeMemory> volume;                 ///< Null: none.
};
/**
 * Checks seals and every index, and copies what each of so many servos needs for itself; of a large mesh that takes 0.1
 * s and more. Any thread. `volume` may be invalid: none.
 */
[[nodiscard]] Result<CheckedMesh> checkMesh(UniqueFd snapshot, UniqueFd volume, bool lock, std::size_t servos);

/** A mesh as one servo reads it. */
struct PublishedMesh {
  std::uint32_t entry = 0;  ///< Of the servo's mesh table.
  bool deformable = false;  ///< Then `bytes` are this servo's own, and it writes them.
  std::span<const std::byte> bytes;
  int fd = -1;  ///< The sealed snapshot as the builder made it.
};

/** Control thread only. */
class MeshStore {
 public:
  MeshStore();
  ~MeshStore();

  /** Whether what the servos read must be locked (it may not be under --allow-no-rt). */
  void setLock(bool lock) { lock_ = lock; }
  [[nodiscard]] bool locks() const { return lock_; }
  /** Servos that read what is here. */
  [[nodiscard]] std::size_t servos() const;

  /** kQuotaExceeded where that user may have no more. */
  [[nodiscard]] Result<void> room(const Client& by) const;
  /** Publishes it to every servo. Counts, box, flags and size of `info` are read from the snapshot itself. */
  [[nodiscard]] Result<std::uint64_t> add(CheckedMesh mesh, MeshInfo info);
  /** The same of what is to be checked first. */
  [[nodiscard]] Result<std::uint64_t> add(UniqueFd snapshot, UniqueFd volume, MeshInfo info);
  [[nodiscard]] Result<std::uint64_t> add(UniqueFd snapshot, MeshInfo info) {
    return add(std::move(snapshot), UniqueFd(), std::move(info));
  }
  /** Refused while an object shows it. */
  [[nodiscard]] Result<void> drop(std::uint64_t id, const Client& by);
  /** The meshes of a connection that no object shows. */
  void dropUnusedOf(std::uint64_t connection);

  [[nodiscard]] const MeshInfo* find(std::uint64_t id) const;
  [[nodiscard]] std::vector<const MeshInfo*> list() const;
  /** What add() would count for that snapshot and volume [bytes]; by their sizes and the flags, which it then checks.
   */
  [[nodiscard]] std::uint64_t bytesFor(const UniqueFd& snapshot, const UniqueFd& volume) const;
  /** Entry of the mesh tables. */
  [[nodiscard]] std::uint32_t entryOf(std::uint64_t id) const;
  /** Which entries have a volume; for the threads beside the servos. */
  [[nodiscard]] const VolumeTable& volumes() const { return volumes_; }
  [[nodiscard]] std::uint64_t lockedBytes() const;
  [[nodiscard]] std::uint64_t bytesOf(std::uint32_t uid) const;
  [[nodiscard]] std::uint64_t trianglesOf(std::uint32_t uid) const;

  // By the scene model.
  void use(std::uint64_t id);
  void release(std::uint64_t id);
  /**
   * Whether attach() would be quick: a servo needs deformable meshes for itself, and of large ones, or many, this has
   * copies made on a thread aside. Where it is false, ask again after reclaim().
   */
  [[nodiscard]] bool readyForServo();
  /** The servo does not come, and no other is on its way: what was made aside for it goes. */
  void noServoComes();
  /** Publishes every mesh to a new sink, before the scene is replayed to it. */
  [[nodiscard]] Result<void> attach(CommandSink& sink);
  void detach(CommandSink& sink);

  /** What stands in that servo's table. */
  [[nodiscard]] std::vector<PublishedMesh> published(CommandSink& sink) const;
  /** Told of each mesh when it is published, before any order can name it. */
  void onPublish(std::function<void(CommandSink&, const PublishedMesh&)> f) { published_ = std::move(f); }

  /** Unmaps what every servo has passed, what is large aside. Call every few milliseconds. */
  void reclaim();
  /** Whether something is made or unmapped aside. */
  [[nodiscard]] bool busy() const { return aside_.size() != 0; }

 private:
  struct Entry;
  Result<std::unique_ptr<SnapshotMemory>> copyFor(Entry& entry) const;
  void copyAside(Entry& entry);
  template <class Memory>
  void giveBack(Memory memory, std::uint64_t bytes);
  void giveBackFresh(Entry& entry);
  Result<void> publish(std::uint32_t index, CommandSink& sink);
  void unpublish(std::uint32_t index);
  [[nodiscard]] PublishedMesh describe(std::uint32_t index, CommandSink& sink) const;

  bool lock_ = true;
  std::unique_ptr<Shelf<Entry, kMaxMeshes>> shelf_;
  VolumeTable volumes_;
  std::function<void(CommandSink&, const PublishedMesh&)> published_;
  Aside aside_;  // last: its thread ends first
};

}  // namespace hapticd
