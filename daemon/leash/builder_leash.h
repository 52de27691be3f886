/** @file
 * The daemon's hold on hapticd-builder: the unprivileged process that parses uploaded meshes and builds snapshots.
 *
 * The builder reads hostile data, so it is small, limited and not trusted: what it sends back is checked like any
 * client's memory (openSnapshot() in snapshot_memory.h). Its crash is an Error of the job it ran; the next job starts a
 * new builder. Jobs run one after the other: each client's in the order of submit(), and each client has its turn.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/ipc/build_stats.h"
#include "daemon/ipc/unique_fd.h"
#include "proto/snapshot.h"
#include "rt/base/error.h"

namespace hapticd {

struct BuilderOptions {
  std::string program;                           ///< Path of hapticd-builder; see findBuilder().
  std::uint64_t memory_bytes = 2'147'483'648;    ///< Address space of the builder. Beyond it a job fails.
  std::int64_t job_timeout_ns = 60'000'000'000;  ///< A job that takes longer is ended and fails.
};

/** One message about one job. The last one of a job is kDone or kFailed. */
struct BuildReport {
  enum class Kind { kProgress, kDone, kFailed };
  Kind kind = Kind::kProgress;
  std::uint64_t job = 0;
  float fraction = 0;              ///< kProgress: 0 to 1, never falling.
  std::string stage;               ///< kProgress: what it does now.
  UniqueFd snapshot;               ///< kDone: hand it to openSnapshot(). Not yet trusted.
  UniqueFd volume;                 ///< kDone, if the upload asked for it: hand it to openVolume(). Not yet trusted.
  BuildStats stats;                ///< kDone
  std::vector<std::string> notes;  ///< kDone: repairs, each naming its triangle.
  Error error;                     ///< kFailed
};

/** Control thread only. Never blocks. */
class BuilderLeash {
 public:
  /**
   * Starts the builder. kBuilderFailed if the program is not there or does not start.
   * It is spawned without copying this process (vfork), so a restart under locked memory disturbs no thread.
   */
  [[nodiscard]] static Result<std::unique_ptr<BuilderLeash>> start(const BuilderOptions& options);
  /** Ends the builder; jobs not yet reported are dropped. */
  ~BuilderLeash();
  BuilderLeash(const BuilderLeash&) = delete;
  BuilderLeash& operator=(const BuilderLeash&) = delete;

  /** Readable when next() has something. The same descriptor for life, through restarts. */
  [[nodiscard]] int fd() const noexcept;

  /**
   * Queues a build of an upload memfd (sealed Seals::kFrozen; the leash keeps its own descriptor) and returns the job's
   * number, rising from 1. Failures come as a report.
   */
  [[nodiscard]] Result<std::uint64_t> submit(int upload_fd, std::uint64_t client = 0);

  /** The job ends with a kFailed report of kCancelled. Unknown and finished jobs are ignored. */
  void cancel(std::uint64_t job) noexcept;

  /** Who closes descriptors of large memory that nobody needs any more; else they are closed here, which takes its
   * time.
   */
  void onSpent(std::function<void(UniqueFd)> close);

  /** Fills `report` and returns true, or returns false when there is nothing now. Call until false. */
  [[nodiscard]] bool next(BuildReport& report);

  /** Process id of the builder now running, 0 if none. */
  [[nodiscard]] int pid() const noexcept;
  /** Builders started after the first one. */
  [[nodiscard]] std::uint32_t restarts() const noexcept;
  /** Why the last builder ended, or did not start, without a word: it may be another program. Empty: it speaks. */
  [[nodiscard]] const std::string& trouble() const noexcept;

 private:
  struct State;
  explicit BuilderLeash(std::unique_ptr<State> state) noexcept;
  std::unique_ptr<State> state_;
};

}  // namespace hapticd
