// A detector that finds nothing proves nothing: each one first catches a planted violation.
#include "tests/support/detectors.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <mutex>
#include <thread>
#include <vector>

namespace hapticd::test {
namespace {

TEST(Detectors, CleanCodeIsClean) {
  volatile int x = 0;
  RtScope scope;
  for (int i = 0; i < 1000; ++i) x = x + i;
  EXPECT_EQ(scope.finish(), RtViolations{});
}

TEST(Detectors, CatchAnAllocation) {
  RtScope scope;
  auto* volatile planted = new std::vector<int>(100);  // Else a compiler may leave it out.
  delete planted;
  EXPECT_GE(scope.finish().allocations, 4u);
}

TEST(Detectors, CatchALock) {
  std::mutex mutex;
  RtScope scope;
  mutex.lock();
  mutex.unlock();
  EXPECT_EQ(scope.finish().locks, 1u);
}

TEST(Detectors, CatchAFault) {
  constexpr std::size_t kBytes = 16 * 4096;
  auto* page =
      static_cast<volatile char*>(mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(static_cast<volatile void*>(page), MAP_FAILED);
  RtScope scope;
  page[0] = 1;
  const RtViolations seen = scope.finish();
  munmap(const_cast<char*>(page), kBytes);
  EXPECT_GE(seen.faults, 1u);
}

TEST(Detectors, CatchASystemCall) {
  RtViolations seen;
  long answer = 0;
  int error = 0;
  std::thread([&] {
    ASSERT_TRUE(trapSystemCalls());
    RtScope scope;
    answer = syscall(SYS_getppid);
    error = errno;
    seen = scope.finish();
  }).join();
  EXPECT_EQ(seen.system_calls, 1u);
  EXPECT_EQ(seen.last_system_call, SYS_getppid);
  EXPECT_EQ(answer, -1);
  EXPECT_EQ(error, ENOSYS);
}

TEST(Detectors, AllowTheClock) {
  RtViolations seen{1, 1, 1, 1, 1};
  std::thread([&] {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    ASSERT_TRUE(trapSystemCalls());
    RtScope scope;
    clock_gettime(CLOCK_MONOTONIC, &t);
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
    seen = scope.finish();
  }).join();
  EXPECT_EQ(seen, RtViolations{});
}

}  // namespace
}  // namespace hapticd::test
