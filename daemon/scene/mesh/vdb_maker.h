/** @file
 * OpenVDB files beside those of the volume cache, made by a process in a sandbox after ours is in its place.
 */
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "daemon/ipc/unique_fd.h"

namespace hapticd {

struct VdbOptions {
  std::string program;                             ///< Path of hapticd-builder-vdb.
  std::uint64_t memory_bytes = UINT64_C(1) << 31;  ///< Its address space.
  std::int64_t timeout_ns = 60'000'000'000;        ///< Of one file.
};

/**
 * One after the other, in a thread that waits for the process. A file that cannot be made (no memory, no room on the
 * disk, too late) is told in the log and left out until the next start; what was begun is removed. The daemon never
 * reads what is made.
 */
class VdbMaker {
 public:
  /** `made` is called in the maker's thread when a file has come. */
  VdbMaker(VdbOptions options, std::function<void()> made);
  /** Ends the process; what it had begun is removed. */
  ~VdbMaker();
  VdbMaker(const VdbMaker&) = delete;
  VdbMaker& operator=(const VdbMaker&) = delete;

  /**
   * Has the file `vdb` made of the cache's file `cached`, unless it waits already or, of the same file, failed before.
   * Any thread.
   */
  void want(const std::string& cached, const std::string& vdb, bool fresh);
  /** Whether it waits or is being made. Any thread. */
  [[nodiscard]] bool waits(const std::string& vdb);
  /** Until nothing waits. */
  void wait();

 private:
  struct Job {
    std::string cached, vdb;
  };
  [[nodiscard]] bool isStopping();
  [[nodiscard]] bool isWaiting(const std::string& vdb) const;  ///< Under the lock.
  void work();
  /** False if it could not be made. */
  bool make(const Job& job);
  /** What became of a process: empty if all went well; nothing if we are to stop. */
  std::optional<std::string> await(int pid);

  VdbOptions options_;
  std::function<void()> made_;
  UniqueFd stop_;  ///< Readable when it is to end.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;          ///< The first is being made.
  std::set<std::string> failed_;  ///< Not to be tried again.
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace hapticd
