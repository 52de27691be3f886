/** @file
 * Built meshes with their volumes on disk, so that what was built once is there at once the next time.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "daemon/ipc/cached_build.h"
#include "daemon/ipc/unique_fd.h"
#include "daemon/scene/mesh/vdb_maker.h"
#include "rt/base/error.h"

namespace hapticd {

/** What the builder made of an upload. The memfds are sealed; not yet trusted. */
struct CachedBuild {
  UniqueFd snapshot, volume;
  std::vector<std::string> notes;
};

/** A volume on disk. */
struct CachedVolume {
  std::string key;
  std::uint64_t bytes = 0;      ///< Of ours.
  std::uint64_t vdb_bytes = 0;  ///< Of the OpenVDB file beside it; 0: there is none.
  double unused_s = 0;          ///< Since it was made or found.
};

/**
 * One file for each upload in a directory of the daemon's own, and beside it, if asked for, the volume as an OpenVDB
 * file, which comes later and is never read here. A file that is damaged, of another version or of another user's
 * upload is not found. Control thread only, but for find(); writing is done by threads of its own, one file at a time.
 */
class VolumeCache {
 public:
  static constexpr std::size_t kMostVolumes = 1000;        ///< list() looks at each.
  static constexpr std::int64_t kStop_ns = 1'000'000'000;  ///< Of the five seconds that systemd gives the daemon.

  /**
   * Beyond `most_bytes`, or kMostVolumes, those longest unused go with what is beside them; one that is larger is not
   * kept. The directory is made if need be; what a daemon that died had begun to write is removed. With `vdb` OpenVDB
   * files are made, also of what is found without one.
   */
  VolumeCache(std::string directory, std::uint64_t most_bytes, std::optional<VdbOptions> vdb = {});
  /** As stop(), which may have come before. */
  ~VolumeCache();
  VolumeCache(const VolumeCache&) = delete;
  VolumeCache& operator=(const VolumeCache&) = delete;

  /** Names an upload of a user: its checksum, its size, the user, and the versions of forms and builder. */
  [[nodiscard]] static std::string keyOf(std::span<const std::byte> upload, std::uint32_t uid);

  /** Read whole into new memfds; about 1 ms for each 2 MB that the kernel has in memory. Any thread. */
  [[nodiscard]] std::optional<CachedBuild> find(const std::string& key);
  /** Forgets it: what was found did not pass the checks. */
  void drop(const std::string& key);
  /**
   * Written under another name and renamed when whole, after those that wait already; while these are too many, it is
   * not kept, and the log says so.
   */
  void keep(const std::string& key, UniqueFd snapshot, UniqueFd volume, const std::vector<std::string>& notes);
  /**
   * The daemon ends: nothing is found any more, what waits to be written is not kept, nor what is being written then if
   * it takes longer than `patience_ns`. Both hear it between two parts of a file, however slow the disk.
   */
  void stop(std::int64_t patience_ns = kStop_ns) noexcept;
  [[nodiscard]] const std::string& directory() const { return directory_; }
  /** Why the last one could not be kept there, or none can be; nothing once one is, or the cause is seen to be gone. */
  [[nodiscard]] std::optional<Error> trouble();
  /** Those longest unused first. */
  [[nodiscard]] std::vector<CachedVolume> list() const;
  /**
   * Its OpenVDB file, to be read. kWouldBlock while it is being made, kNotFound if there is none, kUnsupported where
   * none are made.
   */
  [[nodiscard]] Result<UniqueFd> openVdb(const std::string& key);
  /** Until what is being written is there; with its OpenVDB file. */
  void wait();

 private:
  [[nodiscard]] std::string pathOf(const std::string& key) const { return directory_ + "/" + key + ".hvol"; }
  [[nodiscard]] std::string vdbOf(const std::string& key) const { return directory_ + "/" + key + kCachedVdbEnding; }
  /** To be written. */
  struct Job {
    std::string key, notes;
    UniqueFd snapshot, volume;
    std::uint64_t bytes = 0;
  };
  /** These hold descriptors, and memory that counts for nobody once their mesh is dropped. */
  static constexpr std::size_t kMostJobs = 16;
  static constexpr std::uint64_t kMostJobBytes = 256'000'000;
  static constexpr std::int64_t kNever = INT64_MAX;
  [[nodiscard]] bool isWaiting(const std::string& key);
  [[nodiscard]] bool mayWrite() const noexcept;
  void awaitWriter();
  /** The writing thread: until nothing waits. */
  void write() noexcept;
  void store(const Job& job);
  /** `number`: of the system's error. */
  void notKept(Error why, int number, std::uint64_t bytes);
  struct Trouble {
    Error why;
    int number = 0;           ///< Of the system's error.
    std::uint64_t bytes = 0;  ///< That were to be kept.
  };
  [[nodiscard]] bool isGone(const Trouble& trouble) const;
  void prune();

  std::string directory_;
  std::uint64_t most_bytes_;
  std::atomic<std::int64_t> stop_ns_{kNever};  ///< Until then something may be written.
  std::thread writer_;                         ///< Runs, or is about to end, while there are jobs.
  std::mutex mutex_;
  std::deque<Job> jobs_;             ///< Under the mutex, but for what the writer does with the first.
  std::optional<Trouble> trouble_;   ///< Under the mutex.
  std::mutex pruning_;               ///< One thread at a time.
  std::unique_ptr<VdbMaker> maker_;  ///< Null: none are made. Last, so that its thread ends first.
};

}  // namespace hapticd
