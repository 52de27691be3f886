#include "rt/cycle/realtime.h"

#include <alloca.h>
#include <fcntl.h>
#include <limits.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

namespace hapticd {
namespace {

// Reads and sets this thread's floating-point control word, and its bits that flush denormals to zero.
#if defined(__SSE2__)
constexpr std::uint64_t kZeroDenormals = _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON;
std::uint64_t arithmetic() noexcept { return _mm_getcsr(); }
void setArithmetic(std::uint64_t word) noexcept { _mm_setcsr(static_cast<unsigned>(word)); }
#elif defined(__aarch64__)
constexpr std::uint64_t kZeroDenormals = 1u << 24;  // FPCR.FZ is both.
std::uint64_t arithmetic() noexcept {
  std::uint64_t word;
  asm volatile("mrs %0, fpcr" : "=r"(word));
  return word;
}
void setArithmetic(std::uint64_t word) noexcept { asm volatile("msr fpcr, %0" ::"r"(word)); }
#else
constexpr std::uint64_t kZeroDenormals = 0;
std::uint64_t arithmetic() noexcept { return 0; }
void setArithmetic(std::uint64_t) noexcept {}
#endif

std::string limitText(__rlimit_resource resource) {
  rlimit limit{};
  getrlimit(resource, &limit);
  return limit.rlim_cur == RLIM_INFINITY ? "unlimited" : std::to_string(limit.rlim_cur);
}

}  // namespace

Result<void> becomeRealtime(int priority) {
#if defined(__SANITIZE_THREAD__)
  // The sanitizer's own locks are spun for: a FIFO thread would starve the lower one that holds what it waits for.
  return Error{ErrorCode::kNoRealtime, "SCHED_FIFO priority " + std::to_string(priority),
               "the thread sanitizer does not bear it", "take a build without it"};
#endif
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters);
  if (refused == 0) return {};
  return Error{ErrorCode::kNoRealtime, "SCHED_FIFO priority " + std::to_string(priority),
               std::string(std::strerror(refused)) + ", RLIMIT_RTPRIO is " + limitText(RLIMIT_RTPRIO),
               "have '@haptic - rtprio 85' in /etc/security/limits.d/hapticd.conf and log in as a member of group "
               "haptic, or start the service instead"};
}

Result<void> lockMemory() {
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  if (mlockall(MCL_CURRENT) == 0) return {};
  const int refused = errno;
  return Error{
      ErrorCode::kNoRealtime, "mlockall",
      std::string(std::strerror(refused)) + ", RLIMIT_MEMLOCK is " + limitText(RLIMIT_MEMLOCK) + " bytes",
      "have '@haptic - memlock 1048576' in /etc/security/limits.d/hapticd.conf and log in as a member of group "
      "haptic, or start the service instead"};
}

void disableDenormals() noexcept { setArithmetic(arithmetic() | kZeroDenormals); }

DenormalsAsZero::DenormalsAsZero(bool on) noexcept : before_(arithmetic()) {
  setArithmetic(on ? before_ | kZeroDenormals : before_ & ~kZeroDenormals);
}

DenormalsAsZero::~DenormalsAsZero() { setArithmetic(before_); }

void prefaultStack(std::size_t bytes) noexcept {
  const long page = sysconf(_SC_PAGESIZE);
  auto* stack = static_cast<volatile unsigned char*>(alloca(bytes));
  for (std::size_t i = 0; i < bytes; i += static_cast<std::size_t>(page)) stack[i] = 0;
}

CpuLatencyHold::~CpuLatencyHold() {
  if (fd_ >= 0) close(fd_);
}

Result<void> CpuLatencyHold::hold() {
  if (held()) return {};
  const int fd = open("/dev/cpu_dma_latency", O_RDWR | O_CLOEXEC);
  const std::int32_t microseconds = 0;
  if (fd >= 0 && write(fd, &microseconds, sizeof microseconds) == sizeof microseconds) {
    fd_ = fd;
    return {};
  }
  const int refused = errno;
  if (fd >= 0) close(fd);
  return Error{
      ErrorCode::kNoRealtime, "/dev/cpu_dma_latency", std::strerror(refused),
      "install hapticd's udev rules and join group haptic: until then the CPU may sleep deeply between cycles"};
}

Result<void> RtThread::start(const char* name, std::size_t stack_bytes, std::function<void()> body) {
  body_ = std::move(body);
#if defined(__SANITIZE_THREAD__)
  stack_bytes += std::size_t{2} << 20;  // The sanitizer's thread-local storage lies on the thread's stack.
#endif
  stack_bytes = std::max(stack_bytes, static_cast<std::size_t>(PTHREAD_STACK_MIN));  // 128 KiB on arm64.
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, stack_bytes);
  const int refused = pthread_create(&thread_, &attributes, &RtThread::entry, this);
  pthread_attr_destroy(&attributes);
  if (refused != 0) {
    return Error{ErrorCode::kSystem, std::string("thread ") + name, std::strerror(refused),
                 "raise the limit of tasks (TasksMax, RLIMIT_NPROC) or of locked memory"};
  }
  started_ = true;
  pthread_setname_np(thread_, name);
  return {};
}

void* RtThread::entry(void* self) {
  static_cast<RtThread*>(self)->body_();
  return nullptr;
}

void RtThread::join() noexcept {
  if (!started_) return;
  pthread_join(thread_, nullptr);
  started_ = false;
}

}  // namespace hapticd
