/** @file
 * Detectors of what real-time code must not do. They are linked into one program (test_realtime) whose malloc and
 * pthread locks are interposed; plain build only: AddressSanitizer would count nothing, ThreadSanitizer would crash.
 *
 *   RtScope scope;                // this thread is now held to contract 1
 *   servo.runOnce();
 *   EXPECT_EQ(scope.finish(), RtViolations{});
 */
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <iosfwd>
#include <thread>

namespace hapticd::test {

/** What happened on this thread inside a scope. */
struct RtViolations {
  std::uint64_t allocations = 0;   ///< malloc, free and their family, operator new.
  std::uint64_t locks = 0;         ///< Mutex, condition, rwlock, semaphore waits.
  std::uint64_t faults = 0;        ///< Page faults, minor and major.
  std::uint64_t system_calls = 0;  ///< Outside the allow-list; only after trapSystemCalls().
  int last_system_call = -1;       ///< Number of the last of them.

  bool operator==(const RtViolations&) const = default;
};
std::ostream& operator<<(std::ostream& out, const RtViolations& v);

/** Counts from construction to finish(). Not nested, one thread. */
class RtScope {
 public:
  RtScope() noexcept;
  ~RtScope();
  RtScope(const RtScope&) = delete;
  RtScope& operator=(const RtScope&) = delete;
  RtViolations finish() noexcept;

 private:
  std::uint64_t faults_before_ = 0;
  bool finished_ = false;
};

/**
 * From now on every system call of this thread but clock_gettime, clock_nanosleep, getrusage, rt_sigreturn and exit
 * raises SIGSYS, is counted when a scope is open, and returns -ENOSYS. Cannot be undone: use a thread of its own.
 * False when the kernel has no seccomp.
 */
[[nodiscard]] bool trapSystemCalls() noexcept;

/** `warmUp` brings in pages; then nothing of all that may happen in `run`. On a thread of its own. */
template <class WarmUp, class Run>
void expectClean(WarmUp&& warmUp, Run&& run) {
  RtViolations seen;
  bool trapped = false;
  std::thread([&] {
    warmUp();
    trapped = trapSystemCalls();
    RtScope scope;
    run();
    seen = scope.finish();
  }).join();
  EXPECT_TRUE(trapped);
  EXPECT_EQ(seen, RtViolations{});
}

}  // namespace hapticd::test
