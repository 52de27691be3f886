#include "tests/support/detectors.h"

#include <dlfcn.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <ostream>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}

namespace hapticd::test {
namespace {

// Initial-exec: reading them never allocates.
thread_local bool t_open __attribute__((tls_model("initial-exec"))) = false;
thread_local RtViolations t_seen __attribute__((tls_model("initial-exec")));

void countAllocation() noexcept {
  if (t_open) ++t_seen.allocations;
}
void countLock() noexcept {
  if (t_open) ++t_seen.locks;
}

std::uint64_t threadFaults() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return static_cast<std::uint64_t>(usage.ru_minflt) + static_cast<std::uint64_t>(usage.ru_majflt);
}

void onTrappedCall(int, siginfo_t* info, void* context) noexcept {
  if (t_open) {
    ++t_seen.system_calls;
    t_seen.last_system_call = info->si_syscall;
  }
  // The kernel skipped the call; without this the caller would read the call's number as its result.
  static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RAX] = -ENOSYS;
}

/** The next definition of an interposed function. */
template <class F>
F next(const char* name) noexcept {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const RtViolations& v) {
  return out << v.allocations << " allocations, " << v.locks << " locks, " << v.faults << " faults, " << v.system_calls
             << " system calls (last " << v.last_system_call << ")";
}

RtScope::RtScope() noexcept {
  faults_before_ = threadFaults();
  t_seen = RtViolations{};
  t_open = true;
}

RtScope::~RtScope() { t_open = false; }

RtViolations RtScope::finish() noexcept {
  if (!finished_) {
    t_open = false;
    finished_ = true;
    t_seen.faults = threadFaults() - faults_before_;
  }
  return t_seen;
}

bool trapSystemCalls() noexcept {
  struct sigaction action {};
  action.sa_sigaction = onTrappedCall;
  action.sa_flags = SA_SIGINFO | SA_NODEFER;
  if (sigaction(SIGSYS, &action, nullptr) != 0) return false;
#define HD_ALLOW(number) BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, number, 0, 1), BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      HD_ALLOW(SYS_clock_nanosleep),
      HD_ALLOW(SYS_clock_gettime),
      HD_ALLOW(SYS_getrusage),
      HD_ALLOW(SYS_rt_sigreturn),
      HD_ALLOW(SYS_exit),
      HD_ALLOW(SYS_exit_group),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
  };
#undef HD_ALLOW
  const sock_fprog filter{static_cast<unsigned short>(sizeof program / sizeof program[0]), program};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

}  // namespace hapticd::test

// The interposed functions. operator new and delete end in malloc and free.
extern "C" {

void* malloc(std::size_t n) {
  hapticd::test::countAllocation();
  return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t size) {
  hapticd::test::countAllocation();
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t n) {
  hapticd::test::countAllocation();
  return __libc_realloc(p, n);
}
void free(void* p) {
  if (p != nullptr) hapticd::test::countAllocation();
  __libc_free(p);
}
void* memalign(std::size_t alignment, std::size_t n) {
  hapticd::test::countAllocation();
  return __libc_memalign(alignment, n);
}
void* aligned_alloc(std::size_t alignment, std::size_t n) { return memalign(alignment, n); }
int posix_memalign(void** p, std::size_t alignment, std::size_t n) {
  *p = memalign(alignment, n);
  return *p == nullptr ? ENOMEM : 0;
}

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  using F = int (*)(pthread_mutex_t*);
  static const F real = hapticd::test::next<F>("pthread_mutex_lock");
  hapticd::test::countLock();
  return real(mutex);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* lock) {
  using F = int (*)(pthread_rwlock_t*);
  static const F real = hapticd::test::next<F>("pthread_rwlock_rdlock");
  hapticd::test::countLock();
  return real(lock);
}
int pthread_rwlock_wrlock(pthread_rwlock_t* lock) {
  using F = int (*)(pthread_rwlock_t*);
  static const F real = hapticd::test::next<F>("pthread_rwlock_wrlock");
  hapticd::test::countLock();
  return real(lock);
}
int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  using F = int (*)(pthread_cond_t*, pthread_mutex_t*);
  static const F real = hapticd::test::next<F>("pthread_cond_wait");
  hapticd::test::countLock();
  return real(condition, mutex);
}
int sem_wait(sem_t* semaphore) {
  using F = int (*)(sem_t*);
  static const F real = hapticd::test::next<F>("sem_wait");
  hapticd::test::countLock();
  return real(semaphore);
}
}
