#include "rt/base/clock.h"

#include <cerrno>
#include <ctime>

namespace hapticd {
namespace {
constexpr std::int64_t kNsPerS = 1'000'000'000;
}

std::int64_t MonotonicClock::now() HD_RT {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kNsPerS + t.tv_nsec;
}

void MonotonicClock::sleepUntil(std::int64_t t_ns) HD_RT {
  const timespec t{t_ns / kNsPerS, static_cast<long>(t_ns % kNsPerS)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace hapticd
