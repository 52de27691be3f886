/** @file
 * Real-time rights: scheduling, memory locking, denormals, CPU idle latency. Called at start, outside the deadline.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <thread>

#include "rt/base/error.h"

namespace hapticd {

/** SCHED_FIFO at `priority` with SCHED_RESET_ON_FORK for the calling thread. kNoRealtime says which right is missing; a
 * build with the thread sanitizer always refuses.
 */
[[nodiscard]] Result<void> becomeRealtime(int priority);

/** mlockall(MCL_CURRENT), malloc kept from returning memory. kNoRealtime with the limit and the need. */
[[nodiscard]] Result<void> lockMemory();

/** Flush-to-zero and denormals-are-zero for the calling thread. */
void disableDenormals() noexcept;

/** Denormals as zero, or not, for the calling thread while it lives; then as before. */
class DenormalsAsZero {
 public:
  explicit DenormalsAsZero(bool on) noexcept;
  DenormalsAsZero(const DenormalsAsZero&) = delete;
  DenormalsAsZero& operator=(const DenormalsAsZero&) = delete;
  ~DenormalsAsZero();

 private:
  std::uint64_t before_;
};

/** Touches `bytes` of the calling thread's stack so that it never faults later. */
void prefaultStack(std::size_t bytes) noexcept;

/** Holds /dev/cpu_dma_latency at 0 while it lives. */
class CpuLatencyHold {
 public:
  CpuLatencyHold() noexcept = default;
  CpuLatencyHold(const CpuLatencyHold&) = delete;
  CpuLatencyHold& operator=(const CpuLatencyHold&) = delete;
  ~CpuLatencyHold();
  [[nodiscard]] Result<void> hold();
  [[nodiscard]] bool held() const noexcept { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

/** A thread with a stack of `stack_bytes`, joined on destruction. */
class RtThread {
 public:
  RtThread() noexcept = default;
  RtThread(const RtThread&) = delete;
  RtThread& operator=(const RtThread&) = delete;
  ~RtThread() { join(); }
  /** Starts `body` on a new thread named `name` (15 bytes). */
  [[nodiscard]] Result<void> start(const char* name, std::size_t stack_bytes, std::function<void()> body);
  void join() noexcept;
  [[nodiscard]] bool running() const noexcept { return started_; }

 private:
  static void* entry(void* self);
  pthread_t thread_{};
  bool started_ = false;
  std::function<void()> body_;
};

}  // namespace hapticd
