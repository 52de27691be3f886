#include "rt/cycle/realtime.h"

#include <alloca.h>
#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#if defined(__SSE2__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

namespace hapticd {
namespace {

std::string limitText(__rlimit_resource resource) {
  rlimit limit{};
  getrlimit(resource, &limit);
  return limit.rlim_cur == RLIM_INFINITY ? "unlimited" : std::to_string(limit.rlim_cur);
}

}  // namespace

Result<void> becomeRealtime(int priority) {
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

void disableDenormals() noexcept {
#if defined(__SSE2__)
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
}

DenormalsAsZero::DenormalsAsZero(bool on) noexcept {
#if defined(__SSE2__)
  constexpr unsigned kBits = _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON;
  before_ = _mm_getcsr();
  _mm_setcsr(on ? before_ | kBits : before_ & ~kBits);
#else
  (void)on;
#endif
}

DenormalsAsZero::~DenormalsAsZero() {
#if defined(__SSE2__)
  _mm_setcsr(before_);
#endif
}

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
