/** @file
 * Meshes and textures on their way in: the daemon's memfd that a client fills, its freezing, its build, its place in
 * the store.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "daemon/ipc/memfd.h"
#include "daemon/leash/builder_leash.h"
#include "daemon/scene/mesh/mesh_store.h"
#include "daemon/scene/mesh/volume_cache.h"
#include "daemon/scene/texture/texture_store.h"
#include "daemon/scene/upload/aside.h"

namespace hapticd {

/** Control thread only. */
class Uploads {
 public:
  static constexpr std::size_t kPerUser = 16;    ///< Under way at a time: each holds descriptors of ours.
  static constexpr std::size_t kMostGoing = 64;  ///< Descriptors on their way to be closed; more are closed at once.
  using Progress = std::function<void(float fraction, const std::string& stage)>;
  using Done = std::function<void(Result<MeshInfo>)>;
  using TextureDone = std::function<void(Result<std::uint64_t>)>;
  /** Says whether a user may take so many more bytes and triangles. */
  using Quota = std::function<Result<void>(std::uint32_t uid, std::uint64_t bytes, std::uint64_t triangles)>;

  Uploads(MeshStore& meshes, TextureStore& textures, Quota quota)
      : meshes_(meshes), textures_(textures), quota_(std::move(quota)) {}
  ~Uploads() {
    if (cache_ != nullptr) cache_->stop();  // First: what is aside may be reading from a slow disk.
  }

  /** The builder, or why there is none. */
  void setBuilder(std::unique_ptr<BuilderLeash> builder, std::string why_not = {});
  /** Where built volumes are kept on disk; null: nowhere. */
  void setCache(std::unique_ptr<VolumeCache> cache) { cache_ = std::move(cache); }
  /** Null: none. */
  [[nodiscard]] VolumeCache* cache() const { return cache_.get(); }
  /** A mesh's volume as an OpenVDB file, for its maker's user or administration; see VolumeCache::openVdb(). */
  [[nodiscard]] Result<UniqueFd> volumeFile(const MeshInfo& mesh, const Client& by) const;
  [[nodiscard]] const BuilderLeash* builder() const { return builder_.get(); }
  [[nodiscard]] const std::string& builderNote() const { return note_; }

  /** A memfd of `bytes` for the client to fill. Size and quota are checked before it is made. */
  [[nodiscard]] Result<std::uint64_t> begin(std::uint64_t bytes, const Client& by);
  [[nodiscard]] Result<UniqueFd> region(std::uint64_t id) const;
  /** kStillMapped while the client has it mapped; it may try again. `done` is called once, from poll() or at once. */
  [[nodiscard]] Result<void> commit(std::uint64_t id, Progress progress, Done done);
  /** What was filled is a texture (proto/texture.h). As commit(); what `done` is told has ended the upload. */
  [[nodiscard]] Result<void> commitTexture(std::uint64_t id, TextureDone done);
  /**
   * Forgets the upload; a build under way is cancelled and `done` not called. What is large, or worked on aside, counts
   * until a thread has let go of it.
   */
  void cancel(std::uint64_t id) noexcept;
  /**
   * Closes what may be the last descriptor of large memory, aside; `gone` is called when that is done, now or by a
   * later poll(). Copying `gone` must not throw.
   */
  template <class Gone>
  void close(UniqueFd file, Gone gone) noexcept {
    if (isLarge(file.get()) && going_.size() < kMostGoing) {
      if (going_.letGo(std::move(file), gone)) return;  // Else it went here.
    } else {
      file.reset();
    }
    gone();
  }

  /** Takes what the builder says, and what has been checked aside. Call every few milliseconds. */
  void poll();
  /** Something is checked, or goes, aside. */
  [[nodiscard]] bool busy() const { return aside_.size() != 0 || going_.size() != 0; }
  [[nodiscard]] Aside& aside() { return aside_; }
  /** Where large memory goes that nobody needs any more, so that it waits for no check. */
  [[nodiscard]] Aside& going() { return going_; }

  [[nodiscard]] std::uint64_t bytesOf(std::uint32_t uid) const;
  [[nodiscard]] std::size_t size() const { return uploads_.size(); }

 private:
  struct Upload {
    Memfd file;
    Client by;
    std::uint64_t counts = 0;  ///< For its user: what it is, or is to become [bytes].
    bool committed = false;
    std::uint64_t aside = 0;  ///< Job of a thread of ours, which has its memory; 0: none.
    bool cancelled = false;   ///< Nobody waits for it; it counts until its memory has gone.
    std::uint64_t job = 0;    ///< Of the builder; 0: none.
    Progress progress;
    Done done;
    TextureDone texture_done;
    std::string cache_key;  ///< Empty: not to be kept on disk.
  };
  [[nodiscard]] Result<void> freeze(std::uint64_t id);
  /** Null: it is cancelled. */
  [[nodiscard]] Upload* find(std::uint64_t id);
  [[nodiscard]] static bool isLarge(int fd) noexcept;
  /** It is over; its memory goes. */
  [[nodiscard]] Upload take(std::uint64_t id);
  /** Its memory goes, with what else there is of it, and then itself. */
  template <class... More>
  void forget(std::uint64_t id, More... more) noexcept;
  /** Tells so; what there is of it goes. */
  template <class... More>
  void fail(std::uint64_t id, const Error& why, More... more);
  /** Goes on with it; for want of memory it fails. */
  template <class Step>
  void step(std::uint64_t id, Step&& go_on);
  /** Has `work` done aside; `tell` gets its upload and what it gave, if the upload is not cancelled meanwhile. */
  template <class Work, class Tell>
  void startAside(std::uint64_t id, Work work, Tell tell);
  void finish(std::uint64_t id, BuildReport& report);
  /** Looks whether it was built before; has it built if not. */
  void lookUp(std::uint64_t id);
  void build(std::uint64_t id);
  /** A build, new or from the cache, on its way to the store. */
  void check(std::uint64_t id, CachedBuild built, MeshInfo info, bool cached);
  /** A mesh with what of it is to be kept on disk. */
  struct Checked {
    CheckedMesh mesh;
    CachedBuild kept;
  };
  [[nodiscard]] Result<MeshInfo> adopt(Checked& checked, MeshInfo info, std::uint64_t bytes);
  void layOut(std::uint64_t id, Texture texture);

  MeshStore& meshes_;
  TextureStore& textures_;
  Quota quota_;
  std::unique_ptr<BuilderLeash> builder_;
  std::unique_ptr<VolumeCache> cache_;
  std::string note_ = "not started";
  std::map<std::uint64_t, Upload> uploads_;
  std::uint64_t next_ = 1;
  Aside going_;
  Aside aside_;  // last: its thread ends first
};

}  // namespace hapticd
